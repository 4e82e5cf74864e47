"""Second-order stability: the second derivative of the energy over admissible rates.

Q(v, b) = v.K v + 2 b.C v + b.H b is the second derivative of the energy. In the space V, b is free
at the points I where the first derivative in the damage vanishes, and zero elsewhere: if the
smallest value of Q/(b.M b) reaches zero there, the evolution may bifurcate. In the cone of
admissible rates b >= 0 as well, as irreversibility demands: if the smallest value reaches zero
there, the state is no longer stable (Pham and Marigo 2013; Leon Baldelli and Maurini 2021).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from types import SimpleNamespace

from staffa.backend.stack import PETSc, SLEPc

import numpy as np

from staffa.backend.parallel import max_over_ranks, sum_over_ranks
from staffa.backend.petsc_options import INERTIA, ON_THE_CONE, apply, petsc_errors
from staffa.backend.petsc_status import how_it_ended
from staffa.backend.vectors import readable, writable
from staffa.errors import SolveError
from staffa.minimize.bounded import BoundedEnergy, SnesSolver

# Shifts, lowered by this factor until no eigenvalue lies below; the first, and the last to try.
LOWER, FIRST, LAST = 4.0, -1.0, -1e12
# Accuracy of the value in the cone, as a fraction of its distance to the shift; most solves.
ACCURACY, SOLVES = 1e-7, 500


@dataclass(frozen=True, kw_only=True)
class Mode:
    """Smallest value of Q/(b.M b), and the rate at which it is attained, with a largest |b| of one.

    Attributes
    ----------
    value : the smallest value.
    v : displacement of the rate, owned entries.
    b : damage of the rate, owned entries.
    negative : number of negative eigenvalues in the space V, by Sylvester's law of inertia.
    """

    value: float
    v: np.ndarray
    b: np.ndarray
    negative: int = 0


class SecondVariation:
    """Q on the free unknowns, as one matrix A, and M. All methods are collective.

    Parameters
    ----------
    stiffness, mixed, hessian : K, C (rows of damage, columns of displacement), H; not kept.
    mass : M, lumped: one positive number for each entry of the damage; not kept.
    fixed, moved, modes : as in `elastic.ElasticSolver`.
    free : True at the owned entries of the damage that belong to I.
    """

    def __init__(
        self,
        *,
        stiffness: PETSc.Mat,
        mixed: PETSc.Mat,
        hessian: PETSc.Mat,
        mass: PETSc.Vec,
        fixed: np.ndarray,
        moved: np.ndarray,
        modes: Sequence[np.ndarray],
        free: np.ndarray,
    ) -> None:
        self.comm = stiffness.comm.tompi4py()
        self.ways = _ways(stiffness, fixed, moved, modes)
        self.free, self.n_damage = np.flatnonzero(free), len(free)
        rows = (self.free + hessian.getOwnershipRange()[0]).astype(PETSc.IntType)
        chosen = PETSc.IS().createGeneral(rows, comm=stiffness.comm)
        K = stiffness.ptap(self.ways)
        CW = mixed.matMult(self.ways)
        first, last = CW.getOwnershipRangeColumn()
        columns = PETSc.IS().createStride(last - first, first=first, comm=stiffness.comm)
        C, H = CW.createSubMatrix(chosen, columns), hessian.createSubMatrix(chosen, chosen)
        CT = PETSc.Mat()
        C.transpose(CT)
        nest = PETSc.Mat().createNest([[K, CT], [C, H]], comm=stiffness.comm)
        self.A = nest.convert("aij", PETSc.Mat())
        self.n_v = K.getLocalSize()[0]
        self.size = int(sum_over_ranks(self.comm, len(self.free)))
        # M bears on the damage alone.
        self.mass = self.A.createVecRight()
        writable(self.mass)[: self.n_v] = 0.0
        writable(self.mass)[self.n_v :] = readable(mass)[self.free]
        for thing in (nest, K, CW, C, CT, H, chosen, columns):
            thing.destroy()

    def shifted(self, shift: float) -> PETSc.Mat:
        """Return A - shift M; the caller destroys it."""
        found, diagonal = self.A.copy(), self.A.getDiagonal()
        diagonal.axpy(-shift, self.mass)
        found.setDiagonal(diagonal)
        diagonal.destroy()
        return found

    def on_the_space(self) -> Mode:
        """Return the smallest eigenvalue in the space V, and its mode.

        Raises
        ------
        SolveError
            A factorization failed, or SLEPc did not converge.
        """
        factored = _Factored(self, 0.0)
        negative, shift = factored.negative, FIRST
        try:
            # Where nothing lies below the shift, the eigenvalue nearest to it is the smallest.
            while factored.negative:
                if shift < LAST:
                    raise SolveError("the second derivative of the energy has no smallest value")
                factored.destroy()
                factored = _Factored(self, shift)
                shift *= LOWER
            value, z = factored.nearest()
        finally:
            factored.destroy()
        return self._mode(value, z, negative)

    def on_the_cone(self, space: Mode) -> Mode:
        """Return the smallest value in the cone of admissible rates, b >= 0, and its rate.

        Inverse iteration: z' minimizes z.(A - shift M) z/2 - z.M z_k over the cone, on which the
        quotient falls from z_k to z'. The shift lies below the smallest eigenvalue in the space V,
        so that each of these problems is convex. The quotient may have several minima in the cone:
        it is started at both signs of the mode in V, and at a uniform b, and the lowest result is
        taken.

        Raises
        ------
        SolveError
            A bounded problem was not solved, or the iteration did not converge.
        """
        even = np.ones(len(self.free))
        mode = space.b[self.free]
        if not max_over_ranks(self.comm, -mode) > 0:
            return space  # it lies in the cone already
        shift = space.value - max(0.05 * abs(space.value), 1e-3)
        iteration = _OnTheCone(self, shift)
        try:
            starts = [np.maximum(mode, 0.0), np.maximum(-mode, 0.0), even]
            starts = [b for b in starts if max_over_ranks(self.comm, b) > 0]
            found = [iteration.from_damage(b) for b in starts]
        finally:
            iteration.destroy()
        (value, z), *others = sorted(found, key=lambda pair: pair[0])
        for _, other in others:
            other.destroy()
        return self._mode(value, z, space.negative)

    def _mode(self, value: float, z: PETSc.Vec, negative: int) -> Mode:
        b = np.zeros(self.n_damage)
        b[self.free] = readable(z)[self.n_v :]
        most, least = max_over_ranks(self.comm, b), max_over_ranks(self.comm, -b)
        scale = most if most >= least else -least
        v, way = self.ways.createVecLeft(), self.ways.createVecRight()
        writable(way)[:] = readable(z)[: self.n_v]
        self.ways.mult(way, v)
        found = Mode(value=value, v=readable(v) / scale, b=b / scale, negative=negative)
        for vector in (z, v, way):
            vector.destroy()
        return found

    def destroy(self) -> None:
        """Free the PETSc objects."""
        for thing in (self.A, self.mass, self.ways):
            thing.destroy()


class _Factored:
    """Factorization of A - shift M; with M only on the damage, an operator on the damage alone.

    The operator S^-1 = M^1/2 (A - shift M)^-1 M^1/2 has the values 1/(value of Q/(b.M b) - shift).
    A generalized problem on all unknowns, with an M that is zero on most of them, made SLEPc break
    down if many values are the same.
    """

    def __init__(self, variation: SecondVariation, shift: float) -> None:
        self.variation, self.shift = variation, shift
        matrix = variation.shifted(shift)
        self.ksp = PETSc.KSP().create(matrix.comm)
        self.ksp.setOptionsPrefix("inertia_")
        apply("inertia_", INERTIA)
        self.ksp.setOperators(matrix)
        self.ksp.setFromOptions()
        self.root = np.sqrt(readable(variation.mass)[variation.n_v :])
        self.load, self.z = variation.mass.duplicate(), variation.mass.duplicate()
        matrix.destroy()  # the solver keeps it
        try:
            with petsc_errors("the inertia was not found", self.ksp.comm):
                self.ksp.setUp()
                factor = self.ksp.pc.getFactorMatrix()
                if factor.handle == 0 or self.ksp.pc.getFailedReason():
                    raise SolveError("the inertia was not found: the factorization failed")
                self.negative = int(factor.getInertia()[0])
        except SolveError:
            self.destroy()
            raise

    def mult(self, _: PETSc.Mat, y: PETSc.Vec, out: PETSc.Vec) -> None:
        """Write S^-1 y, as PETSc's shell matrices call it."""
        self._solve(y)
        writable(out)[:] = self.root * readable(self.z)[self.variation.n_v :]

    def _solve(self, y: PETSc.Vec) -> None:
        self.load.set(0.0)
        writable(self.load)[self.variation.n_v :] = self.root * readable(y)
        self.ksp.solve(self.load, self.z)
        end = how_it_ended(self.ksp)
        if not end.converged:
            raise SolveError(
                f"the second derivative of the energy was not inverted: {end.sentence}"
            )

    def nearest(self) -> tuple[float, PETSc.Vec]:
        """Return the smallest value, if none lies below the shift, and its vector."""
        size = (len(self.variation.free), self.variation.size)
        shell = SimpleNamespace(mult=self.mult)
        inverse = PETSc.Mat().createPython((size, size), shell, comm=self.ksp.comm)
        inverse.setUp()
        eps = SLEPc.EPS().create(self.ksp.comm)
        eps.setOptionsPrefix("stability_")
        eps.setOperators(inverse)
        eps.setProblemType(SLEPc.EPS.ProblemType.HEP)
        eps.setWhichEigenpairs(SLEPc.EPS.Which.LARGEST_REAL)
        eps.setTolerances(1e-9, 500)
        eps.setFromOptions()
        y = inverse.createVecRight()
        try:
            with petsc_errors("the smallest eigenvalue was not found", eps.comm):
                eps.solve()
        except SolveError:
            eps.incRef()  # SLEPc can no longer free it, so that collecting it as garbage would fail
            raise
        try:
            if eps.getConverged() < 1:
                raise SolveError(
                    f"the smallest eigenvalue was not found by SLEPc: {how_it_ended(eps).sentence}"
                )
            value = self.shift + 1 / float(eps.getEigenpair(0, y).real)
            self._solve(y)
            return value, self.z.copy()
        finally:
            for thing in (eps, inverse, y):
                thing.destroy()

    def destroy(self) -> None:
        """Free the PETSc objects."""
        for thing in (self.ksp, self.load, self.z):
            thing.destroy()


class _OnTheCone:
    """Inverse iteration with one shift, on vectors whose damage is not negative."""

    def __init__(self, variation: SecondVariation, shift: float) -> None:
        self.variation, self.shift = variation, shift
        self.matrix, mass = variation.shifted(shift), variation.mass
        self.z, self.load, self.work = (mass.duplicate() for _ in range(3))
        self.lower, self.upper, self.unit = (mass.duplicate() for _ in range(3))
        self.lower.set(0.0)
        writable(self.lower)[: variation.n_v] = PETSc.NINFINITY
        self.upper.set(PETSc.INFINITY)
        self.unit.set(mass.max()[1])
        self.filled = self.matrix.duplicate()
        self.solver = SnesSolver(
            BoundedEnergy(
                move_to=lambda x: x.copy(self.work),
                value=lambda: 0.0,
                gradient=self._gradient,
                hessian=lambda H: self.matrix.copy(H, PETSc.Mat.Structure.SAME_NONZERO_PATTERN),
                matrix=self.filled,
                unit=self.unit,
                quadratic=True,
            ),
            tolerance=1e-7,
            preset=ON_THE_CONE,
            prefix="cone_",
        )

    def _gradient(self, out: PETSc.Vec) -> None:
        self.matrix.mult(self.work, out)
        out.axpy(-1.0, self.load)

    def from_damage(self, b: np.ndarray) -> tuple[float, PETSc.Vec]:
        """Return the quotient at the end, and its vector; the caller destroys the vector."""
        writable(self.z)[: self.variation.n_v] = 0.0
        writable(self.z)[self.variation.n_v :] = b
        value = float("inf")
        for _ in range(SOLVES):
            self.load.pointwiseMult(self.variation.mass, self.z)
            self.solver.minimize(self.z, self.lower, self.upper)
            damage = readable(self.z)[self.variation.n_v :]
            self.z.scale(1 / max_over_ranks(self.variation.comm, damage))
            before, value = value, self._quotient()
            if abs(before - value) <= ACCURACY * (value - self.shift):
                return value, self.z.copy()
        raise SolveError(f"the iteration in the cone did not converge in {SOLVES} solves")

    def _quotient(self) -> float:
        self.variation.A.mult(self.z, self.work)
        bending = self.z.dot(self.work)
        self.work.pointwiseMult(self.variation.mass, self.z)
        return float(bending / self.z.dot(self.work))

    def destroy(self) -> None:
        """Free the PETSc objects."""
        self.solver.destroy()
        mine = (self.matrix, self.filled, self.z, self.load, self.work)
        for thing in (*mine, self.lower, self.upper, self.unit):
            thing.destroy()


def _ways(
    stiffness: PETSc.Mat, fixed: np.ndarray, moved: np.ndarray, modes: Sequence[np.ndarray]
) -> PETSc.Mat:
    """Return a matrix whose columns are the possible displacements.

    There is one column for each free entry and for each mode.
    """
    comm, (first, last) = stiffness.comm, stiffness.getOwnershipRange()
    own = np.ones(last - first, dtype=bool)
    own[fixed] = own[moved] = False
    rows = np.flatnonzero(own)
    extra = len(modes) if comm.rank == 0 else 0  # the modes' columns belong to rank 0
    ways = PETSc.Mat().createAIJ(
        ((last - first, None), (len(rows) + extra, None)), nnz=1 + len(modes), comm=comm
    )
    start = ways.getOwnershipRangeColumn()[0] + extra
    for column, row in enumerate(rows):
        ways.setValue(first + row, start + column, 1.0)
    for number, mode in enumerate(modes):
        for row in moved:
            ways.setValue(first + row, number, mode[row])
    ways.assemble()
    return ways
