"""Alternate minimization: the displacement, then the damage, until neither moves the other."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from staffa.stack import PETSc

import numpy as np

from staffa.errors import SolveError
from staffa.minimize.bounded import BoundedEnergy, BoundedSolver, unbalanced
from staffa.minimize.elastic import ElasticSolver
from staffa.records import Energies, Outcome, Stop


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """What a watcher sees after each sweep."""

    number: int
    energies: Energies
    change: float
    residual: float


@dataclass(frozen=True, kw_only=True)
class Alternation:
    """The two halves of the problem, and the energy they share.

    `bounded` holds the default solver of the damage and its fall-backs, in the order they are
    tried. `keep_u(u)` makes u the displacement at which energies and the damage's forces are
    evaluated. Vectors `u` and `alpha` are overwritten. Everything is collective.
    """

    elastic: ElasticSolver
    damage: BoundedEnergy
    bounded: Sequence[BoundedSolver]
    energies: Callable[[], Energies]
    keep_u: Callable[[PETSc.Vec], None]
    u: PETSc.Vec
    alpha: PETSc.Vec
    before: PETSc.Vec
    work: PETSc.Vec


def alternate(
    problem: Alternation,
    values: np.ndarray,
    lower: PETSc.Vec,
    upper: PETSc.Vec,
    stop: Stop,
    watch: Callable[[Sweep], None] = lambda sweep: None,
) -> Outcome:
    """Minimize over the damage and the displacement in turn, from a state in `equilibrium`.

    The displacement is solved for last, so that the state returned is in equilibrium too, and the
    damage's forces on it are the first-order residual of the whole problem. Collective.

    Parameters
    ----------
    values : prescribed displacements, see `ElasticSolver.minimize`.
    lower, upper : bounds of the damage, that hold at its first value.

    Raises
    ------
    SolveError
        A linear solver failed, or every damage solver did. Running out of sweeps raises nothing:
        the outcome says so.
    """
    energies = problem.energies()
    change, largest_rise, fallbacks = float("inf"), 0.0, 0
    for number in range(stop.sweeps + 1):
        residual = unbalanced(problem.damage, problem.alpha, lower, upper, problem.work)
        if number:
            watch(Sweep(number=number, energies=energies, change=change, residual=residual))
        converged = change <= stop.change and residual <= stop.residual
        if converged or number == stop.sweeps:
            break
        problem.alpha.copy(problem.before)
        fallbacks += _minimize_damage(problem, lower, upper)
        problem.before.axpy(-1.0, problem.alpha)
        change = problem.before.norm(PETSc.NormType.NORM_INFINITY)
        half = problem.damage.value()
        equilibrium(problem, values)
        after = problem.energies()
        if not np.isfinite(after.total):
            raise SolveError(
                "the energy is not finite after the displacement was solved for; try a shorter "
                "time step or a larger damage.residual_stiffness"
            )
        rise = max(half - energies.total, after.total - half)
        largest_rise = max(largest_rise, rise / max(abs(energies.total), abs(after.total), 1e-300))
        energies = after
    return Outcome(
        converged=converged,
        reason=_reason(converged, number, change, residual, stop),
        sweeps=number,
        change=float(change),
        residual=float(residual),
        largest_rise=float(largest_rise),
        energies=energies,
        fallbacks=fallbacks,
    )


def equilibrium(problem: Alternation, values: np.ndarray) -> None:
    """Minimize over the displacement alone. Collective."""
    problem.elastic.minimize(problem.u, values)
    problem.keep_u(problem.u)


def _minimize_damage(problem: Alternation, lower: PETSc.Vec, upper: PETSc.Vec) -> int:
    """Minimize over the damage; how many solvers failed before one succeeded."""
    errors: list[str] = []
    for solver in problem.bounded:
        try:
            solver.minimize(problem.alpha, lower, upper)
            return len(errors)
        except SolveError as error:
            errors.append(str(error))
            problem.before.copy(problem.alpha)
    raise SolveError("; ".join(errors) + "; try a shorter time step or a larger damage.ell")


def _reason(converged: bool, sweeps: int, change: float, residual: float, stop: Stop) -> str:
    figures = f"damage changed by {change:.1e} in the last sweep, unbalanced force {residual:.1e}"
    if converged:
        return f"converged in {sweeps} sweeps: {figures}"
    return (
        f"not converged in {sweeps} sweeps: {figures}, against {stop.change:.0e} and "
        f"{stop.residual:.0e} asked for; try shorter time steps, a larger solver.sweeps, or "
        f"looser solver.change and solver.residual"
    )
