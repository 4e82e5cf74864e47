"""The second-order test of a step: a saddle is left, and the lowest state beside it kept."""

from dataclasses import replace
from functools import partial

import numpy as np

from staffa.errors import SolveError
from staffa.evolution.advance import Advance, agree, restore, snapshot
from staffa.evolution.problem import Problem
from staffa.evolution.settle import Loads, descend
from staffa.evolution.system import System
from staffa.fields import owned, read_vector, vertices, write_vector
from staffa.minimize.alternate import Watch, equilibrium
from staffa.minimize.bounded import AT_BOUND
from staffa.minimize.coupled import CoupledModel, destroy_pairs
from staffa.minimize.lanczos import Softest, softest
from staffa.minimize.newton import search
from staffa.records import Curvature

# Applications of the second derivative in a search that finds nothing.
ITERATIONS = 20
# A state is left so often in a step.
MOST = 10
# An energy lower by less than this fraction of it is not lower.
ROUND_OFF = 1e-10
# The damage of a state that is left is scattered by this fraction of itself.
SCATTER = 0.05


def tested(
    problem: Problem,
    system: System,
    loads: Loads,
    advance: Advance,
    watch: Watch = lambda sweep: None,
) -> Advance:
    """Search a converged state for a direction along which the energy falls, and follow it.

    From a state that is left the minimization goes on from several starts, and the lowest state is
    kept; then the search begins again. Collective.
    """
    rule, model = problem.second_order, system.alternation.model
    if rule is None or model is None:
        why = (
            'solver.stability = "none"'
            if rule is None
            else "the volume of the fluid in cracks is given, which the test does not know of"
        )
        return replace(advance, curvature=Curvature(reason=f"not tested: {why}"))
    for escapes in range(MOST + 1):
        way = _softest(problem, system, model, rule.tolerance)
        found = Curvature(
            smallest=None if way is None else way.value,
            iterations=0 if way is None else way.iterations,
            escapes=escapes,
        )
        if way is None or not len(way.b):
            return replace(advance, curvature=found)
        left, reason = None, f"left {MOST} times, and each time for a state like it"
        if escapes < MOST:
            left, reason = _left(problem, system, loads, advance, way, watch)
        if left is None:
            return replace(advance, curvature=replace(found, reason=f"kept: {reason}"))
        advance = left
    raise AssertionError


def _softest(
    problem: Problem, system: System, model: CoupledModel, tolerance: float
) -> Softest | None:
    """Search from a random start that depends on position alone. Collective."""
    parts, bounds = system.alternation, system.bounds
    read_vector(system.state.alpha, parts.alpha)
    start = model.pair()
    try:
        lower, upper = bounds.lower.x.petsc_vec, bounds.upper.x.petsc_vec
        model.move_to(parts.alpha, lower, upper, start)
        force_u, force_alpha = start.getNestSubVecs()
        force_u.set(0.0)
        force_alpha.array_w[:] = _scattered(problem, system) * parts.damage.unit.array_r
        force_alpha.array_w[model.held] = 0.0
        return softest(model, start, iterations=ITERATIONS, tolerance=tolerance)
    finally:
        destroy_pairs(start)


def _scattered(problem: Problem, system: System) -> np.ndarray:
    """Numbers between -1 and 1 at owned vertices that look random, a function of position alone."""
    x = vertices(system.state.alpha.function_space)[: len(owned(system.state.alpha))]
    waves = 43758.5453 * np.sin(x / problem.domain.h @ np.array([12.9898, 78.233, 37.719]))
    return 2 * (waves - np.floor(waves)) - 1


def _left(
    problem: Problem,
    system: System,
    loads: Loads,
    advance: Advance,
    way: Softest,
    watch: Watch,
) -> tuple[Advance | None, str]:
    """The lowest state reached from some starts beside this one, or why it was kept. Collective."""
    kept, before = snapshot(system), advance.outcome.energies.total
    if not _go(system, way):
        restore(system, kept)
        return None, "within its bounds the energy does not fall along it"
    ends = []
    for start in (partial(_go, system, way), partial(_scatter, problem, system)):
        restore(system, kept)
        start()
        try:
            equilibrium(system.alternation, loads.values)
            outcome, healing = descend(problem, system, loads, watch)
        except SolveError:
            continue
        advance = replace(advance, outcome=advance.outcome.then(outcome))
        if outcome.converged and outcome.energies.total < before:
            ends.append((outcome, healing, snapshot(system)))
    if not ends:
        restore(system, kept)
        return None, "no start beside it led to a lower state"
    outcome, healing, reached = min(ends, key=lambda end: end[0].energies.total)
    restore(system, reached)
    equilibrium(system.alternation, loads.values)
    outcome = replace(
        outcome,
        sweeps=advance.outcome.sweeps,
        effort=advance.outcome.effort,
        largest_rise=advance.outcome.largest_rise,
    )
    advance = replace(
        advance,
        outcome=outcome,
        healing=max(advance.healing, healing),
        released=advance.released + before - outcome.energies.total,
    )
    return agree(problem, system, loads, advance, watch), ""


def _go(system: System, way: Softest) -> bool:
    """Go along a direction, either way, within the bounds and as far as the energy falls.

    Damage that lies on a bound moves off it alone, and the displacement follows the damage.
    """
    bounds, alpha = system.bounds, owned(system.state.alpha)
    at_lower = alpha <= owned(bounds.lower) + AT_BOUND
    at_upper = alpha >= owned(bounds.upper) - AT_BOUND
    for sign in (1.0, -1.0):
        b = np.where(at_lower, np.maximum(sign * way.b, 0.0), sign * way.b)
        b = np.where(at_upper, np.minimum(b, 0.0), b)
        if go_along(system, sign * way.v, b):
            return True
    return False


def _scatter(problem: Problem, system: System) -> None:
    """Scatter the damage by position, within its bounds."""
    alpha, bounds = owned(system.state.alpha), system.bounds
    moved = alpha * (1 + SCATTER * _scattered(problem, system))
    parts = system.alternation
    parts.alpha.array_w[:] = np.clip(moved, owned(bounds.lower), owned(bounds.upper))
    write_vector(parts.alpha, system.state.alpha)


def go_along(system: System, v: np.ndarray, b: np.ndarray) -> bool:
    """Go along a direction within the bounds as far as the energy falls; False if it does not.

    Parameters
    ----------
    v, b : displacement and damage of the direction, owned entries. Collective.
    """
    parts, state, bounds = system.alternation, system.state, system.bounds
    u, alpha = owned(state.u).copy(), owned(state.alpha).copy()
    lower, upper = owned(bounds.lower), owned(bounds.upper)
    total = system.energy.total()

    def energy_at(t: float) -> float:
        parts.u.array_w[:] = u + t * v
        parts.alpha.array_w[:] = np.clip(alpha + t * b, lower, upper)
        write_vector(parts.u, state.u)
        write_vector(parts.alpha, state.alpha)
        return system.energy.total()

    taken, _ = search(energy_at, total - ROUND_OFF * abs(total))
    return taken > 0
