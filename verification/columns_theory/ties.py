"""Points of a cell that follow others: images in the lattice (Bloch), and turns of the cell."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sparse
from scipy.spatial import KDTree

from verification.columns_theory.cross_sections import CLOSE


@dataclass(frozen=True, kw_only=True)
class Tie:
    """Points that follow others: value = phase times the value of the representative.

    Attributes
    ----------
    of : representative of each point.
    phase : factor of each point.
    """

    of: np.ndarray
    phase: np.ndarray

    def matrix(self) -> sparse.csr_matrix:
        """Values of all points from those of the representatives."""
        kept, column = np.unique(self.of, return_inverse=True)
        count = len(self.of)
        return sparse.csr_matrix((self.phase, (np.arange(count), column)), shape=(count, len(kept)))


def tied(points: np.ndarray, lattice: np.ndarray, k: np.ndarray, free: np.ndarray) -> Tie:
    """Tie points that are one another's images in the lattice.

    Parameters
    ----------
    points : shape (points, dim or more).
    lattice : its vectors, shape (dim, dim).
    k : wave vector, shape (dim,).
    free : True for points that follow none.
    """
    count, dim = len(points), len(lattice)
    of, tree = np.arange(count), KDTree(points)
    steps = np.stack(np.meshgrid(*[(-1, 0, 1)] * dim), axis=-1).reshape(-1, dim)
    for step in steps:
        moved = points.copy()
        moved[:, :dim] += step @ lattice
        away, other = tree.query(moved)
        image = (away < CLOSE) & ~free
        of[image] = np.minimum(of[image], other[image])
    phase = np.exp(1j * (points[:, :dim] - points[of, :dim]) @ k)
    return Tie(of=of, phase=phase)


def fixed_by_turn(partner: np.ndarray, factor: np.ndarray, use: np.ndarray) -> sparse.csr_matrix:
    """Complex values with q = factor conj(q of the partner), from independent real numbers."""
    rows, columns, values, count = [], [], [], 0
    for i, j in enumerate(partner):
        if not use[i] or j < i:
            continue
        units = [np.sqrt(factor[i])] if i == j else [1.0, 1j]
        for unit in units:
            rows.append(i)
            columns.append(count)
            values.append(unit)
            if i != j:
                rows.append(j)
                columns.append(count)
                values.append(factor[j] * np.conj(unit))
            count += 1
    return sparse.csr_matrix((values, (rows, columns)), shape=(len(partner), count))


def on_component(side: sparse.csr_matrix, component: int, dim: int) -> sparse.csr_matrix:
    """Rows of one component among those of all."""
    pick = np.zeros((dim, 1))
    pick[component] = 1
    return sparse.kron(side, pick, format="csr")
