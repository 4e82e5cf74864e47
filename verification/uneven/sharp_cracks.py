"""Straight sharp cracks at given places of a cooled slab, each grown at G = Gc by finite elements.

Bilinear rectangles, plane stress, E = 1. A crack is a column of double nodes. The body with all
cracks closed is factorized once, and reduced to the jumps across the cracks. The energy of any set
of lengths then follows from a part of that matrix. Arrested cracks count as any others; none heals.
The sides of a crack may overlap, as in a run without an energy split.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from scipy import sparse
from scipy.linalg import cho_factor, cho_solve
from scipy.sparse.linalg import splu

from staffa.loads.closed_form import Face, Slab

# A crack of these elements is longer than its released nodes tell, in h, as `sharp_pair.py` says.
SHIFT = 0.25
GROWING = 1.1  # ratio of the heights of cells below the deepest crack
TOGETHER = 0.02  # cracks so close to the largest release rate grow in one go
AHEAD = 8  # nodes of each crack that are looked at together
BLOCK = 128  # right-hand sides that are solved together


@dataclass(frozen=True, kw_only=True)
class CrackPath:
    """The vertical line along which a crack may grow, from the cold face.

    Attributes
    ----------
    x : its place along the face.
    deepest : depth to which the crack may grow.
    """

    x: float
    deepest: float


@dataclass(frozen=True, kw_only=True)
class SlabBlock:
    """A slab whose lower face is cooled at once; height and conduction as in `slab`.

    Attributes
    ----------
    width : its extent along the face.
    height : its depth.
    nu : Poisson's ratio.
    severity : drop of the face.
    right : support of the right side; the left one is a plane of symmetry.
    """

    width: float
    height: float = 1.0
    nu: float = 0.2
    severity: float = 54.0
    right: Literal["free", "rollers"] = "free"


class CrackedBlock:
    """A block with closed cracks, reduced to their jumps.

    Parameters
    ----------
    block : the block.
    paths : paths of the cracks, from left to right.
    h : edge of the cells above the deepest end of the paths.
    """

    def __init__(self, block: SlabBlock, paths: Sequence[CrackPath], h: float) -> None:
        self.block, self.paths, self.h = block, paths, h
        y = _heights(block.height, max(path.deepest for path in paths), h)
        x, columns = _columns(block, paths, h)
        self.depth = np.repeat(y, len(x))
        self.counts = np.array([round(path.deepest / h) for path in paths])
        self.starts = np.concatenate([[0], np.cumsum(2 * self.counts)])
        cells, jumps = _corners((len(y), len(x)), columns, self.counts)
        corners = np.stack([np.tile(x, len(y))[cells], self.depth[cells]], 2)
        stiffness, thermal = _assembled(corners, cells, jumps, block.nu)
        bulk, free = 2 * self.depth.size, self._free((len(y), len(x)))
        self._factor = splu(
            stiffness[free][:, free].tocsc(),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        self._across = stiffness[free][:, bulk:].tocsc()
        self._thermal = thermal[free], thermal[bulk:]
        self.condensed = stiffness[bulk:, bulk:].toarray()
        for start in range(0, self._across.shape[1], BLOCK):
            part = slice(start, start + BLOCK)
            solved = self._factor.solve(self._across[:, part].toarray())
            self.condensed[:, part] -= self._across.T @ solved

    def _free(self, shape: tuple[int, int]) -> np.ndarray:
        """Return the unknowns of the bulk that no support holds; shape: rows, columns of nodes."""
        node = np.arange(shape[0] * shape[1]).reshape(shape)
        held = [2 * node[:, 0], np.array([2 * node[-1, 0] + 1])]
        if self.block.right == "rollers":
            held.append(2 * node[:, -1])
        return np.setdiff1d(np.arange(2 * node.size), np.concatenate(held))

    def pull(self, tau: float) -> np.ndarray:
        """Return the force that opens the jumps while all are closed, shape (jumps,).

        Parameters
        ----------
        tau : dimensionless time of the cooling.
        """
        face = Face(axis=1, position=0.0, inward=1)
        slab = Slab(dT=self.block.severity, kappa=1.0, face=face, L=self.block.height)
        points = np.stack([0 * self.depth, self.depth, 0 * self.depth])
        T = slab.temperature(points, tau**2 / 4)
        inside, across = (part @ T for part in self._thermal)
        return np.asarray(across - self._across.T @ self._factor.solve(inside))

    def jumps(self, tau: float) -> "Jumps":
        """Return the jumps across all cracks, and what opens them at a time.

        Parameters
        ----------
        tau : dimensionless time of the cooling.
        """
        return Jumps(
            matrix=self.condensed, pull=self.pull(tau), starts=self.starts, counts=self.counts
        )


@dataclass(frozen=True, kw_only=True)
class Jumps:
    """Nodes by which cracks may grow: two jumps each, crack by crack, in the order of opening.

    Attributes
    ----------
    matrix : stiffness of the jumps, shape (jumps, jumps).
    pull : force on them while all are closed, shape (jumps,).
    starts : first jump of each crack, shape (cracks,) or longer.
    counts : number of nodes of each crack, shape (cracks,).
    """

    matrix: np.ndarray
    pull: np.ndarray
    starts: np.ndarray
    counts: np.ndarray

    def opened(self, counts: np.ndarray) -> np.ndarray:
        """Return the jumps of the first nodes of the cracks, for these numbers of them."""
        pairs = zip(self.starts, counts, strict=False)
        return np.concatenate([start + np.arange(2 * count) for start, count in pairs]).astype(int)

    def beyond(self, counts: np.ndarray, ahead: int) -> "Jumps":
        """Return the next nodes of cracks of these numbers of nodes, which are open.

        Parameters
        ----------
        counts : numbers of nodes of the cracks, shape (cracks,).
        ahead : number of the next nodes at most.
        """
        left = np.minimum(self.counts - counts, ahead)
        now, starts = self.opened(counts), self.starts[: len(counts)] + 2 * counts
        pairs = zip(starts, left, strict=True)
        following = np.concatenate([a + np.arange(2 * n) for a, n in pairs]).astype(int)
        across = self.matrix[np.ix_(now, following)]
        factor = cho_factor(self.matrix[np.ix_(now, now)], lower=True)
        solved = cho_solve(factor, np.column_stack([self.pull[now], across]))
        return Jumps(
            matrix=self.matrix[np.ix_(following, following)] - across.T @ solved[:, 1:],
            pull=self.pull[following] - across.T @ solved[:, 0],
            starts=np.append(0, np.cumsum(2 * left)),
            counts=left,
        )

    def released(self) -> np.ndarray:
        """Return the energy that each crack releases by its first node; 0 without one."""
        found = np.zeros(len(self.counts))
        for crack in np.flatnonzero(self.counts):
            own = slice(self.starts[crack], self.starts[crack] + 2)
            found[crack] = (
                0.5 * self.pull[own] @ np.linalg.solve(self.matrix[own, own], self.pull[own])
            )
        return found

    def openings(self, counts: np.ndarray) -> list[np.ndarray]:
        """Return the openings of the cracks at their nodes, from the face down.

        Parameters
        ----------
        counts : numbers of nodes of the cracks, shape (cracks,).
        """
        now = self.opened(counts)
        found = np.linalg.solve(self.matrix[np.ix_(now, now)], self.pull[now])[0::2]
        return np.split(found, np.cumsum(counts)[:-1])


def grown(
    body: CrackedBlock,
    tau: float,
    lengths: np.ndarray,
    toughness: Callable[[np.ndarray, np.ndarray], np.ndarray] | None = None,
) -> np.ndarray:
    """Return the depths at which no crack releases its toughness any more, shape (cracks,).

    Time and again the crack grows by a node whose release rate is largest over its toughness, and
    with it those that come within TOGETHER of it.

    Parameters
    ----------
    body : the body with closed cracks.
    tau : dimensionless time of the cooling.
    lengths : depths of the cracks at first, shape (cracks,); none gets smaller.
    toughness : toughness at points x and y, over that of E, nu and severity; by default 1.
    """
    counts, jumps = np.rint(lengths / body.h + SHIFT).astype(int), body.jumps(tau)
    x = np.array([path.x for path in body.paths])
    while True:
        window, new = jumps.beyond(counts, AHEAD), 0 * counts
        while (new < window.counts)[window.counts > 0].all():
            rates = window.beyond(new, 1).released() / body.h
            if toughness is not None:
                rates /= toughness(x, body.h * (counts + new + 0.5))
            if rates.max() <= 1:
                return np.maximum(lengths, body.h * (counts + new - SHIFT))
            new += rates >= max(1.0, (1 - TOGETHER) * rates.max())
        counts = counts + new


def _heights(height: float, deepest: float, h: float) -> np.ndarray:
    """Return the depths of the rows of nodes: h apart down to the deepest crack and a little on."""
    fine = h * np.arange(round(deepest / h) + 4)
    below = fine[-1] + np.cumsum(h * GROWING ** np.arange(1, 200))
    below = below[: int(np.searchsorted(below, height)) + 1]
    below = fine[-1] + (below - fine[-1]) * (height - fine[-1]) / (below[-1] - fine[-1])
    return np.concatenate([fine, below])


def _columns(
    block: SlabBlock, paths: Sequence[CrackPath], h: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the places of the columns of nodes, and which of them are the cracks'."""
    x, columns = [np.zeros(1)], []
    ends = [0.0, *(path.x for path in paths), block.width]
    for left, right in pairwise(ends):
        assert right > left, "paths must come from left to right"
        parts = max(2, round((right - left) / h))
        x.append(np.linspace(left, right, parts + 1)[1:])
        columns.append(sum(map(len, x)) - 1)
    return np.concatenate(x), np.array(columns[:-1])


def _corners(
    shape: tuple[int, int], columns: np.ndarray, counts: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and jumps at the corners of the cells, shape (cells, 4), counterclockwise.

    A cell to the right of a crack has the jump of the crack's node, as a number beyond those of
    the nodes; elsewhere it is -1.

    Parameters
    ----------
    shape : number of rows and columns of nodes.
    columns : columns of the cracks, shape (cracks,).
    counts : numbers of their double nodes, shape (cracks,).
    """
    node = np.arange(shape[0] * shape[1]).reshape(shape)
    jump, number = np.full(shape, -1), node.size
    for column, count in zip(columns, counts, strict=True):
        jump[:count, column] = number + np.arange(count)
        number += count
    none = np.full((shape[0] - 1, shape[1] - 1), -1)
    cells = np.stack([node[:-1, :-1], node[:-1, 1:], node[1:, 1:], node[1:, :-1]], 2)
    jumps = np.stack([jump[:-1, :-1], none, none, jump[1:, :-1]], 2)
    return cells.reshape(-1, 4), jumps.reshape(-1, 4)


def _assembled(
    corners: np.ndarray, cells: np.ndarray, jumps: np.ndarray, nu: float
) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
    """Return stiffness and thermal force by nodal temperature.

    Unknowns are the displacements of the nodes, to the left of cracks, then the jumps.

    Parameters
    ----------
    corners : places of the cells' corners, shape (cells, 4, 2).
    cells : their nodes, shape (cells, 4).
    jumps : their jumps, or -1, shape (cells, 4).
    nu : Poisson's ratio.
    """
    local, force = _elements(corners, nu)
    nodes, corner, here = cells.ravel(), np.arange(cells.size), jumps.ravel() >= 0
    rows = np.concatenate([corner, corner[here]])
    spread = sparse.csr_matrix((np.ones(len(rows)), (rows, np.append(nodes, jumps.ravel()[here]))))
    gather = sparse.csr_matrix((np.ones(len(nodes)), (corner, nodes)))
    spread = sparse.kron(spread, sparse.eye(2), format="csr")
    index = np.arange(len(cells) + 1)
    stiffness = sparse.bsr_matrix((local, index[:-1], index)).tocsr()
    thermal = sparse.bsr_matrix((force, index[:-1], index)).tocsr()
    return (spread.T @ stiffness @ spread).tocsr(), (spread.T @ thermal @ gather).tocsr()


def _elements(corners: np.ndarray, nu: float) -> tuple[np.ndarray, np.ndarray]:
    """Return stiffness (n, 8, 8) and thermal force by nodal temperature (n, 8, 4) of cells, E = 1.

    Parameters
    ----------
    corners : places of the corners, shape (n, 4, 2), counterclockwise.
    nu : Poisson's ratio.
    """
    elastic = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]]) / (1 - nu**2)
    around = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    stiffness = np.zeros((len(corners), 8, 8))
    thermal = np.zeros((len(corners), 8, 4))
    for xi, eta in around / np.sqrt(3):
        shape = 0.25 * (1 + xi * around[:, 0]) * (1 + eta * around[:, 1])
        along = 0.25 * around[:, 0] * (1 + eta * around[:, 1])
        up = 0.25 * around[:, 1] * (1 + xi * around[:, 0])
        jacobian = np.stack([along, up]) @ corners
        slopes = np.linalg.solve(jacobian, np.broadcast_to([along, up], (len(corners), 2, 4)))
        strain = np.zeros((len(corners), 3, 8))
        strain[:, 0, 0::2], strain[:, 1, 1::2] = slopes[:, 0], slopes[:, 1]
        strain[:, 2, 0::2], strain[:, 2, 1::2] = slopes[:, 1], slopes[:, 0]
        weight = np.linalg.det(jacobian)[:, None, None]
        stress = np.swapaxes(strain, 1, 2) @ elastic
        stiffness += weight * stress @ strain
        thermal += weight * (stress @ np.array([1.0, 1.0, 0.0]))[:, :, None] * shape
    return stiffness, thermal
