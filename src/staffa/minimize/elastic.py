"""Minimization of a quadratic energy over the displacement, some of which is prescribed."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from staffa.backend.stack import PETSc

import numpy as np

from staffa.backend.vectors import readable, writable
from staffa.minimize.linear import LinearSolver


@dataclass(frozen=True, kw_only=True)
class QuadraticEnergy:
    """Energy 1/2 u.K u - f.u.

    Attributes
    ----------
    matrix : matrix with the pattern of K.
    stiffness : fills K.
    load : fills f.
    """

    matrix: PETSc.Mat
    stiffness: Callable[[PETSc.Mat], None]
    load: Callable[[PETSc.Vec], None]


class ElasticSolver:
    """Minimizer over u of a quadratic energy, with prescribed entries and unknown modes.

    u = values on `fixed`; u = sum c_j modes_j on `moved`. The c_j are minimized too, by
    condensation: one factorization serves the field and all modes. It owns its PETSc objects. All
    methods are collective.

    Parameters
    ----------
    energy : the energy.
    fixed, moved : local indices of owned entries of u.
    modes : unit displacements on `moved`, shape (n_owned,) each.
    near_null : rigid body motions, shape (n_owned, 3 or 6), for the multigrid's coarse spaces.
    preset, prefix : options of the linear solver, and their prefix.
    """

    def __init__(
        self,
        energy: QuadraticEnergy,
        *,
        fixed: np.ndarray,
        moved: np.ndarray,
        modes: Sequence[np.ndarray],
        near_null: np.ndarray,
        preset: Mapping[str, str],
        prefix: str,
    ) -> None:
        self.energy = energy
        self.stiffness = energy.matrix
        energy.stiffness(self.stiffness)  # a matrix that was never filled has no pattern to share
        # Modes move supported entries, so they need the stiffness without supports as well.
        self.constrained = self.stiffness.duplicate() if modes else self.stiffness
        self.constrained.setOption(PETSc.Mat.Option.SPD, True)
        # Prescribed rows get a pivot of the matrix's own size, so that they count as forces.
        self.diagonal = self.stiffness.getDiagonal()
        self.pivot = self.diagonal.norm(PETSc.NormType.NORM_INFINITY)
        self.load, self.rhs = self.stiffness.createVecRight(), self.stiffness.createVecRight()
        self.force = self.rhs.duplicate()
        first = self.stiffness.getOwnershipRange()[0]
        self.fixed, self.held = fixed, np.concatenate([fixed, moved])
        self.rows = (self.held + first).astype(PETSc.IntType)
        self.modes = [self._vector(mode) for mode in modes]
        self.responses = [self.rhs.duplicate() for _ in modes]
        self.forces = [self.rhs.duplicate() for _ in modes]
        self.mode_stiffness = np.zeros((len(modes), len(modes)))
        # Rigid motions of the free entries: then no coarse correction moves prescribed entries, and
        # an iterate before convergence keeps its supports.
        rigid = np.array(near_null[: self.rhs.getLocalSize()])
        rigid[self.held] = 0.0
        self.near_null = _orthonormal([self._vector(mode) for mode in rigid.T])
        null_space = PETSc.NullSpace().create(vectors=self.near_null, comm=self.stiffness.comm)
        self.constrained.setNearNullSpace(null_space)
        null_space.destroy()
        self.linear = LinearSolver(self.constrained, self.diagonal, preset, prefix)
        self.applied = 0.0  # 2-norm of the forces besides those of supports

    def forget(self) -> None:
        """Start with a new preconditioner and modes without a first guess.

        Then the next result depends on the problem alone.
        """
        self.linear.forget()
        for response in self.responses:
            response.set(0.0)

    def _vector(self, values: np.ndarray) -> PETSc.Vec:
        vector = self.rhs.duplicate()
        writable(vector)[:] = values[: vector.getLocalSize()]
        return vector

    def minimize(self, u: PETSc.Vec, values: np.ndarray, *, reduction: float = 0.0) -> None:
        """Overwrite u by the minimizer.

        Parameters
        ----------
        u : first guess, overwritten.
        values : prescribed values of the entries `fixed` (m), shape (n_fixed,).
        reduction : fraction of the residual force at u at which an iterative solver may stop; the
            energy has then fallen, but not to its minimum.

        Raises
        ------
        SolveError
            The linear solver failed, or its residual is too large to use.
        """
        self.energy.stiffness(self.stiffness)
        self.energy.load(self.load)
        if self.modes:
            self.stiffness.copy(self.constrained, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        self.stiffness.getDiagonal(self.diagonal)
        self.linear.changed()
        self.force.set(0.0)
        writable(self.force)[self.fixed] = values
        self.applied = self.load.norm()
        self.load.copy(self.rhs)
        self.constrained.zeroRowsColumns(self.rows, diag=self.pivot, x=self.force, b=self.rhs)
        # The amplitudes of the modes follow from a displacement in equilibrium.
        self.linear.solve(self.rhs, u, 0.0 if self.modes else reduction)
        if self.modes:
            self._add_modes(u)

    def spread(self, u: PETSc.Vec) -> float:
        """Return u . diag(K) u, the size of the terms whose difference is the energy of u."""
        self.force.pointwiseMult(self.diagonal, u)
        return float(self.force.dot(u))

    def _add_modes(self, u: PETSc.Vec) -> None:
        """Add sum c_j u_j to u: u_j the solution for mode j, c_j the minimizing amplitudes."""
        for mode, response, force in zip(self.modes, self.responses, self.forces, strict=True):
            self.stiffness.mult(mode, self.rhs)
            self.rhs.scale(-1.0)
            writable(self.rhs)[self.held] = self.pivot * readable(mode)[self.held]
            self.linear.solve(self.rhs, response)
            self.stiffness.mult(response, force)
        self.mode_stiffness = np.array([[m.dot(f) for f in self.forces] for m in self.modes])
        self.stiffness.mult(u, self.force)
        self.force.aypx(-1.0, self.load)
        self._add_responses([mode.dot(self.force) for mode in self.modes], u)

    def _add_responses(self, forces: Sequence[float], u: PETSc.Vec) -> None:
        """Add the solutions for forces on the modes, shape (n_modes,)."""
        amplitudes = np.linalg.solve(self.mode_stiffness, forces)
        for c, response in zip(amplitudes, self.responses, strict=True):
            u.axpy(float(c), response)

    def precondition(self, force: PETSc.Vec, u: PETSc.Vec) -> None:
        """Overwrite u by an approximate solution of K u = force at fixed supports.

        The map is symmetric and positive definite. It is the inverse if `linear` is `exact`, at the
        damage of the last `minimize`. Overwrites `rhs`.
        """
        force.copy(self.rhs)
        writable(self.rhs)[self.held] = 0.0
        self.linear.ksp.pc.apply(self.rhs, u)
        writable(u)[self.held] = 0.0
        if self.modes:
            self._add_responses([response.dot(force) for response in self.responses], u)

    def solve_forces(self, force: PETSc.Vec, u: PETSc.Vec) -> None:
        """Solve K u = force at fixed supports, with the stiffness of the last `minimize`.

        `u` has the first guess, and is overwritten. Overwrites `rhs`.

        Raises
        ------
        SolveError
            The linear solver failed, see `minimize`.
        """
        force.copy(self.rhs)
        writable(self.rhs)[self.held] = 0.0
        self.linear.solve(self.rhs, u)
        if self.modes:
            self._add_responses([response.dot(force) for response in self.responses], u)

    def meets(self, u: PETSc.Vec, values: np.ndarray) -> bool:
        """Return True if u has these prescribed values on `fixed` already."""
        self.force.set(0.0)
        writable(self.force)[self.fixed] = readable(u)[self.fixed] - values
        return bool(self.force.norm(PETSc.NormType.NORM_INFINITY) == 0.0)

    def curvature(self, u: PETSc.Vec) -> float:
        """Return u . K u, at the stiffness of the last `minimize`."""
        self.stiffness.mult(u, self.force)
        return float(u.dot(self.force))

    def apply_stiffness(self, u: PETSc.Vec, force: PETSc.Vec) -> None:
        """Overwrite `force` by K u, 0 at supports, for a u that is 0 there."""
        self.stiffness.mult(u, force)
        writable(force)[self.fixed] = 0.0

    def destroy(self) -> None:
        """Free the PETSc objects."""
        vectors = [self.load, self.rhs, self.force, *self.modes, *self.responses, *self.forces]
        vectors += [self.diagonal]
        copies = [self.constrained] if self.modes else []
        for thing in [self.linear, self.stiffness, *copies, *vectors, *self.near_null]:
            thing.destroy()


def _orthonormal(vectors: list[PETSc.Vec]) -> list[PETSc.Vec]:
    for i, vector in enumerate(vectors):
        for _ in range(2):  # twice is enough (Kahan)
            for before in vectors[:i]:
                vector.axpy(-before.dot(vector), before)
        vector.normalize()
    return vectors
