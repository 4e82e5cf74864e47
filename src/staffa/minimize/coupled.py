"""Second derivative of the energy in displacement and damage together, with a preconditioner."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from staffa.backend.stack import PETSc

import numpy as np

from staffa.backend.petsc_options import apply
from staffa.backend.vectors import readable, writable
from staffa.minimize.bounded import BoundedEnergy, held_by_bounds
from staffa.minimize.elastic import ElasticSolver


@dataclass(frozen=True, kw_only=True)
class Coupling:
    """Terms of the energy that couple displacement and damage.

    Attributes
    ----------
    forces : fills the derivative in u.
    mixed : fills the second derivative, rows in alpha and columns in u.
    matrix : matrix with the pattern of the second derivative.
    """

    forces: Callable[[PETSc.Vec], None]
    mixed: Callable[[PETSc.Mat], None]
    matrix: PETSc.Mat


class CoupledModel:
    """Quadratic model of the energy around a state: [K, C^T; C, H] on displacement and damage.

    K is the stiffness of the last `ElasticSolver.minimize`. Vectors are pairs: displacement,
    damage. All methods are collective.

    Parameters
    ----------
    elastic, damage, coupling : parts of the energy.
    preset, prefix : options of the damage's preconditioner, a constant linear map, and their
        prefix.
    """

    def __init__(
        self,
        elastic: ElasticSolver,
        damage: BoundedEnergy,
        coupling: Coupling,
        *,
        preset: Mapping[str, str],
        prefix: str,
    ) -> None:
        self.elastic, self.damage, self.coupling = elastic, damage, coupling
        self.alpha_work, self.u_work = damage.unit.duplicate(), elastic.rhs.duplicate()
        self.ksp = PETSc.KSP().create(damage.matrix.comm)
        self.ksp.setOptionsPrefix(prefix)
        apply(prefix, preset)
        self.ksp.setOperators(damage.matrix)
        self.ksp.setFromOptions()
        self.held = np.zeros(0, dtype=np.int32)

    def pair(self) -> PETSc.Vec:
        """Return a new vector of displacement and damage, which the caller frees."""
        return PETSc.Vec().createNest([self.elastic.rhs.duplicate(), self.damage.unit.duplicate()])

    def move_to(
        self,
        alpha: PETSc.Vec,
        lower: PETSc.Vec,
        upper: PETSc.Vec,
        force: PETSc.Vec,
        slack: float = 0.0,
    ) -> None:
        """Set the model around the current displacement and this damage.

        Damage that a bound blocks does not move in the model.

        Parameters
        ----------
        alpha : damage, owned entries.
        lower, upper : its bounds, owned entries.
        force : a pair, overwritten by the derivative of the energy, zero where nothing moves.
        slack : derivative, over its scale, up to which a bound does not block.
        """
        force_u, force_alpha = force.getNestSubVecs()
        self.coupling.forces(force_u)
        writable(force_u)[self.elastic.fixed] = 0.0
        self.damage.move_to(alpha)
        self.damage.gradient(force_alpha)
        allowed = slack * readable(self.damage.unit)
        held = held_by_bounds(force_alpha, alpha, lower, upper, allowed)
        self.held = np.flatnonzero(held).astype(np.int32)
        writable(force_alpha)[self.held] = 0.0
        H = self.damage.matrix
        self.damage.hessian(H)
        H.zeroRowsColumns(self.held + H.getOwnershipRange()[0], diag=self._pivot(H))
        self.ksp.setOperators(H)
        self.coupling.mixed(self.coupling.matrix)

    def _pivot(self, H: PETSc.Mat) -> float:
        H.getDiagonal(self.alpha_work)
        return float(self.alpha_work.norm(PETSc.NormType.NORM_INFINITY))

    def apply(self, move: PETSc.Vec, force: PETSc.Vec) -> None:
        """Overwrite `force` by the second derivative of the energy along a move."""
        (u, alpha), (force_u, force_alpha) = move.getNestSubVecs(), force.getNestSubVecs()
        C = self.coupling.matrix
        self.elastic.apply_stiffness(u, force_u)
        C.multTransposeAdd(alpha, force_u, force_u)
        writable(force_u)[self.elastic.fixed] = 0.0
        self.damage.matrix.mult(alpha, force_alpha)
        C.multAdd(u, force_alpha, force_alpha)
        writable(force_alpha)[self.held] = 0.0

    def precondition(self, force: PETSc.Vec, move: PETSc.Vec) -> None:
        """Overwrite `move` by block elimination with approximate blocks; symmetric, as CG needs it.

        With the exact inverse of the stiffness the forces on u stay zero all the time.
        """
        (force_u, force_alpha), (u, alpha) = force.getNestSubVecs(), move.getNestSubVecs()
        C = self.coupling.matrix
        force_alpha.copy(self.alpha_work)
        force_u.copy(self.u_work)
        if not self.elastic.linear.exact:
            self.elastic.precondition(force_u, u)
            C.mult(u, alpha)
            self.alpha_work.axpy(-1.0, alpha)
            writable(self.alpha_work)[self.held] = 0.0
        self.ksp.solve(self.alpha_work, alpha)
        C.multTranspose(alpha, u)
        self.u_work.axpy(-1.0, u)
        self.elastic.precondition(self.u_work, u)

    def following(self, b: np.ndarray) -> np.ndarray:
        """Return the displacement that keeps equilibrium as the damage changes, to first order.

        Parameters
        ----------
        b : damage of the direction, shape (n_owned,).

        Raises
        ------
        SolveError
            The linear solver failed.
        """
        v = self.elastic.rhs.duplicate()
        try:
            v.set(0.0)
            writable(self.alpha_work)[:] = b
            self.coupling.matrix.multTranspose(self.alpha_work, self.u_work)
            self.u_work.scale(-1.0)
            self.elastic.solve_forces(self.u_work, v)
            return readable(v).copy()
        finally:
            v.destroy()

    def swept(self, v: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, float]:
        """Return the damage of a direction after a sweep of the linearized alternate minimization.

        Parameters
        ----------
        v, b : displacement and damage of the direction, owned entries; blocked damage does not
            move.

        Returns
        -------
        damage : b less the preconditioned force along it, shape (n_owned,).
        curvature : curvature of the energy along the direction.
        """
        move, force, answer = self.pair(), self.pair(), self.damage.unit.duplicate()
        try:
            parts = move.getNestSubVecs()
            writable(parts[0])[:], writable(parts[1])[:] = v, b
            writable(parts[1])[self.held] = 0.0
            self.apply(move, force)
            self.ksp.solve(force.getNestSubVecs()[1], answer)
            return readable(parts[1]) - readable(answer), float(move.dot(force))
        finally:
            destroy_pairs(move, force)
            answer.destroy()

    def destroy(self) -> None:
        """Free the PETSc objects."""
        for thing in [self.ksp, self.coupling.matrix, self.alpha_work, self.u_work]:
            thing.destroy()


def destroy_pairs(*pairs: PETSc.Vec) -> None:
    """Free pairs and their parts."""
    parts = [part for pair in pairs for part in pair.getNestSubVecs()]
    for thing in [*pairs, *parts]:
        thing.destroy()
