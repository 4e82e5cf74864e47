"""Minimization of a smooth energy between bounds, by TAO or by SNES, with one interface."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Protocol

from staffa.backend.stack import PETSc

import numpy as np

from staffa.backend.petsc_options import apply, petsc_errors
from staffa.backend.petsc_status import Ended, how_it_ended
from staffa.backend.vectors import readable, writable
from staffa.errors import SolveError


@dataclass(frozen=True, kw_only=True)
class BoundedEnergy:
    """Energy of a vector x, lower <= x <= upper, by functions that fill their arguments.

    Attributes
    ----------
    move_to : sets the point of evaluation.
    value : returns the energy there.
    gradient, hessian : fill the first and the second derivative there.
    matrix : matrix with the pattern of the Hessian.
    unit : scale of the gradient, positive, one an entry.
    quadratic : True if the Hessian does not depend on x.
    """

    move_to: Callable[[PETSc.Vec], None]
    value: Callable[[], float]
    gradient: Callable[[PETSc.Vec], None]
    hessian: Callable[[PETSc.Mat], None]
    matrix: PETSc.Mat
    unit: PETSc.Vec
    quadratic: bool = False


class Evaluation:
    """Value, gradient and Hessian for a solver, as cheap as the energy allows. Collective.

    A quadratic energy is assembled once, at the start of a minimization. From there it is followed
    by products with its Hessian, and values are counted from the start.
    """

    def __init__(self, energy: BoundedEnergy) -> None:
        self.energy = energy
        self.origin, self.slope, self.work = (energy.unit.duplicate() for _ in range(3))

    def start(self, x: PETSc.Vec) -> None:
        """Start a minimization at x."""
        if self.energy.quadratic:
            self.energy.move_to(x)
            x.copy(self.origin)
            self.energy.gradient(self.slope)
            self.energy.hessian(self.energy.matrix)

    def gradient(self, x: PETSc.Vec, out: PETSc.Vec) -> None:
        """Fill `out` with the gradient at x."""
        if self.energy.quadratic:
            self.work.waxpy(-1.0, self.origin, x)
            self.energy.matrix.multAdd(self.work, self.slope, out)
        else:
            self.energy.move_to(x)
            self.energy.gradient(out)

    def value_and_gradient(self, x: PETSc.Vec, out: PETSc.Vec) -> float:
        """Fill `out` with the gradient at x, and return the value."""
        self.gradient(x, out)
        if self.energy.quadratic:  # the mean of the two slopes, times the way
            return float(0.5 * (self.work.dot(out) + self.work.dot(self.slope)))
        return self.energy.value()

    def hessian(self, x: PETSc.Vec, H: PETSc.Mat) -> None:
        """Fill H with the Hessian at x."""
        if not self.energy.quadratic:
            self.energy.move_to(x)
            self.energy.hessian(H)

    def destroy(self) -> None:
        """Free the vectors."""
        for vector in (self.origin, self.slope, self.work):
            vector.destroy()


class BoundedSolver(Protocol):
    """Minimizer between bounds. All methods are collective."""

    iterations: int

    def minimize(self, x: PETSc.Vec, lower: PETSc.Vec, upper: PETSc.Vec) -> None:
        """Overwrite x by a minimizer between the bounds.

        Parameters
        ----------
        x : first guess, overwritten.
        lower, upper : bounds.

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
    """Return True at the owned entries that a bound blocks, shape (n_owned,).

    Parameters
    ----------
    force : derivative of the energy.
    x : the point.
    lower, upper : bounds.
    slack : size of the derivative up to which a bound does not block, shape (n_owned,).
    """
    derivative, at = readable(force), readable(x)
    at_lower, at_upper = at <= readable(lower) + AT_BOUND, at >= readable(upper) - AT_BOUND
    return ((derivative > slack) & at_lower) | ((derivative < -slack) & at_upper)


def projected_gradient(
    energy: BoundedEnergy, x: PETSc.Vec, lower: PETSc.Vec, upper: PETSc.Vec, work: PETSc.Vec
) -> float:
    """Return the largest projected gradient over its scale: 0 at a first-order minimum.

    Collective.

    Parameters
    ----------
    energy : the energy.
    x : the point.
    lower, upper : bounds.
    work : work vector, overwritten.
    """
    energy.move_to(x)
    energy.gradient(work)
    held = held_by_bounds(work, x, lower, upper)
    writable(work)[:] = np.where(held, 0.0, np.abs(readable(work))) / readable(energy.unit)
    return float(work.norm(PETSc.NormType.NORM_INFINITY))


class TaoSolver:
    """TAO's projected Newton with a line search, or any TAO solver with bounds.

    Parameters
    ----------
    energy : the energy.
    tolerance : 2-norm of the projected gradient at the end, over the smallest entry of the scale.
    preset : PETSc options.
    prefix : prefix of the options.
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
        """Overwrite x by a minimizer between `lower` and `upper`, see `BoundedSolver.minimize`."""
        self.evaluation.start(x)
        self.tao.setVariableBounds((lower, upper))
        with petsc_errors("the damage was not minimized", self.tao.comm):
            self.tao.solve(x)
        self.iterations += self.tao.getIterationNumber()
        _require("TAO", how_it_ended(self.tao), x, self.gradient)
        _into_bounds(x, lower, upper)
        self.energy.move_to(x)

    def destroy(self) -> None:
        """Free the PETSc objects."""
        self.tao.destroy()
        self.evaluation.destroy()
        self.gradient.destroy()


class SnesSolver:
    """SNES for variational inequalities: the active set of Benson and Munson.

    Parameters
    ----------
    energy : the energy.
    tolerance : 2-norm of the projected gradient at the end, over the smallest entry of the scale.
    preset : PETSc options.
    prefix : prefix of the options.
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
        """Overwrite x by a minimizer between `lower` and `upper`, see `BoundedSolver.minimize`."""
        self.evaluation.start(x)
        self.snes.setVariableBounds(lower, upper)
        with petsc_errors("the damage was not minimized", self.snes.comm):
            self.snes.solve(None, x)
        self.iterations += self.snes.getIterationNumber()
        _require("SNES", how_it_ended(self.snes), x, self.gradient)
        _into_bounds(x, lower, upper)
        self.energy.move_to(x)

    def destroy(self) -> None:
        """Free the PETSc objects."""
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
    """Move entries that round-off left outside onto their bounds."""
    np.clip(readable(x), readable(lower), readable(upper), out=writable(x))
