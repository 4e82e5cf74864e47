"""Minimizes a quadratic energy over the displacement, some of which is prescribed."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from staffa.backend.stack import PETSc

import numpy as np

from staffa.backend.vectors import readable, writable
from staffa.minimize.linear import LinearSolver


@dataclass(frozen=True, kw_only=True)
class QuadraticEnergy:
    """1/2 u.K u - f.u: `stiffness` fills K, `load` fills f, `matrix` has K's pattern."""

    matrix: PETSc.Mat
    stiffness: Callable[[PETSc.Mat], None]
    load: Callable[[PETSc.Vec], None]


class ElasticSolver:
    """Minimizer over u of a quadratic energy, with prescribed entries and unknown modes.

    u = values on `fixed`; u = sum c_j modes_j on `moved`, where the c_j are minimized too, by
    condensation: one factorization serves the field and all modes. Owns its PETSc objects.
    Everything is collective.

    Parameters
    ----------
    fixed, moved : local indices of owned entries of u.
    modes : unit displacements on `moved`, shape (n_owned,) each.
    near_null : rigid-body modes, shape (n_owned, 3 or 6), for the multigrid's coarse spaces.
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
        # Rigid motions of what is free: no coarse correction then moves what is prescribed, and an
        # iterate that is not yet solved for keeps its supports.
        rigid = np.array(near_null[: self.rhs.getLocalSize()])
        rigid[self.held] = 0.0
        self.near_null = _orthonormal([self._vector(mode) for mode in rigid.T])
        null_space = PETSc.NullSpace().create(vectors=self.near_null, comm=self.stiffness.comm)
        self.constrained.setNearNullSpace(null_space)
        null_space.destroy()
        self.linear = LinearSolver(self.constrained, self.diagonal, preset, prefix)
        self.applied = 0.0  # the force of what acts besides supports, its 2-norm

    def forget(self) -> None:
        """Begin with a new preconditioner, and modes without a first guess: what comes then depends
        on the problem alone."""
        self.linear.forget()
        for response in self.responses:
            response.set(0.0)

    def _vector(self, values: np.ndarray) -> PETSc.Vec:
        vector = self.rhs.duplicate()
        writable(vector)[:] = values[: vector.getLocalSize()]
        return vector

    def minimize(self, u: PETSc.Vec, values: np.ndarray, *, reduction: float = 0.0) -> None:
        """Overwrite u by the minimizer; what u holds is the first guess.

        Parameters
        ----------
        values : prescribed values of the entries `fixed`, shape (n_fixed,).
        reduction : an iterative solver may stop once it has reduced the force that u leaves
            unbalanced to this fraction; the energy has then fallen, but not to its minimum.

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
        # How far the modes go is found from a displacement in equilibrium.
        self.linear.solve(self.rhs, u, 0.0 if self.modes else reduction)
        if self.modes:
            self._add_modes(u)

    def spread(self, u: PETSc.Vec) -> float:
        """u . diag(K) u: the size of the terms that an energy of u is the difference of."""
        self.force.pointwiseMult(self.diagonal, u)
        return float(self.force.dot(u))

    def _add_modes(self, u: PETSc.Vec) -> None:
        """u + sum c_j u_j, where u_j answers mode j, and the c_j make the energy smallest."""
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
        """Add the responses to forces on the modes, shape (n_modes,)."""
        amplitudes = np.linalg.solve(self.mode_stiffness, forces)
        for c, response in zip(amplitudes, self.responses, strict=True):
            u.axpy(float(c), response)

    def precondition(self, force: PETSc.Vec, u: PETSc.Vec) -> None:
        """Overwrite u by the displacement that answers a force at fixed supports, approximately.

        Symmetric and positive definite; it is the inverse itself if `linear` is `exact`, at the
        damage of the last `minimize`. Overwrites `rhs`.
        """
        force.copy(self.rhs)
        writable(self.rhs)[self.held] = 0.0
        self.linear.ksp.pc.apply(self.rhs, u)
        writable(u)[self.held] = 0.0
        if self.modes:
            self._add_responses([response.dot(force) for response in self.responses], u)

    def respond(self, force: PETSc.Vec, u: PETSc.Vec) -> None:
        """Overwrite u by the displacement that answers a force at supports at rest, at the
        stiffness of the last `minimize`; what u holds is the first guess. Overwrites `rhs`.

        Raises
        ------
        SolveError
            As `minimize` does.
        """
        force.copy(self.rhs)
        writable(self.rhs)[self.held] = 0.0
        self.linear.solve(self.rhs, u)
        if self.modes:
            self._add_responses([response.dot(force) for response in self.responses], u)

    def meets(self, u: PETSc.Vec, values: np.ndarray) -> bool:
        """Whether u has these prescribed values on `fixed` already."""
        self.force.set(0.0)
        writable(self.force)[self.fixed] = readable(u)[self.fixed] - values
        return bool(self.force.norm(PETSc.NormType.NORM_INFINITY) == 0.0)

    def curvature(self, u: PETSc.Vec) -> float:
        """u . K u, at the stiffness of the last `minimize`."""
        self.stiffness.mult(u, self.force)
        return float(u.dot(self.force))

    def resist(self, u: PETSc.Vec, force: PETSc.Vec) -> None:
        """Overwrite force by K u, for a u that the supports at rest allow; 0 where they hold."""
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
