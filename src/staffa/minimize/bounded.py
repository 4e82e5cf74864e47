"""Minimizes a smooth energy between bounds, by TAO or by SNES, behind one interface."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from staffa.backend.stack import PETSc

import numpy as np

from staffa.backend.petsc_options import apply, petsc_errors
from staffa.backend.petsc_status import Ended, ended
from staffa.backend.vectors import readable, writable
from staffa.errors import SolveError


@dataclass(frozen=True, kw_only=True)
class BoundedEnergy:
    """An energy of a vector x, lower <= x <= upper, by functions that fill what they are given.

    `move_to(x)` sets the point at which `value`, `gradient` and `hessian` are evaluated; `matrix`
    has the Hessian's pattern; `unit` is the force on an entry that counts as one; `quadratic` says
    that the Hessian does not depend on x.
    """

    move_to: Callable[[PETSc.Vec], None]
    value: Callable[[], float]
    gradient: Callable[[PETSc.Vec], None]
    hessian: Callable[[PETSc.Mat], None]
    matrix: PETSc.Mat
    unit: PETSc.Vec
    quadratic: bool = False


class Evaluation:
    """Value, gradient and Hessian for a solver, as cheap as the energy allows.

    A quadratic energy is assembled once, where a minimization starts; from there it is followed by
    products with its Hessian, and values count from the one at the start. Collective.
    """

    def __init__(self, energy: BoundedEnergy) -> None:
        self.energy = energy
        self.origin, self.slope, self.work = (energy.unit.duplicate() for _ in range(3))

    def start(self, x: PETSc.Vec) -> None:
        """Begin a minimization at x."""
        if self.energy.quadratic:
            self.energy.move_to(x)
            x.copy(self.origin)
            self.energy.gradient(self.slope)
            self.energy.hessian(self.energy.matrix)

    def gradient(self, x: PETSc.Vec, out: PETSc.Vec) -> None:
        """Fill the gradient at x."""
        if self.energy.quadratic:
            self.work.waxpy(-1.0, self.origin, x)
            self.energy.matrix.multAdd(self.work, self.slope, out)
        else:
            self.energy.move_to(x)
            self.energy.gradient(out)

    def value_and_gradient(self, x: PETSc.Vec, out: PETSc.Vec) -> float:
        """Fill the gradient at x; the value there."""
        self.gradient(x, out)
        if self.energy.quadratic:  # the mean of the two slopes, times the way
            return float(0.5 * (self.work.dot(out) + self.work.dot(self.slope)))
        return self.energy.value()

    def hessian(self, x: PETSc.Vec, H: PETSc.Mat) -> None:
        """Fill the Hessian at x."""
        if not self.energy.quadratic:
            self.energy.move_to(x)
            self.energy.hessian(H)

    def destroy(self) -> None:
        """Free the vectors."""
        for vector in (self.origin, self.slope, self.work):
            vector.destroy()


class BoundedSolver(Protocol):
    """A minimizer between bounds. Everything is collective."""

    iterations: int

    def minimize(self, x: PETSc.Vec, lower: PETSc.Vec, upper: PETSc.Vec) -> None:
        """Overwrite x by a minimizer between the bounds; what x holds is the first guess.

        Raises
        ------
        SolveError
            It did not converge, or left the bounds, or the result is not finite; x is then
            undefined.
        """
        ...

    def destroy(self) -> None:
        """Free the PETSc objects."""
        ...


# A damage this close to its bound is at it: SNES's own measure (snes_vi_zero_tolerance).
AT_BOUND = 1e-8


def held_by_bounds(
    force: PETSc.Vec,
    x: PETSc.Vec,
    lower: PETSc.Vec,
    upper: PETSc.Vec,
    slack: np.ndarray | float = 0.0,
) -> np.ndarray:
    """True at the owned entries that a bound holds against the energy's derivative.

    Parameters
    ----------
    force : the derivative. x, lower, upper : the point and its bounds.
    slack : a derivative of this size or less does not press against a bound, shape (n_owned,).
    """
    derivative, at = readable(force), readable(x)
    at_lower, at_upper = at <= readable(lower) + AT_BOUND, at >= readable(upper) - AT_BOUND
    return ((derivative > slack) & at_lower) | ((derivative < -slack) & at_upper)


def projected_gradient(
    energy: BoundedEnergy, x: PETSc.Vec, lower: PETSc.Vec, upper: PETSc.Vec, work: PETSc.Vec
) -> float:
    """Largest force on an entry that could follow it, over the unit: 0 at a first-order minimum.

    Collective.
    """
    energy.move_to(x)
    energy.gradient(work)
    held = held_by_bounds(work, x, lower, upper)
    writable(work)[:] = np.where(held, 0.0, np.abs(readable(work))) / readable(energy.unit)
    return float(work.norm(PETSc.NormType.NORM_INFINITY))


class TaoSolver:
    """TAO's projected Newton with a line search, or any TAO solver that knows bounds.

    tolerance: 2-norm of the forces at the end, which bounds each, over the smallest unit.
    """

    def __init__(
        self,
        energy: BoundedEnergy,
        *,
        tolerance: float,
        preset: Mapping[str, str],
        prefix: str,
    ) -> None:
        self.energy, self.evaluation = energy, Evaluation(energy)
        self.gradient = energy.unit.duplicate()
        self.tao = PETSc.TAO().create(energy.matrix.comm)
        self.tao.setOptionsPrefix(prefix)
        apply(prefix, preset)
        self.tao.setObjectiveGradient(self._value_and_gradient, self.gradient)
        self.tao.setHessian(self._hessian, energy.matrix)
        absolute = tolerance * energy.unit.min()[1]
        self.tao.setTolerances(gatol=absolute, grtol=0.0, gttol=0.0)
        self.tao.setFromOptions()
        self.iterations = 0

    def _value_and_gradient(self, tao: PETSc.TAO, x: PETSc.Vec, g: PETSc.Vec) -> float:
        return self.evaluation.value_and_gradient(x, g)

    def _hessian(self, tao: PETSc.TAO, x: PETSc.Vec, H: PETSc.Mat, P: PETSc.Mat) -> None:
        self.evaluation.hessian(x, H)

    def minimize(self, x: PETSc.Vec, lower: PETSc.Vec, upper: PETSc.Vec) -> None:
        """See `BoundedSolver`."""
        self.evaluation.start(x)
        self.tao.setVariableBounds((lower, upper))
        with petsc_errors("the damage was not minimized", self.tao.comm):
            self.tao.solve(x)
        self.iterations += self.tao.getIterationNumber()
        _require("TAO", ended(self.tao), x, self.gradient)
        _into_bounds(x, lower, upper)
        self.energy.move_to(x)

    def destroy(self) -> None:
        """See `BoundedSolver`."""
        self.tao.destroy()
        self.evaluation.destroy()
        self.gradient.destroy()


class SnesSolver:
    """SNES for variational inequalities: the active set of Benson and Munson.

    tolerance: 2-norm of the forces at the end, which bounds each, over the smallest unit.
    """

    def __init__(
        self,
        energy: BoundedEnergy,
        *,
        tolerance: float,
        preset: Mapping[str, str],
        prefix: str,
    ) -> None:
        self.energy, self.evaluation = energy, Evaluation(energy)
        self.gradient = energy.unit.duplicate()
        self.snes = PETSc.SNES().create(energy.matrix.comm)
        self.snes.setOptionsPrefix(prefix)
        apply(prefix, preset)
        self.snes.setFunction(self._gradient, self.gradient)
        self.snes.setJacobian(self._hessian, energy.matrix)
        absolute = tolerance * energy.unit.min()[1]
        self.snes.setTolerances(rtol=0.0, atol=absolute, stol=0.0)
        self.snes.setFromOptions()
        self.iterations = 0

    def _gradient(self, snes: PETSc.SNES, x: PETSc.Vec, g: PETSc.Vec) -> None:
        self.evaluation.gradient(x, g)

    def _hessian(self, snes: PETSc.SNES, x: PETSc.Vec, H: PETSc.Mat, P: PETSc.Mat) -> None:
        self.evaluation.hessian(x, H)

    def minimize(self, x: PETSc.Vec, lower: PETSc.Vec, upper: PETSc.Vec) -> None:
        """See `BoundedSolver`."""
        self.evaluation.start(x)
        self.snes.setVariableBounds(lower, upper)
        with petsc_errors("the damage was not minimized", self.snes.comm):
            self.snes.solve(None, x)
        self.iterations += self.snes.getIterationNumber()
        _require("SNES", ended(self.snes), x, self.gradient)
        _into_bounds(x, lower, upper)
        self.energy.move_to(x)

    def destroy(self) -> None:
        """See `BoundedSolver`."""
        self.snes.destroy()
        self.evaluation.destroy()
        self.gradient.destroy()


SOLVERS: dict[str, type[TaoSolver] | type[SnesSolver]] = {"tao": TaoSolver, "snes": SnesSolver}


def _require(solver: str, end: Ended, x: PETSc.Vec, gradient: PETSc.Vec) -> None:
    if not (np.isfinite(x.norm()) and np.isfinite(gradient.norm())):
        raise SolveError(
            "the damage was not minimized: the result, or the force on it, is not finite"
        )
    if not end.converged:
        raise SolveError(f"the damage was not minimized by {solver}: {end.sentence}")


def _into_bounds(x: PETSc.Vec, lower: PETSc.Vec, upper: PETSc.Vec) -> None:
    """Remove what round-off left outside."""
    np.clip(readable(x), readable(lower), readable(upper), out=writable(x))
