"""A mesh of simplices of which some cells are split: names, and values at points, pass to it."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.sparse import csr_array, eye_array

from staffa.geometry.simplices import Simplices, facets, keys


@dataclass(frozen=True, kw_only=True)
class Nested:
    """A mesh whose cells lie in those of a coarser one.

    Attributes
    ----------
    mesh : the finer mesh; the points of the coarser one come first in it, as they were.
    values : matrix from values at the coarser points to those at the finer ones, exact for linear
        functions in each coarser cell, shape (n_finer, n_coarser).
    parents : coarser cell of each finer cell, shape (m_finer,).
    """

    mesh: Simplices
    values: csr_array
    parents: np.ndarray

    def then(self, other: "Nested") -> "Nested":
        """Return the relation of this coarser mesh to the finer one of `other`."""
        return Nested(
            mesh=other.mesh,
            values=csr_array(other.values @ self.values),
            parents=self.parents[other.parents],
        )


def itself(mesh: Simplices) -> Nested:
    """Return the relation of a mesh to itself."""
    n = len(mesh.x)
    return Nested(mesh=mesh, values=csr_array(eye_array(n)), parents=np.arange(len(mesh.cells)))


def nested(mesh: Simplices, corners: np.ndarray, parents: np.ndarray) -> Nested:
    """Return the mesh of cells that lie in those of another, whose edges were halved.

    Points are in an order that does not depend on that of the cells.

    Parameters
    ----------
    mesh : the coarser mesh.
    corners : points of the corners of each finer cell (m), shape (m, dim + 1, dim): points of the
        coarser mesh, or middles of its edges.
    parents : coarser cell of each of them, shape (m,).
    """
    ends = _ends(mesh, corners, parents)
    old = ends[..., 0] == ends[..., 1]
    middles = np.unique(ends[~old], axis=0)
    cells = np.where(old, ends[..., 0], 0)
    cells[~old] = len(mesh.x) + _rows_in(middles, ends[~old])
    n_old, n = len(mesh.x), len(mesh.x) + len(middles)
    pairs = np.concatenate([np.stack([np.arange(n_old)] * 2, axis=1), middles])
    half = np.full(2 * n, 0.5)
    values = csr_array((half, (np.repeat(np.arange(n), 2), pairs.ravel())), shape=(n, n_old))
    finer = Simplices(
        x=np.concatenate([mesh.x, mesh.x[middles].mean(axis=1)]),
        cells=cells,
        regions={name: _children(parents, old_cells) for name, old_cells in mesh.regions.items()},
        faces=_split_facets(cells, pairs, mesh.faces),
        cracks=_split_facets(cells, pairs, mesh.cracks),
        notes=mesh.notes,
    )
    return Nested(mesh=finer, values=values, parents=parents)


def _ends(mesh: Simplices, corners: np.ndarray, parents: np.ndarray) -> np.ndarray:
    """Return the two coarser points between which each corner lies, the same twice for one of
    these, shape (m, dim + 1, 2)."""
    width = mesh.dim + 1
    pairs = np.array([*((k, k) for k in range(width)), *combinations(range(width), 2)])
    ends = np.repeat(mesh.cells[parents][..., None], 2, axis=2)
    split = np.flatnonzero(np.bincount(parents)[parents] > 1)
    theirs = mesh.cells[parents[split]]
    places = mesh.x[theirs][:, pairs].mean(axis=2)  # (m, pairs, dim)
    for corner in range(width):
        away = np.linalg.norm(corners[split, corner, None] - places, axis=2)
        found = theirs[np.arange(len(split))[:, None], pairs[away.argmin(axis=1)]]
        ends[split, corner] = np.sort(found, axis=1)
    return ends


def _rows_in(rows: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Return the place of each wanted row among sorted rows."""
    largest = int(rows.max(initial=0)) + 1
    return np.searchsorted(rows @ [largest, 1], wanted @ [largest, 1])


def _children(parents: np.ndarray, cells: np.ndarray) -> np.ndarray:
    return np.flatnonzero(np.isin(parents, cells))


def _split_facets(
    cells: np.ndarray, pairs: np.ndarray, named: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Return the finer facets that each name's coarser facets consist of."""
    if not named:
        return {}
    every = facets(cells).reshape(-1, cells.shape[1] - 1)
    every = every[np.unique(keys(every), return_index=True)[1]]
    # A facet lies in a coarser one if all that its corners lie between are corners of that one.
    around = np.sort(pairs[every].reshape(len(every), -1), axis=1)
    distinct = 1 + (np.diff(around, axis=1) > 0).sum(axis=1)
    within, width = distinct == every.shape[1], every.shape[1]
    every, around = every[within], around[within]
    first = np.diff(around, axis=1, prepend=-1) != 0
    parents = around[first].reshape(-1, width)
    number = keys(np.concatenate([parents, *named.values()]))
    ends = np.cumsum([len(parents), *(len(rows) for rows in named.values())])
    theirs = zip(named, np.split(number, ends)[1:], strict=False)
    return {name: every[np.isin(number[: len(parents)], rows)] for name, rows in theirs}
