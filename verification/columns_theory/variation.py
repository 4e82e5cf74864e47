"""First and second variation of the energy of an even array, as its fronts move.

With u eliminated, the second derivative by movements w of the mesh is
H = P_ww - P_wu P_uu^-1 P_uw. It is taken for each wave vector k (Bloch): beyond a wall below its
front, u and w are those of the opposite wall times exp(i k.x). One cell therefore suffices for any
pattern that repeats. Growth of all fronts at G = Gc is stable as long as H is positive for every k:
then no pattern of faster and slower fronts lowers the energy.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from staffa.backend.stack import PETSc

import numpy as np
import scipy.sparse as sparse
from dolfinx import fem

from verification.columns_theory.array import Array
from verification.columns_theory.ties import tied

Solver = Callable[[np.ndarray], np.ndarray]


def factorized(matrix: sparse.csr_matrix) -> Solver:
    """Solve with a symmetric matrix, for any number of right-hand sides (columns)."""
    size = matrix.shape[0]
    csr = sparse.csr_matrix(matrix)
    whole = PETSc.Mat().createAIJ(
        csr.shape,
        csr=(csr.indptr.astype(np.int32), csr.indices.astype(np.int32), csr.data),
        comm=PETSc.COMM_SELF,
    )
    whole.setOption(PETSc.Mat.Option.SPD, True)
    pc = PETSc.PC().create(PETSc.COMM_SELF)
    pc.setOperators(whole)
    pc.setType("cholesky")
    pc.setFactorSolverType("mumps")
    pc.setUp()
    factor = pc.getFactorMatrix()

    def solve(right: np.ndarray) -> np.ndarray:
        columns = right.reshape(size, -1)
        given = PETSc.Mat().createDense(
            columns.shape, array=np.asfortranarray(columns), comm=PETSc.COMM_SELF
        )
        found = PETSc.Mat().createDense(columns.shape, comm=PETSc.COMM_SELF)
        found.setUp()
        factor.matSolve(given, found)
        return np.array(found.getDenseArray()).reshape(right.shape)

    return solve


@dataclass(frozen=True, kw_only=True)
class Wave:
    """Pattern in which fronts move.

    Attributes
    ----------
    k : wave vector times the spacing.
    mirrors : as those of `Array.bloch`.
    """

    k: np.ndarray
    mirrors: Sequence[int] = ()


@dataclass(frozen=True, kw_only=True)
class Even:
    """Array with even fronts at one time.

    Attributes
    ----------
    release : mean G along the fronts, over sigma^2 p/E.
    local : G at each node of the perimeter, over the mean.
    mixed, own : derivatives of the energy by displacements and movements, and by movements twice.
    """

    release: float
    local: np.ndarray
    mixed: np.ndarray
    own: np.ndarray


class Solved:
    """Array with its factorized stiffness, for any time."""

    def __init__(self, array: Array, waves: dict[str, Wave]) -> None:
        self.array, self.waves, dim = array, waves, len(array.section.lattice)
        self.stiffness = array.matrix("uu")
        self.even, self.even_solve = self._factorized(Wave(k=np.zeros(dim), mirrors=(1,) * dim))
        self.known = {name: self._factorized(wave) for name, wave in waves.items()}

    def _factorized(self, wave: Wave) -> tuple[sparse.csr_matrix, Solver]:
        basis = self.array.bloch(wave.k, wave.mirrors)
        reduced = (basis.conj().T @ self.stiffness @ basis).real
        return basis, factorized(sparse.csr_matrix(reduced))

    def release(self, layer: float) -> tuple[float, np.ndarray]:
        """G of even fronts when sqrt(kappa t) is `layer` spacings, and that of each node over it.

        It is over sigma^2 p/E, with the mean along the fronts.
        """
        array, even = self.array, self.even
        array.layer.value = layer
        array.u.x.array[:] = 0
        pull = (even.conj().T @ -array.vector("u")).real
        array.u.x.array[:] = (even @ self.even_solve(pull)).real
        local = -array.moved.T @ array.vector("w")
        return float(local.sum() / array.section.front), local / local.mean()

    def energy(self, layer: float) -> float:
        """Potential energy of a cell, over sigma^2 p^3/E (p^2 in two dimensions)."""
        self.release(layer)
        return float(fem.assemble_scalar(self.array.forms["P"]))

    def at(self, layer: float) -> Even:
        """The array with even fronts, and derivatives, when sqrt(kappa t) is `layer` spacings."""
        release, local = self.release(layer)
        moved = self.array.moved
        return Even(
            release=release,
            local=local,
            mixed=self.array.matrix("uw") @ moved,
            own=moved.T @ (self.array.matrix("ww") @ moved),
        )

    def hessian(self, even: Even, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Second derivative by the free nodes of the fronts, and all nodes from these."""
        section = self.array.section
        none = np.zeros(len(section.perimeter), dtype=bool)
        ties = tied(section.perimeter, section.lattice, self.waves[name].k, none).matrix()
        nodes = np.asarray(ties.todense())
        basis, solve = self.known[name]
        right = basis.conj().T @ (even.mixed @ nodes)
        both = solve(np.hstack([right.real, right.imag]))
        answer = both[:, : nodes.shape[1]] + 1j * both[:, nodes.shape[1] :]
        found = nodes.conj().T @ even.own @ nodes - right.conj().T @ answer
        return (found + found.conj().T) / 2, nodes

    def softest(self, even: Even, name: str) -> tuple[float, np.ndarray]:
        """Least eigenvalue of a pattern, over G of a front, and the movement of the perimeter.

        Movements have unit mean square along the fronts. The array is unstable below zero.
        """
        found, nodes = self.hessian(even, name)
        front = self.array.section.front / len(nodes)
        values, vectors = np.linalg.eigh(found / front / even.release)
        mode = nodes @ vectors[:, 0]
        return float(values[0]), mode / mode[np.argmax(np.abs(mode))]
