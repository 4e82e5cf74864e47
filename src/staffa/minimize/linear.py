"""Linear systems of the displacement: an iterative solver, with a factorization in reserve."""

from collections.abc import Mapping

from staffa.backend.stack import PETSc

import numpy as np

from staffa.backend.petsc_options import DIRECT, apply, petsc_errors
from staffa.backend.petsc_status import DONE, Ended, how_it_ended
from staffa.errors import SolveError

# A new factorization gives 1e-12 or so; what is worse than this has not been solved.
LARGEST_RESIDUAL = 1e-6
# A residual of this fraction of the stiffness's diagonal times u is round-off of u itself.
ROUND_OFF = 1e-15
# Corrections of one solution: each is solved for by itself, so that a load that is a millionth of
# the last one is met as well as any. A pass that does not halve the residual is the last one.
PASSES, HALF = 6, 0.5
# PETSc ends a solve whose residual grows by 1e4. That of CG may, and here the true one is judged.
NEVER = 1e30
# The options of the direct solver where it takes over.
TAKES_OVER = "u_direct_"
# A multigrid hierarchy is kept until an iteration gains so much less than when it was new: setting
# it up costs as much as 15 iterations (brick of 100k unknowns), of which a sweep needs 5 to 10.
SLOWER = 2.5
# A factorization, which costs as much as 10 iterations (slab of 120k unknowns), is kept while no
# entry of the stiffness's diagonal has changed by more than this fraction of the largest.
DRIFT = 2e-3


class LinearSolver:
    """Conjugate gradients for one matrix that changes, preconditioned by a preset.

    If the iterative solver fails, a factorization takes over, until `begin` is called. It owns its
    PETSc objects. All methods are collective.

    Parameters
    ----------
    matrix : symmetric positive definite.
    diagonal : diagonal of the matrix without supports, from which its change and round-off follow.
    preset, prefix : PETSc options, and their prefix.

    Attributes
    ----------
    direct : True while a factorization is the preconditioner.
    iterations, renewals, takeovers : number of iterations, new preconditioners and take-overs.
    left : 2-norm of the residual force of the last solution.
    """

    def __init__(
        self, matrix: PETSc.Mat, diagonal: PETSc.Vec, preset: Mapping[str, str], prefix: str
    ) -> None:
        self.matrix, self.diagonal, self.kept = matrix, diagonal, diagonal.copy()
        self.force = diagonal.duplicate()
        self.pivot = diagonal.norm(PETSc.NormType.NORM_INFINITY)
        apply(prefix, preset)
        self._prefix = prefix
        self.ksp = self._new_ksp(prefix)
        self.direct = self._is_direct()
        self.iterations = self.renewals = self.takeovers = 0
        self.left = 0.0
        self._stale, self._drift, self._pace = True, 0.0, 0.0
        self._forgotten = False

    def _new_ksp(self, prefix: str) -> PETSc.KSP:
        ksp = PETSc.KSP().create(self.matrix.comm)
        ksp.setOptionsPrefix(prefix)
        ksp.setOperators(self.matrix)
        ksp.setFromOptions()
        self.rtol = ksp.getTolerances()[0]
        return ksp

    def _replace_ksp(self, prefix: str) -> None:
        """Replace the solver by a new one.

        GAMG keeps interpolation and estimates of eigenvalues, some of it even when it is reset: a
        run that continued after a reset found other minima.
        """
        self.ksp.destroy()
        self.ksp = self._new_ksp(prefix)
        self.direct = self._is_direct()
        self._stale, self._forgotten = True, False

    def _is_direct(self) -> bool:
        return self.ksp.pc.getType() in (PETSc.PC.Type.CHOLESKY, PETSc.PC.Type.LU)

    @property
    def took_over(self) -> bool:
        """True if a factorization replaces the iterative solver."""
        return bool(self.ksp.getOptionsPrefix() != self._prefix)

    def take_over(self) -> None:
        """Replace the iterative solver by a factorization."""
        apply(TAKES_OVER, DIRECT)
        self._replace_ksp(TAKES_OVER)
        self.takeovers += 1

    def begin(self) -> None:
        """Start a time step with the solver that was asked for."""
        if self.took_over:
            self._replace_ksp(self._prefix)

    @property
    def exact(self) -> bool:
        """True if the preconditioner is the inverse of the matrix."""
        return self.direct and self._drift == 0

    def forget(self) -> None:
        """Start with a new preconditioner."""
        self._stale = self._forgotten = True

    def changed(self) -> None:
        """Record the distance of the diagonal from that of the matrix factorized last."""
        self.force.waxpy(-1.0, self.kept, self.diagonal)
        self._drift = self.force.norm(PETSc.NormType.NORM_INFINITY) / self.pivot
        self._stale = self._stale or (self.direct and not self._drift <= DRIFT)

    def solve(self, rhs: PETSc.Vec, u: PETSc.Vec, reduction: float = 0.0) -> None:
        """Solve for u: with a new preconditioner if the old one is stale or fails, then directly.

        Parameters
        ----------
        rhs : right-hand side.
        u : first guess, overwritten by the solution.
        reduction : fraction of the residual force at u at which an iterative solver may stop.

        Raises
        ------
        SolveError
            No solver did, or the residual is too large to use.
        """
        guess = u.copy()
        try:
            fresh = self._stale
            failure = self._tried(rhs, u, reduction)
            if failure and not fresh:
                self._stale = True
                guess.copy(u)
                failure = self._tried(rhs, u, reduction)
            if failure and not self.direct:
                self.take_over()
                guess.copy(u)
                failure = self._tried(rhs, u, reduction)
        finally:
            guess.destroy()
        if failure:
            raise SolveError(
                f"displacement solve failed: {failure}; try shorter time steps, or a "
                f"larger damage.residual_stiffness"
            )

    def _tried(self, rhs: PETSc.Vec, u: PETSc.Vec, reduction: float) -> str:
        """Solve as `_attempt` does; an error in PETSc is a failure too."""
        try:
            return self._attempt(rhs, u, reduction)
        except SolveError as error:
            if self.direct:
                raise
            return str(error)

    def _attempt(self, rhs: PETSc.Vec, u: PETSc.Vec, reduction: float) -> str:
        """Solve with the current preconditioner, or a new one; return the failure, or ""."""
        fresh = self._stale
        if fresh:
            if self._forgotten and not self.direct:
                self._replace_ksp(self._prefix)
            self._forgotten = False
            self.renewals += 1
            self.diagonal.copy(self.kept)
            self._stale, self._drift, self._pace = False, 0.0, 0.0
        scale, before = rhs.norm(), self._unbalanced(rhs, u)
        if not (np.isfinite(before) and np.isfinite(scale)):
            return "its forces are not finite"
        self.ksp.pc.setReusePreconditioner(not fresh)
        if fresh:  # a solve that has nothing to do would keep the old one
            with petsc_errors("displacement solve failed", self.ksp.comm):
                self.ksp.setUp()
                self.ksp.pc.setUp()
        goal = max(self.rtol * scale, reduction * before)
        if scale > 0:
            end, spent = self._correct(rhs, u, before, goal)
        else:  # no load, no displacement
            u.set(0.0)
            self.left, end, spent = 0.0, DONE, 0
        self.iterations += spent
        after = self.left
        if not self.direct:
            self._judge(fresh, before, after, spent)
        # CG's own residual drifts from the true one by round-off: a tenth more is no failure. A
        # new factorization may end at its own round-off, above what CG was asked for.
        good = after <= 1.1 * goal or after <= self.round_off(u)
        if good or (
            after <= LARGEST_RESIDUAL * scale and (end.converged or (self.direct and fresh))
        ):
            return ""
        return f"its linear solver left a relative residual of {after / scale:.1e}: {end.sentence}"

    def _correct(
        self, rhs: PETSc.Vec, u: PETSc.Vec, before: float, goal: float
    ) -> tuple[Ended, int]:
        """Add to u the displacements that reduce its residual force to `goal`.

        Each correction starts from zero, and its forces are scaled to about one: neither the last
        step's displacement nor a load next to nothing is a measure of it.

        Returns
        -------
        The end of the last correction, and the iterations of all.
        """
        correction, end, spent = u.duplicate(), DONE, 0
        self.left = before
        try:
            for number in range(PASSES):
                if self.left <= (1.1 if number else 1.0) * goal:
                    break
                size = 2.0 ** np.round(np.log2(self.left))  # exact in binary
                self.force.scale(1 / size)
                self.ksp.setTolerances(rtol=0.0, atol=goal / size, divtol=NEVER)
                with petsc_errors("displacement solve failed", self.ksp.comm):
                    self.ksp.solve(self.force, correction)
                end, spent = how_it_ended(self.ksp), spent + self.ksp.getIterationNumber()
                u.axpy(size, correction)
                last, self.left = self.left, self._unbalanced(rhs, u)
                if not self.left < last:
                    u.axpy(-size, correction)
                    self.left = self._unbalanced(rhs, u)
                if not self.left < HALF * last or (not end.converged and not self.direct):
                    break
        finally:
            correction.destroy()
        return end, spent

    def round_off(self, u: PETSc.Vec) -> float:
        """Return the residual force that round-off of u causes (N; N/m in 2-D)."""
        self.force.pointwiseMult(self.diagonal, u)
        return ROUND_OFF * float(self.force.norm())

    def _judge(self, fresh: bool, before: float, after: float, spent: int) -> None:
        """Mark the preconditioner as stale if it has become too slow for the changed stiffness."""
        digits = np.log10(before / after) if before > after > 0 else 0.0
        if digits < 1:  # too few to tell
            return
        pace = spent / digits
        if fresh or not self._pace:  # a new one whose first solves had nothing to do
            self._pace = pace
        self._stale = pace > SLOWER * self._pace

    def _unbalanced(self, rhs: PETSc.Vec, u: PETSc.Vec) -> float:
        self.matrix.mult(u, self.force)
        self.force.aypx(-1.0, rhs)
        return float(self.force.norm())

    def destroy(self) -> None:
        """Free the PETSc objects."""
        for thing in (self.ksp, self.kept, self.force):
            thing.destroy()
