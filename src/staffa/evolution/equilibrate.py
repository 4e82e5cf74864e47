"""Minimization at fixed loads from frozen cracks, with a first guess from coarser cells."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from staffa.backend.parallel import max_over_ranks
from staffa.errors import SolveError
from staffa.evolution.problem import Irreversibility, Problem
from staffa.evolution.system import Coarser, System
from staffa.minimize.alternate import Watch, alternate, equilibrium
from staffa.minimize.bounded import projected_gradient
from staffa.model.fields import State, corners, owned, read_vector, write_vector
from staffa.records.step import Outcome, SolverStatistics

# Least damage at the center of a cell of a crack. In the nucleation on the slab of 120k unknowns
# 0.95 led to the lowest energies among 0.9, 0.95, 0.98 and none at all.
BROKEN = 0.95
# A guess that changes the damage or the energy (relatively) by less than this is dropped.
NO_GAIN, ROUND_OFF = 1e-4, 1e-10


@dataclass(frozen=True, kw_only=True)
class Loads:
    """Time with its prescribed displacements.

    Attributes
    ----------
    time : time (s).
    values : prescribed displacements (m), shape (n_fixed,).
    """

    time: float
    values: np.ndarray


def irreversible(rule: Irreversibility, alpha: np.ndarray) -> np.ndarray:
    """Return the irreversible part of a damage at each vertex."""
    if not rule.crack_set_only:
        return alpha
    return np.where(alpha >= rule.threshold, alpha, 0.0)


def raise_bounds(rule: Irreversibility, system: System) -> None:
    """Set the lower bound of the damage to its irreversible part."""
    system.bounds.lower.x.array[:] = irreversible(rule, system.state.alpha.x.array)


def settle(
    problem: Problem,
    system: System,
    loads: Loads,
    watch: Watch = lambda sweep: None,
    *,
    guess: bool = False,
    damage: np.ndarray | None = None,
) -> tuple[Outcome, float]:
    """Minimize from the frozen state. Collective.

    Parameters
    ----------
    problem : the problem.
    system : its system. If a try of the step on coarser cells came to some damage, it starts from
        that, if its energy is lower.
    loads : the current loads.
    watch : called after each sweep.
    guess : True to start from the result of a coarser mesh otherwise, if there is one and its
        energy is lower.
    damage : damage to start from, if it is above that of the frozen state; ghosts included, shape
        (n_local,); None for the frozen state.

    Returns
    -------
    outcome : outcome of the minimization.
    healing : irreversibility violation.
    """
    raise_bounds(problem.irreversibility, system)
    parts, guessed, before = system.alternation, SolverStatistics(), None
    if damage is not None:
        system.state.alpha.x.array[:] = np.maximum(damage, system.bounds.lower.x.array)
        equilibrium(parts, loads.values)
    elif system.tried is not None:
        before, gain = system.energy.total(), system.tried - system.state.alpha.x.array
        guessed = _first_guess(system, loads, lambda: (gain, SolverStatistics()))
    elif guess and system.coarser and _moves(problem, system):
        before = system.energy.total()
        coarse = partial(_coarse_gain, system.coarser, system.state, loads.time, watch)
        guessed = _first_guess(system, loads, coarse)
    outcome, healing = descend(problem, system, loads, watch)
    before = outcome.before if before is None else before
    return replace(outcome, before=before, effort=guessed + outcome.effort), healing


def descend(
    problem: Problem,
    system: System,
    loads: Loads,
    watch: Watch = lambda sweep: None,
) -> tuple[Outcome, float]:
    """Minimize from the current state in equilibrium, within the current bounds. Collective.

    Parameters
    ----------
    problem : the problem.
    system : its system.
    loads : the current loads.
    watch : called after each sweep.

    Returns
    -------
    outcome : outcome of the minimization.
    healing : irreversibility violation.
    """
    parts, state, bounds = system.alternation, system.state, system.bounds
    read_vector(state.alpha, parts.alpha)
    outcome = alternate(
        parts,
        loads.values,
        bounds.lower.x.petsc_vec,
        bounds.upper.x.petsc_vec,
        problem.solvers.stop,
        watch,
    )
    write_vector(parts.alpha, state.alpha)
    sunk = owned(bounds.lower) - owned(state.alpha)
    return outcome, max_over_ranks(problem.domain.comm, sunk)


def _moves(problem: Problem, system: System) -> bool:
    """Return True if the frozen damage would grow: below the strength a first guess is useless."""
    parts, bounds = system.alternation, system.bounds
    read_vector(system.state.alpha, parts.alpha)
    lower, upper = bounds.lower.x.petsc_vec, bounds.upper.x.petsc_vec
    force = projected_gradient(parts.damage, parts.alpha, lower, upper, parts.work)
    return bool(force > problem.solvers.stop.residual)


def _first_guess(
    system: System, loads: Loads, guess: Callable[[], tuple[np.ndarray, SolverStatistics]]
) -> SolverStatistics:
    """Add a guessed change to the damage, within its bounds, if that lowers the energy."""
    state, bounds, parts = system.state, system.bounds, system.alternation
    u, alpha, held = state.u.x.array.copy(), state.alpha.x.array.copy(), parts.held
    pressure = held.pressure() if held else 0.0
    before, effort = system.energy.total(), SolverStatistics()
    try:
        gain, effort = guess()
        if max_over_ranks(system.energy.comm, np.abs(gain)) <= NO_GAIN:
            return effort
        state.alpha.x.array[:] = np.clip(alpha + gain, bounds.lower.x.array, bounds.upper.x.array)
        equilibrium(parts, loads.values)
        if system.energy.total() < before - ROUND_OFF * abs(before):
            return effort + SolverStatistics(guesses=1)
    except SolveError:  # a guess may fail: the step continues without it
        pass
    state.u.x.array[:], state.alpha.x.array[:] = u, alpha
    if held:
        held.press(pressure)
    read_vector(state.u, parts.u)
    return effort + SolverStatistics(refused=1)


def _coarse_gain(
    coarser: Coarser,
    fine: State,
    time: float,
    watch: Watch = lambda sweep: None,
) -> tuple[np.ndarray, SolverStatistics]:
    """Return the growth of the damage in a step to these loads on the coarser mesh.

    A crack is a layer of broken cells. The damage interpolated at the coarser vertices may miss it:
    a coarser cell is broken if the damage at its center says so.
    """
    problem, system = coarser.problem, coarser.system
    state, alpha = system.state, fine.alpha.x.array.copy()
    start = np.clip(coarser.down(alpha), 0.0, 1.0)
    own = system.spaces.cell.dofmap.index_map.size_local
    broken = np.flatnonzero(coarser.middles(alpha)[:own] >= BROKEN)
    start[corners(system.spaces.alpha, broken)] = 1.0
    state.alpha.x.array[:] = start
    state.T.x.array[:] = coarser.down(fine.T.x.array)
    if coarser.problem.forces.fluid:
        state.p.x.array[:] = coarser.down(fine.p.x.array)
    system.energy.external.at(time)
    system.alternation.u.set(0.0)  # the rest of a failed solve is no first guess
    system.alternation.elastic.forget()  # nor is the last guess's factorization, in a resumed run
    loads = Loads(time=time, values=system.supports.values(time))
    equilibrium(system.alternation, loads.values)
    outcome, _ = settle(problem, system, loads, lambda sweep: watch(None), guess=True)
    below = outcome.effort
    return coarser.up(state.alpha.x.array - start), SolverStatistics(
        coarse_sweeps=below.coarse_sweeps + outcome.sweeps, fallbacks=below.fallbacks
    )
