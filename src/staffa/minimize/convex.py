"""Minimization of a convex energy over the displacement, for rock with an energy split.

It is Newton's method, judged by the energy itself. The energies of all splits consist of squares of
positive and negative parts: they are convex, once differentiable, and quadratic except where a part
changes sign. Newton's steps are exact once the signs are right. A step along which the slope of the
energy changes sign is shortened. The volume of a fluid in cracks may be given: a linear condition,
whose multiplier is the fluid's pressure.
"""

from collections.abc import Callable
from dataclasses import dataclass

from staffa.backend.stack import PETSc

import numpy as np

from staffa.errors import SolveError
from staffa.minimize.elastic import ElasticSolver, QuadraticEnergy

# A step that would lower the energy by less than this fraction of it is negligible.
ENOUGH = 1e-13
# So is a step that changes the energy before the change of loads by this fraction: a load that is a
# millionth of the last one leaves 1e-12 of it, and must still be solved for.
LEFT = 1e-25
# A displacement of this fraction of the body, or of itself, is zero.
NOTHING = 1e-15
MOST = 100
# Largest gap that round-off, or the linear solver's tolerance, may leave: 4e-13 was seen, with many
# closed cracks.
ROUND_OFF = 1e-9
# A length is accepted if the slope there is this fraction of the first; largest number of lengths.
SLOPE, LENGTHS = 0.1, 30


@dataclass(frozen=True, kw_only=True)
class ConvexEnergy:
    """Energy of the displacement alone, by functions evaluated at the point of the last `move_to`.

    Attributes
    ----------
    matrix : matrix with the pattern of the second derivative.
    move_to : sets the point of evaluation.
    stored : returns the elastic energy there.
    forces : fills the derivative there.
    stiffness : fills the second derivative there.
    quadratic : True if the second derivative does not depend on u.
    length : size of the body (m).
    """

    matrix: PETSc.Mat
    move_to: Callable[[PETSc.Vec], None]
    stored: Callable[[], float]
    forces: Callable[[PETSc.Vec], None]
    stiffness: Callable[[PETSc.Mat], None]
    quadratic: bool = False
    length: float = 0.0

    def model(self, at: PETSc.Vec) -> QuadraticEnergy:
        """Return the quadratic energy that agrees with it to second order at `at`."""

        def load(out: PETSc.Vec) -> None:
            forces = out.duplicate()
            self.forces(forces)
            self.matrix.mult(at, out)
            out.axpy(-1.0, forces)
            forces.destroy()

        return QuadraticEnergy(matrix=self.matrix, stiffness=self.stiffness, load=load)


@dataclass(frozen=True, kw_only=True)
class LinearCondition:
    """Linear condition on the displacement, g . u - `offset` = `target`, and its multiplier p.

    A fluid carries no tension: if a negative pressure would be needed, p is 0 and the volume
    exceeds the target.

    Attributes
    ----------
    widening : fills g.
    offset : returns the offset.
    target : returns the target.
    pressure : returns p, which is in the energy's forces as -p g.
    press : sets p.
    """

    widening: Callable[[PETSc.Vec], None]
    offset: Callable[[], float]
    target: Callable[[], float]
    pressure: Callable[[], float]
    press: Callable[[float], None]


def minimize(
    elastic: ElasticSolver,
    energy: ConvexEnergy,
    u: PETSc.Vec,
    values: np.ndarray,
    held: LinearCondition | None = None,
) -> None:
    """Overwrite u by the minimizer. Collective.

    Parameters
    ----------
    elastic : solver of the energy's model at u.
    energy : the energy.
    u : first guess, overwritten.
    values : prescribed values (m), see `ElasticSolver.minimize`.
    held : given volume of a fluid in cracks, whose pressure is set to that of the minimizer; or
        None.

    Raises
    ------
    SolveError
        A linear solver failed, or the energy does not stop falling.
    """
    way, forces = u.duplicate(), u.duplicate()
    gap = float("inf")
    try:
        energy.move_to(u)
        met = elastic.meets(u, values)
        nothing = elastic.pivot * (NOTHING * energy.length) ** 2
        least = max(LEFT * energy.stored(), nothing, 1e-300)
        for number in range(MOST):
            energy.move_to(u)
            u.copy(way)
            elastic.minimize(way, values)
            if held:
                _hold(elastic, held, way)
            energy.forces(forces)
            way.axpy(-1.0, u)
            slope = forces.dot(way)
            # A first step that applies new prescribed values, or a pressure that holds a volume, is
            # no descent but a prediction.
            predicts = number == 0 and (not met or held is not None)
            exact = elastic.linear.direct or number == 0
            if not (predicts or held or energy.quadratic) and (slope >= 0 or not exact):
                slope = _downhill(elastic, forces, way)
            last, gap = gap, abs(slope) / max(energy.stored(), elastic.curvature(way), 1e-300)
            stalls = gap <= ROUND_OFF and (slope >= 0 or gap > last / 4)
            small = gap <= ENOUGH or abs(slope) <= max(least, NOTHING**2 * elastic.spread(u))
            done = energy.quadratic or ((small or stalls) and (met or number > 0))
            if predicts or energy.quadratic:
                u.axpy(1.0, way)
            elif slope < 0:  # the last one too
                step_along(energy, u, way, forces, slope)
            elif not done:
                raise SolveError(
                    f"the displacement solve failed: the linear solver's direction leads uphill, "
                    f"by {gap:.1e} of the energy; {_way_out(elastic)}"
                )
            if done:
                energy.move_to(u)
                return
        raise SolveError(
            f"the displacement solve failed: after {MOST} of Newton's steps the next would "
            f"still change the energy by {gap:.1e} of it; {_way_out(elastic)}"
        )
    finally:
        way.destroy()
        forces.destroy()


def _way_out(elastic: ElasticSolver) -> str:
    exact = "" if elastic.linear.direct else 'solver.displacement = "direct", '
    return f"try {exact}shorter time steps or a larger damage.residual_stiffness"


def _downhill(elastic: ElasticSolver, forces: PETSc.Vec, way: PETSc.Vec) -> float:
    """Overwrite a direction by the solution for the forces that are left, and return its slope.

    Near the end these forces are smaller than the error that an iterative solver leaves in the
    whole.
    """
    answered = forces.copy()
    try:
        answered.scale(-1.0)
        way.set(0.0)
        elastic.solve_forces(answered, way)
        return float(forces.dot(way))
    finally:
        answered.destroy()


def step_along(
    energy: ConvexEnergy, u: PETSc.Vec, way: PETSc.Vec, forces: PETSc.Vec, slope: float
) -> None:
    """Move along a direction in which a convex energy falls, to about where its slope is zero.

    Collective. In a crack a direction of little slope may go far: the whole of it may lead to 1e19
    of the energy.

    Parameters
    ----------
    energy : the energy.
    u : the point, overwritten.
    way : the direction.
    forces : work vector, overwritten.
    slope : slope of the energy along `way`, negative.
    """
    start = u.copy()
    low, high, length = (0.0, slope), None, 1.0
    try:
        for _ in range(LENGTHS):
            u.waxpy(length, way, start)
            energy.move_to(u)
            energy.forces(forces)
            here = forces.dot(way)
            if abs(here) <= SLOPE * abs(slope) or (here < 0 and high is None):
                return
            low, high = ((length, here), high) if here < 0 else (low, (length, here))
            assert high is not None
            if high[1] <= low[1]:  # round-off: slopes of convex energies grow along the way
                return
            # Linear interpolation of the slope between the two lengths, well between them.
            share = low[1] / (low[1] - high[1])
            length = low[0] + min(max(share, 0.1), 0.9) * (high[0] - low[0])
    finally:
        start.destroy()


def _hold(elastic: ElasticSolver, held: LinearCondition, u: PETSc.Vec) -> None:
    """Add the displacement of the further pressure that meets the condition."""
    g, answer = u.duplicate(), u.duplicate()
    try:
        held.widening(g)
        answer.set(0.0)
        elastic.solve_forces(g, answer)
        wider = g.dot(answer)
        if not wider > 0:
            raise SolveError("no crack is open to the fluid: give one in [[cracks]] that it fills")
        needed = held.pressure() + (held.target() + held.offset() - g.dot(u)) / wider
        more = max(needed, 0.0) - held.pressure()
        u.axpy(more, answer)
        held.press(held.pressure() + more)
    finally:
        g.destroy()
        answer.destroy()
