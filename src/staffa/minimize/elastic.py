"""Minimizes a quadratic energy over the displacement, some of which is prescribed."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from staffa.stack import PETSc

import numpy as np

from staffa.errors import SolveError
from staffa.options import apply

# The direct solver gives 1e-12; what is worse than this has not been solved.
LARGEST_RESIDUAL = 1e-6


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
        self.constrained = self.stiffness.duplicate()
        self.constrained.setOption(PETSc.Mat.Option.SPD, True)
        # Prescribed rows get a pivot of the matrix's own size, so that they count as forces.
        diagonal = self.stiffness.getDiagonal()
        self.pivot = diagonal.norm(PETSc.NormType.NORM_INFINITY)
        diagonal.destroy()
        self.load, self.rhs = self.stiffness.createVecRight(), self.stiffness.createVecRight()
        self.force = self.rhs.duplicate()
        first = self.stiffness.getOwnershipRange()[0]
        self.fixed = fixed
        self.rows = (np.concatenate([fixed, moved]) + first).astype(PETSc.IntType)
        self.modes = [self._vector(mode) for mode in modes]
        self.responses = [self.rhs.duplicate() for _ in modes]
        self.forces = [self.rhs.duplicate() for _ in modes]
        self.near_null = _orthonormal([self._vector(mode) for mode in near_null.T])
        null_space = PETSc.NullSpace().create(vectors=self.near_null, comm=self.stiffness.comm)
        self.constrained.setNearNullSpace(null_space)
        null_space.destroy()
        self.ksp = PETSc.KSP().create(self.stiffness.comm)
        self.ksp.setOptionsPrefix(prefix)
        apply(prefix, preset)
        self.ksp.setOperators(self.constrained)
        self.ksp.setFromOptions()
        self.ksp.setInitialGuessNonzero(self.ksp.getType() != PETSc.KSP.Type.PREONLY)
        self.iterations = 0

    def _vector(self, values: np.ndarray) -> PETSc.Vec:
        vector = self.rhs.duplicate()
        vector.array_w[:] = values[: vector.getLocalSize()]
        return vector

    def minimize(self, u: PETSc.Vec, values: np.ndarray) -> None:
        """Overwrite u by the minimizer; what u holds is the first guess of an iterative solver.

        Parameters
        ----------
        values : prescribed values of the entries `fixed`, shape (n_fixed,).

        Raises
        ------
        SolveError
            The linear solver failed, or its residual is too large to use.
        """
        self.energy.stiffness(self.stiffness)
        self.energy.load(self.load)
        self.stiffness.copy(self.constrained, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        self.force.set(0.0)
        self.force.array_w[self.fixed] = values
        self.load.copy(self.rhs)
        self.constrained.zeroRowsColumns(self.rows, diag=self.pivot, x=self.force, b=self.rhs)
        self._solve(self.rhs, u)
        if self.modes:
            self._add_modes(u)

    def _solve(self, rhs: PETSc.Vec, u: PETSc.Vec) -> None:
        self.ksp.solve(rhs, u)
        self.iterations += self.ksp.getIterationNumber()
        reason = self.ksp.getConvergedReason()
        self.constrained.mult(u, self.force)
        self.force.aypx(-1.0, rhs)
        scale = rhs.norm()
        error = self.force.norm()
        # An all-zero right-hand side has the zero solution, whose residual is exactly zero.
        relative = error / scale if scale > 0 else error
        if reason < 0 or not relative <= LARGEST_RESIDUAL:
            raise SolveError(
                f"the displacement was not solved for: the linear solver ended with "
                f"{_name(reason)} and a relative residual of {relative:.1e}; try "
                f'solver.displacement = "direct", or a larger damage.residual_stiffness'
            )

    def _add_modes(self, u: PETSc.Vec) -> None:
        """u + sum c_j u_j, where u_j answers mode j, and the c_j make the energy smallest."""
        for mode, response, force in zip(self.modes, self.responses, self.forces, strict=True):
            self.stiffness.mult(mode, self.rhs)
            self.rhs.scale(-1.0)
            self.constrained_values(self.rhs, mode)
            self._solve(self.rhs, response)
            self.stiffness.mult(response, force)
        self.stiffness.mult(u, self.force)
        self.force.aypx(-1.0, self.load)
        matrix = np.array([[mode.dot(force) for force in self.forces] for mode in self.modes])
        right = np.array([mode.dot(self.force) for mode in self.modes])
        for c, response in zip(np.linalg.solve(matrix, right), self.responses, strict=True):
            u.axpy(float(c), response)

    def constrained_values(self, rhs: PETSc.Vec, values: PETSc.Vec) -> None:
        """Put the prescribed values into the rows of a right-hand side that are prescribed."""
        local = self.rows - self.stiffness.getOwnershipRange()[0]
        rhs.array_w[local] = self.pivot * values.array_r[local]

    def reactions(self, u: PETSc.Vec) -> np.ndarray:
        """Forces that the supports exert on the entries `fixed`: (K u - f), shape (n_fixed,)."""
        self.stiffness.mult(u, self.force)
        self.force.axpy(-1.0, self.load)
        return self.force.array_r[self.fixed].copy()

    def destroy(self) -> None:
        """Free the PETSc objects."""
        vectors = [self.load, self.rhs, self.force, *self.modes, *self.responses, *self.forces]
        for thing in [self.ksp, self.constrained, self.stiffness, *vectors, *self.near_null]:
            thing.destroy()


def _orthonormal(vectors: list[PETSc.Vec]) -> list[PETSc.Vec]:
    for i, vector in enumerate(vectors):
        for _ in range(2):  # twice is enough (Kahan)
            for before in vectors[:i]:
                vector.axpy(-before.dot(vector), before)
        vector.normalize()
    return vectors


def _name(reason: int) -> str:
    names = {v: k for k, v in vars(PETSc.KSP.ConvergedReason).items() if isinstance(v, int)}
    return names.get(reason, str(reason))
