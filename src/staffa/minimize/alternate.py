"""Alternate minimization: the displacement, then the damage, until neither moves the other."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from staffa.backend.stack import PETSc

import numpy as np

from staffa.backend.vectors import readable, writable
from staffa.errors import SolveError
from staffa.minimize import convex
from staffa.minimize.bounded import BoundedEnergy, BoundedSolver, projected_gradient
from staffa.minimize.convex import ConvexEnergy, LinearCondition
from staffa.minimize.coupled import CoupledModel
from staffa.minimize.elastic import ElasticSolver
from staffa.minimize.linear import LARGEST_RESIDUAL
from staffa.minimize.newton import CoupledNewton
from staffa.minimize.patience import Patience
from staffa.records.status import Status
from staffa.records.step import CANCELED, Energies, Outcome, SolverStatistics, Stop

# Where Newton follows, an iterative solver of the displacement stops at this fraction of the
# force that it was given.
REDUCTION = 0.05
# Corrections of a displacement whose forces are not those of its supports.
CORRECTIONS = 3


@dataclass(frozen=True, kw_only=True)
class Sweep:
    """Result of one sweep, for a watcher.

    Attributes
    ----------
    number, energies : number of the sweep, from 1; energies after it (J; J/m in 2-D).
    change, residual : largest change of the damage in it; first-order residual after it.
    """

    number: int
    energies: Energies
    change: float
    residual: float


# Called after each sweep; with None after one of another problem, where a stop is all that counts.
Watch = Callable[[Sweep | None], None]


@dataclass(frozen=True, kw_only=True)
class Alternation:
    """Both halves of the problem, and their common energy. All functions are collective.

    Attributes
    ----------
    elastic, damage : solver of the displacement; energy as a function of the damage.
    bounded : solvers of the damage: the default, then its fall-backs in order.
    newton : proposes a move after each sweep; None for none.
    model : quadratic model of the energy; None if the volume of a fluid is given.
    convex : energy of the displacement, of which `elastic` solves the model; None if it is
        quadratic.
    held : the given volume of a fluid in cracks; None without.
    energies : returns the energies.
    keep_u : sets the displacement at which energies and derivatives are evaluated.
    forces : fills the derivative in u there.
    u, alpha, before, work : displacement, damage, and work vectors of the damage; overwritten.
    """

    elastic: ElasticSolver
    damage: BoundedEnergy
    bounded: Sequence[BoundedSolver]
    newton: CoupledNewton | None
    model: CoupledModel | None
    convex: ConvexEnergy | None
    held: LinearCondition | None
    energies: Callable[[], Energies]
    keep_u: Callable[[PETSc.Vec], None]
    forces: Callable[[PETSc.Vec], None]
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
    watch: Watch = lambda sweep: None,
) -> Outcome:
    """Minimize over the damage and the displacement in turn, from a state in `equilibrium`.

    The displacement is solved last, so that the returned state is in equilibrium too, and the
    projected gradient of the damage is the first-order residual of the whole problem. Between
    sweeps Newton moves both together, if that lowers the energy. The stop is judged by a sweep
    without such a move, from equilibrium to equilibrium. Collective.

    Parameters
    ----------
    problem : both halves of the problem.
    values : prescribed displacements (m), see `ElasticSolver.minimize`.
    lower, upper : bounds of the damage, which hold at its first value.
    stop, watch : tolerances, and the largest number of sweeps; called after each sweep.

    Raises
    ------
    SolveError
        A linear solver failed, or every damage solver did, or the energy is not finite. Running
        out of sweeps is no error: the outcome reports it.
    """
    # Another pressure of a fluid whose volume is given is another energy of the damage.
    spread = problem.elastic.spread
    tally = Tally(
        energies=problem.energies(), comparable=problem.held is None, spread=spread(problem.u)
    )
    before = tally.last
    patience = Patience()
    newton, exact = problem.newton, problem.elastic.linear.direct or problem.convex is not None
    # balanced: the displacement is in equilibrium. settled: so it was when the last sweep began.
    change, settled, balanced = float("inf"), False, True
    for number in range(stop.sweeps + 1):
        residual = projected_gradient(problem.damage, problem.alpha, lower, upper, problem.work)
        if not np.isfinite(residual):
            raise SolveError("the force on the damage is not finite; try a shorter time step")
        if number:
            watch(Sweep(number=number, energies=tally.energies, change=change, residual=residual))
        near = change <= stop.change and residual <= stop.residual
        converged = near and settled
        if converged or number == stop.sweeps:
            break
        if newton and number and not near and patience.allows():
            taken = _move(problem, newton, lower, upper, tally)
            patience.learn(taken)
            balanced = balanced and not taken
        settled = balanced
        change = _minimize_damage(problem, lower, upper, tally)
        # A displacement from which Newton goes on need not be solved for to the last digit.
        balanced = exact or not newton or change <= stop.change
        equilibrium(problem, values, reduction=0.0 if balanced else REDUCTION)
        tally.balance(problem.energies())
    if not balanced:  # out of sweeps: what is returned is in equilibrium all the same
        equilibrium(problem, values)
        tally.balance(problem.energies())
        residual = projected_gradient(problem.damage, problem.alpha, lower, upper, problem.work)
    status = Status.CONVERGED if converged else Status.NOT_CONVERGED
    return Outcome(
        status=status,
        reason=_reason(status, number, change, residual, stop),
        sweeps=number,
        change=float(change),
        residual=float(residual),
        largest_rise=float(tally.largest_rise),
        energies=tally.energies,
        before=before,
        effort=tally.effort(),
        spread=max(tally.spread, spread(problem.u)),
    )


def equilibrium(problem: Alternation, values: np.ndarray, *, reduction: float = 0.0) -> None:
    """Minimize over the displacement alone. Collective.

    Parameters
    ----------
    problem : both halves of the problem.
    values : prescribed displacements (m), see `ElasticSolver.minimize`.
    reduction : fraction of the residual force at which an iterative solver may stop; 0 for its own.
    """
    if problem.convex is None:
        problem.elastic.minimize(problem.u, values, reduction=reduction)
    else:
        convex.minimize(problem.elastic, problem.convex, problem.u, values, problem.held)
    problem.keep_u(problem.u)
    if not reduction and problem.held is None:
        _correct(problem, values)


def _correct(problem: Alternation, values: np.ndarray) -> None:
    """Compare the residual force with those of loads and supports, and correct the displacement.

    The linear solver's own measure contains the forces of prescribed displacements with all other
    entries fixed; in soft rock beside hard rock the true forces are far smaller. If corrections by
    the iterative solver do not help, a factorization takes over. Collective.
    """
    elastic, most = problem.elastic, LARGEST_RESIDUAL
    if problem.convex is None and elastic.linear.left <= most * elastic.applied:
        return
    applied = 0.0 if problem.convex else elastic.applied
    forces, way = problem.u.duplicate(), problem.u.duplicate()
    try:
        for number in range(2 * CORRECTIONS):
            problem.forces(forces)
            total = forces.norm()
            writable(forces)[elastic.held] = 0.0
            left = forces.norm()
            carried = max(total**2 - left**2, 0.0) ** 0.5
            if left <= max(most * max(applied, carried), elastic.linear.round_off(problem.u)):
                return
            if number == CORRECTIONS:
                if elastic.linear.direct:
                    return  # nothing better can be had: the audit tells of it
                elastic.linear.take_over()
            forces.scale(-1.0)
            way.set(0.0)
            elastic.solve_forces(forces, way)
            if problem.convex is None:
                problem.u.axpy(1.0, way)
            elif (slope := -forces.dot(way)) < 0:
                convex.step_along(problem.convex, problem.u, way, forces, slope)
            problem.keep_u(problem.u)
    finally:
        forces.destroy()
        way.destroy()


def support_reactions(problem: Alternation) -> np.ndarray:
    """Return the forces of the supports on the prescribed entries, in their order. Collective."""
    problem.forces(problem.elastic.rhs)
    return np.asarray(readable(problem.elastic.rhs)[problem.elastic.fixed].copy())


@dataclass(kw_only=True)
class Tally:
    """Counts of one minimization, and the energies of the last accepted state.

    Attributes
    ----------
    energies, last : energies of the last accepted state, and their total.
    comparable : True if solving for the displacement must not raise the energy.
    spread : size of the terms whose difference is the energy.
    largest_rise : largest relative rise of the energy in a half sweep.
    moves, refused, iterations : Newton moves taken and refused, and its linear iterations.
    fallbacks : failures of a damage solver.
    """

    energies: Energies
    comparable: bool = True
    spread: float = 0.0
    last: float = field(init=False)
    largest_rise: float = 0.0
    moves: int = 0
    refused: int = 0
    iterations: int = 0
    fallbacks: int = 0

    def __post_init__(self) -> None:
        self.last = self.energies.total

    def balance(self, energies: Energies) -> None:
        """Record the energies in equilibrium."""
        if not self.comparable:
            self.last = energies.total
        self.accept(energies, "the displacement solve")

    def accept(self, energies: Energies, what: str) -> None:
        """Record the energies of a state, and their rise."""
        self.note(energies.total, what)
        self.energies = energies

    def note(self, total: float, what: str) -> None:
        """Record an energy, and its rise since the one before."""
        if not np.isfinite(total):
            raise SolveError(
                f"the energy is not finite after {what}; try a shorter time step or a larger "
                f"damage.residual_stiffness"
            )
        canceled = CANCELED * self.spread
        scale = max(abs(self.last), abs(total), self.energies.work, canceled, 1e-300)
        self.largest_rise = max(self.largest_rise, (total - self.last) / scale)
        self.last = total

    def effort(self) -> SolverStatistics:
        """Return the solver statistics besides the number of sweeps."""
        return SolverStatistics(
            moves=self.moves,
            refused=self.refused,
            iterations=self.iterations,
            fallbacks=self.fallbacks,
        )


def _move(
    problem: Alternation, newton: CoupledNewton, lower: PETSc.Vec, upper: PETSc.Vec, tally: Tally
) -> bool:
    """Let Newton propose a move of the whole state; return True if it was taken."""

    def total() -> float:
        problem.keep_u(problem.u)
        problem.damage.move_to(problem.alpha)
        return problem.damage.value()

    before = problem.damage.value()  # of the same form as those it is held against
    move = newton.advance(problem.u, problem.alpha, lower, upper, total=total, before=before)
    tally.iterations += move.iterations
    if not move.taken:
        tally.refused += 1
        return False
    tally.moves += 1
    tally.accept(problem.energies(), "Newton's move")
    return True


def _minimize_damage(
    problem: Alternation, lower: PETSc.Vec, upper: PETSc.Vec, tally: Tally
) -> float:
    """Minimize over the damage by the first solver that can; return its largest change."""
    problem.alpha.copy(problem.before)
    errors: list[str] = []
    for solver in problem.bounded:
        try:
            solver.minimize(problem.alpha, lower, upper)
            problem.damage.move_to(problem.alpha)
            tally.note(problem.damage.value(), "the damage was minimized")
            break
        except SolveError as error:
            errors.append(str(error))
            problem.before.copy(problem.alpha)
    else:
        raise SolveError("; ".join(errors) + "; try a shorter time step or a larger damage.ell")
    tally.fallbacks += len(errors)
    problem.before.axpy(-1.0, problem.alpha)
    return float(problem.before.norm(PETSc.NormType.NORM_INFINITY))


def _reason(status: Status, sweeps: int, change: float, residual: float, stop: Stop) -> str:
    figures = f"damage changed by {change:.1e} in the last sweep, residual {residual:.1e}"
    said = f"{status} in {sweeps} sweeps: {figures}"
    if status is Status.CONVERGED:
        return said
    return (
        f"{said}, against {stop.change:.0e} and "
        f"{stop.residual:.0e} asked for; try shorter time steps, a larger solver.sweeps, or "
        f"looser solver.change and solver.residual"
    )
