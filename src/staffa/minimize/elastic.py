"""Minimizes a quadratic energy over the displacement, some of which is prescribed."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from staffa.stack import PETSc

import numpy as np

from staffa.errors import SolveError
from staffa.options import apply, petsc_errors

# A new factorization gives 1e-12 or so; what is worse than this has not been solved.
LARGEST_RESIDUAL = 1e-6
# A multigrid hierarchy is kept until an iteration gains so much less than when it was new: setting
# it up costs as much as 15 iterations (brick of 100k unknowns), of which a sweep needs 5 to 10.
SLOWER = 2.5
# A factorization, which costs as much as 10 iterations (slab of 120k unknowns), is kept while no
# entry of the stiffness's diagonal has changed by more than this fraction of the largest.
DRIFT = 2e-3


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
        self.diagonal, self.kept = self.stiffness.getDiagonal(), self.stiffness.getDiagonal()
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
        apply(prefix, preset)
        self.ksp = self._new_ksp(prefix)
        self.direct = self.ksp.pc.getType() in (PETSc.PC.Type.CHOLESKY, PETSc.PC.Type.LU)
        self.iterations = self.renewals = 0
        self._stale, self._drift, self._pace = True, 0.0, 0.0
        self._forgotten = False

    def _new_ksp(self, prefix: str) -> PETSc.KSP:
        ksp = PETSc.KSP().create(self.stiffness.comm)
        ksp.setOptionsPrefix(prefix)
        ksp.setOperators(self.constrained)
        ksp.setFromOptions()
        ksp.setInitialGuessNonzero(True)
        return ksp

    def _replace_ksp(self) -> None:
        """GAMG keeps interpolation and estimates of eigenvalues, some of it even when it is reset:
        a run that went on after a reset came to other minima."""
        prefix = self.ksp.getOptionsPrefix()
        self.ksp.destroy()
        self.ksp = self._new_ksp(prefix)

    @property
    def exact(self) -> bool:
        """Whether `precondition` is the inverse of the stiffness itself."""
        return self.direct and self._drift == 0

    def forget(self) -> None:
        """Begin with a new preconditioner, and modes without a first guess: what comes then depends
        on the problem alone."""
        self._stale = self._forgotten = True
        for response in self.responses:
            response.set(0.0)

    def _vector(self, values: np.ndarray) -> PETSc.Vec:
        vector = self.rhs.duplicate()
        vector.array_w[:] = values[: vector.getLocalSize()]
        return vector

    def minimize(self, u: PETSc.Vec, values: np.ndarray, *, reduction: float = 0.0) -> None:
        """Overwrite u by the minimizer; what u holds is the first guess of an iterative solver.

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
        self._measure_drift()
        self.force.set(0.0)
        self.force.array_w[self.fixed] = values
        self.load.copy(self.rhs)
        self.constrained.zeroRowsColumns(self.rows, diag=self.pivot, x=self.force, b=self.rhs)
        # How far the modes go is found from a displacement in equilibrium.
        self._solve(self.rhs, u, 0.0 if self.modes else reduction)
        if self.modes:
            self._add_modes(u)

    def _measure_drift(self) -> None:
        """How far the stiffness is from the one that was factorized last."""
        self.stiffness.getDiagonal(self.diagonal)
        self.force.waxpy(-1.0, self.kept, self.diagonal)
        self._drift = self.force.norm(PETSc.NormType.NORM_INFINITY) / self.pivot
        self._stale = self._stale or (self.direct and not self._drift <= DRIFT)

    def _solve(self, rhs: PETSc.Vec, u: PETSc.Vec, reduction: float = 0.0) -> None:
        """Solve, with a new preconditioner if the old one is stale or fails."""
        guess = u.copy()
        try:
            fresh = self._stale
            failure = self._attempt(rhs, u, reduction)
            if failure and not fresh:
                self._stale = True
                guess.copy(u)
                failure = self._attempt(rhs, u, reduction)
        finally:
            guess.destroy()
        if failure:
            other = "iterative" if self.direct else "direct"
            raise SolveError(
                f"the displacement was not solved for: {failure}; try "
                f'solver.displacement = "{other}", or a larger damage.residual_stiffness'
            )

    def _attempt(self, rhs: PETSc.Vec, u: PETSc.Vec, reduction: float) -> str:
        """Solve with the preconditioner at hand, or a new one; what went wrong, or nothing."""
        fresh = self._stale
        if fresh:
            if self._forgotten and not self.direct:
                self._replace_ksp()
            self._forgotten = False
            self.renewals += 1
            self.diagonal.copy(self.kept)
            self._stale, self._drift, self._pace = False, 0.0, 0.0
        before = self._unbalanced(rhs, u)
        if not np.isfinite(before):
            return "its forces are not finite"
        self.ksp.pc.setReusePreconditioner(not fresh)
        self.ksp.setTolerances(atol=reduction * before)
        with petsc_errors("the displacement was not solved for", self.ksp.comm):
            if fresh:  # a solve that has nothing to do would keep the old one
                self.ksp.setUp()
                self.ksp.pc.setUp()
            self.ksp.solve(rhs, u)
        self.iterations += self.ksp.getIterationNumber()
        reason, after, scale = self.ksp.getConvergedReason(), self._unbalanced(rhs, u), rhs.norm()
        if not self.direct:
            self._judge(fresh, before, after)
        # An all-zero right-hand side has the zero solution, whose residual is exactly zero.
        relative = after / scale if scale > 0 else after
        # CG's own residual drifts from the true one by round-off: a tenth more is no failure.
        solved = relative <= LARGEST_RESIDUAL or after <= 1.1 * reduction * before
        # A new factorization may end at its own round-off, above what CG was asked for.
        if solved and (reason > 0 or (self.direct and fresh)):
            return ""
        return (
            f"the linear solver ended with {_name(reason)} and a relative residual of "
            f"{relative:.1e}"
        )

    def _judge(self, fresh: bool, before: float, after: float) -> None:
        """Whether the preconditioner, made for an earlier stiffness, has become too slow."""
        digits = np.log10(before / after) if before > after > 0 else 0.0
        if digits < 1:  # too few to tell
            return
        pace = self.ksp.getIterationNumber() / digits
        if fresh or not self._pace:  # a new one whose first solves had nothing to do
            self._pace = pace
        self._stale = pace > SLOWER * self._pace

    def _unbalanced(self, rhs: PETSc.Vec, u: PETSc.Vec) -> float:
        self.constrained.mult(u, self.force)
        self.force.aypx(-1.0, rhs)
        return self.force.norm()

    def _add_modes(self, u: PETSc.Vec) -> None:
        """u + sum c_j u_j, where u_j answers mode j, and the c_j make the energy smallest."""
        for mode, response, force in zip(self.modes, self.responses, self.forces, strict=True):
            self.stiffness.mult(mode, self.rhs)
            self.rhs.scale(-1.0)
            self.rhs.array_w[self.held] = self.pivot * mode.array_r[self.held]
            self._solve(self.rhs, response)
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

        Symmetric and positive definite; it is the inverse itself if the solver is `exact`, at the
        damage of the last `minimize`. Overwrites `rhs`.
        """
        force.copy(self.rhs)
        self.rhs.array_w[self.held] = 0.0
        self.ksp.pc.apply(self.rhs, u)
        u.array_w[self.held] = 0.0
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
        self.rhs.array_w[self.held] = 0.0
        self._solve(self.rhs, u)
        if self.modes:
            self._add_responses([response.dot(force) for response in self.responses], u)

    def meets(self, u: PETSc.Vec, values: np.ndarray) -> bool:
        """Whether u has these prescribed values on `fixed` already."""
        self.force.set(0.0)
        self.force.array_w[self.fixed] = u.array_r[self.fixed] - values
        return bool(self.force.norm(PETSc.NormType.NORM_INFINITY) == 0.0)

    def curvature(self, u: PETSc.Vec) -> float:
        """u . K u, at the stiffness of the last `minimize`."""
        self.stiffness.mult(u, self.force)
        return float(u.dot(self.force))

    def resist(self, u: PETSc.Vec, force: PETSc.Vec) -> None:
        """Overwrite force by K u, for a u that the supports at rest allow; 0 where they hold."""
        self.stiffness.mult(u, force)
        force.array_w[self.fixed] = 0.0

    def destroy(self) -> None:
        """Free the PETSc objects."""
        vectors = [self.load, self.rhs, self.force, *self.modes, *self.responses, *self.forces]
        vectors += [self.diagonal, self.kept]
        copies = [self.constrained] if self.modes else []
        for thing in [self.ksp, self.stiffness, *copies, *vectors, *self.near_null]:
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
