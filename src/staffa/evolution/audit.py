"""Audit of a step: checks of what must be true, with the record of the step before."""

from collections.abc import Iterator
from dataclasses import dataclass

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np

from staffa.backend.parallel import max_over_ranks
from staffa.evolution.advance import BALANCE_ALLOWED, RISE_ALLOWED
from staffa.evolution.advanced_step import Advance
from staffa.evolution.coupling import ThermalState
from staffa.evolution.energy_gaps import relative_difference
from staffa.evolution.equilibrate import irreversible
from staffa.evolution.problem import Problem
from staffa.evolution.system import System
from staffa.minimize.bounded import projected_gradient
from staffa.model.fields import State, owned, read_vector
from staffa.physics.split import NO_SPLIT
from staffa.records.status import Verdict
from staffa.records.step import Audit, Curvature, Stability, Stop

# What round-off and the tolerances of the inner solvers can explain, and no more.
HEALING_ALLOWED = 1e-12
# Energies of one state, computed twice: with prestress as differences of what is a million times
# larger.
GAP_ALLOWED = 1e-8


@dataclass(frozen=True, kw_only=True)
class Before:
    """The state at the end of the step before, as it is on record.

    Attributes
    ----------
    alpha : damage at the vertices, ghosts included, shape (n_local,).
    thermal : thermal state.
    total : its energy; None where a checkpoint of an older version does not know it.
    """

    alpha: np.ndarray
    thermal: ThermalState
    total: float | None


def audit(
    problem: Problem,
    system: System,
    before: Before,
    advance: Advance,
    stability: Stability | None = None,
) -> Audit:
    """Check the current state and the step to it. Collective.

    Parameters
    ----------
    problem : the problem.
    system : its system.
    before : the recorded state before the step.
    advance : the step.
    stability : second-order conditions of the state, if they were computed.
    """
    outcome, state = advance.outcome, system.state
    healing = max(advance.healing, _healed(problem, before.alpha, state))
    gap = max(advance.gap, _gap(system, before, advance))
    residual = max(outcome.residual, _residual(system))
    return Audit(
        largest_rise=outcome.largest_rise,
        healing=max(healing, 0.0),
        optimality=residual,
        balance=advance.imbalance,
        work=advance.work,
        released=advance.released,
        renewed=advance.renewed,
        gap=gap,
        violations=(
            *_broken(advance, problem.solvers.stop, healing, residual, gap),
            *_heat(system, before, advance),
            *_second_order(advance.curvature, stability),
        ),
        notes=_pressed(problem, system, before),
    )


def _healed(problem: Problem, before: np.ndarray, state: State) -> float:
    """Return the largest decrease of irreversible damage since the step before."""
    n_owned = len(owned(state.alpha))
    sunk = irreversible(problem.irreversibility, before)[:n_owned] - owned(state.alpha)
    return max_over_ranks(problem.domain.comm, sunk)


def _gap(system: System, before: Before, advance: Advance) -> float:
    """Return the difference of the recorded energies from those of the first and last state."""
    outcome = advance.outcome
    ended = relative_difference(outcome.energies.total, system.energy.total(), outcome)
    if before.total is None or advance.began is None:
        return ended
    return max(ended, relative_difference(before.total, advance.began, outcome))


def _residual(system: System) -> float:
    """Return the first-order residual of the current state."""
    parts, bounds = system.alternation, system.bounds
    read_vector(system.state.alpha, parts.alpha)
    lower, upper = bounds.lower.x.petsc_vec, bounds.upper.x.petsc_vec
    return projected_gradient(parts.damage, parts.alpha, lower, upper, parts.work)


def _broken(
    advance: Advance, stop: Stop, healing: float, residual: float, gap: float
) -> tuple[str, ...]:
    """Return a sentence on each mechanical rule that is violated."""
    outcome, balance = advance.outcome, advance.imbalance
    checks = {
        f"the energy rose by {outcome.largest_rise:.1e} of itself in a half sweep": (
            outcome.largest_rise > RISE_ALLOWED
        ),
        f"irreversibility is violated by {healing:.1e}": healing > HEALING_ALLOWED,
        f"the energy balance is off by {balance:.1e} of the energy": balance > BALANCE_ALLOWED,
        f"a state is not the one on record: their energies differ by {gap:.1e}": gap > GAP_ALLOWED,
        f"the first-order residual is {residual:.1e}": (
            not outcome.converged or residual > stop.residual
        ),
    }
    return tuple(sentence for sentence, broken in checks.items() if broken)


def _heat(system: System, before: Before, advance: Advance) -> tuple[str, ...]:
    """Return a sentence on a temperature or heat that the heat equation does not explain."""
    heat = advance.all_heat
    if heat is None:
        return ()
    amiss = system.coupling.unaccounted(before.thermal, system.thermal.read(), heat)
    lost = max(heat.imbalance, amiss)
    if lost <= heat.allowed:
        return ()
    return (f"the heat that entered is not what was stored, by {lost:.1e} of it",)


def _pressed(problem: Problem, system: System, before: Before) -> tuple[str, ...]:
    """Return a sentence on rock that broke in compression without a split that prevents it."""
    if problem.material.split is not NO_SPLIT:
        return ()
    return system.pressed_growth.said(before.alpha)


def _second_order(curvature: Curvature | None, stability: Stability | None) -> Iterator[str]:
    """Yield a sentence on a saddle that was not left, and on a failed second-order test."""
    if curvature and curvature.verdict is Verdict.SADDLE:
        said = curvature.verdict.sentence
        yield f"{said} (curvature {curvature.smallest:.1e}): {curvature.reason}"
    if stability and stability.failure:
        yield f"its second order was not found: {stability.failure}"
