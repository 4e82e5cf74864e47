"""Newton's method on displacement and damage together: a long move where alternation is slow.

At an energy minimum alternate minimization contracts errors by mu, the largest eigenvalue of
H^-1 C K^-1 C^T (H, K: second derivatives in alpha and in u; C: the mixed one), and near the loss of
stability mu is nearly 1. Conjugate gradients preconditioned by the same two blocks need about
sqrt(1/(1 - mu)) iterations in place of 1/(1 - mu) sweeps, and detect mu > 1: the energy then falls
along the current direction (Steihaug 1983). Farrell and Maurini (2017) change from alternate
minimization to Newton once it is near; here each sweep is followed by a Newton move, truncated
early, that is kept only if it lowers the energy.
"""

from collections.abc import Callable
from dataclasses import dataclass

from staffa.backend.stack import PETSc

import numpy as np

from staffa.backend.vectors import readable, writable
from staffa.minimize.coupled import CoupledModel, destroy_pairs

# The linear system is solved to the first fraction of its right-hand side, or for the second number
# of iterations: its quadratic model is not worth more.
FORCING, ITERATIONS = 0.1, 40
# Where the quadratic model has no minimum, the damage is changed by this at most, to begin with.
REACH = 0.1
# Longest and shortest move, as multiples of Newton's, that are tried.
LONGEST, SHORTEST = 16.0, 1e-3


@dataclass(frozen=True, kw_only=True)
class Move:
    """Result of one proposal.

    Attributes
    ----------
    taken : fraction of the proposal that was taken; 0 if it was refused.
    energy : total energy after it (J; J/m in 2-D).
    iterations : number of iterations of the linear solver.
    """

    taken: float
    energy: float
    iterations: int


class CoupledNewton:
    """Newton's method that proposes moves of displacement and damage. Collective."""

    def __init__(self, model: CoupledModel) -> None:
        self.model = model
        self.force, self.move, self.answer, self.way, self.resistance, self.start = (
            model.pair() for _ in range(6)
        )

    def advance(
        self,
        u: PETSc.Vec,
        alpha: PETSc.Vec,
        lower: PETSc.Vec,
        upper: PETSc.Vec,
        *,
        total: Callable[[], float],
        before: float,
    ) -> Move:
        """Overwrite u and alpha by a state of lower energy, or leave them.

        Parameters
        ----------
        u : displacement (m).
        alpha : damage.
        lower, upper : bounds of the damage.
        total : moves to the values of u and alpha, and returns the energy.
        before : energy at the start (J; J/m in 2-D).
        """
        iterations = self._direction(alpha, lower, upper)
        if not iterations:
            return Move(taken=0.0, energy=before, iterations=0)
        origin = self.start.getNestSubVecs()
        u.copy(origin[0])
        alpha.copy(origin[1])
        du, dalpha = self.move.getNestSubVecs()

        def energy_at(t: float) -> float:
            u.waxpy(t, du, origin[0])
            alpha.waxpy(t, dalpha, origin[1])
            np.clip(readable(alpha), readable(lower), readable(upper), out=writable(alpha))
            return total()

        taken, energy = search(energy_at, before)
        return Move(taken=taken, energy=energy, iterations=iterations)

    def _direction(self, alpha: PETSc.Vec, lower: PETSc.Vec, upper: PETSc.Vec) -> int:
        """Fill `move` from the quadratic model of the energy; return the number of iterations."""
        self.model.move_to(alpha, lower, upper, self.force)
        self.force.scale(-1.0)
        return self._conjugate_gradients()

    def _conjugate_gradients(self) -> int:
        self.move.set(0.0)
        self.model.precondition(self.force, self.answer)
        self.answer.copy(self.way)
        power = start = self.force.dot(self.answer)
        iterations = 0
        while iterations < ITERATIONS and power > FORCING**2 * start:
            iterations += 1
            self.model.apply(self.way, self.resistance)
            curvature = self.way.dot(self.resistance)
            if not curvature > 0:
                self._go_downhill(power, curvature)
                break
            length = power / curvature
            self.move.axpy(length, self.way)
            self.force.axpy(-length, self.resistance)
            self.model.precondition(self.force, self.answer)
            power, last = self.force.dot(self.answer), power
            self.way.aypx(power / last, self.answer)
        return iterations

    def _go_downhill(self, power: float, curvature: float) -> None:
        """Add the direction of negative curvature, as long as if the curvature were positive."""
        largest = self.way.getNestSubVecs()[1].norm(PETSc.NormType.NORM_INFINITY)
        length = min(power / max(-curvature, 1e-300), REACH / max(largest, 1e-300))
        self.move.axpy(length, self.way)

    def destroy(self) -> None:
        """Free its vectors; the model belongs to its maker."""
        destroy_pairs(self.force, self.move, self.answer, self.way, self.resistance, self.start)


def search(energy_at: Callable[[float], float], before: float) -> tuple[float, float]:
    """Return a length t at which the energy is lower than before, and that energy; t = 0 if none.

    Doubles t = 1 while that lowers the energy further, or divides it by three until it is lower.
    The last call of `energy_at` is the one at the returned length.
    """
    t, energy = 1.0, energy_at(1.0)
    if energy < before:
        while t < LONGEST:
            longer = energy_at(2 * t)
            if not longer < energy:
                return t, energy_at(t)
            t, energy = 2 * t, longer
        return t, energy
    while t > SHORTEST:
        t /= 3
        energy = energy_at(t)
        if energy < before:
            return t, energy
    return 0.0, energy_at(0.0)
