"""Triangles and tetrahedra as plain arrays, with the names of their parts: what Gmsh gives."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import scipy

from staffa.geometry.edges import edges
from staffa.geometry.outline import FlatFace, Outline, pairs
from staffa.geometry.places import ALONG, SAME, OfMesh, Sample, as_space_points, some


@dataclass(frozen=True, kw_only=True)
class Simplices:
    """A mesh of triangles (dim 2) or tetrahedra (dim 3).

    Attributes
    ----------
    x : points (m), shape (n, dim), each the corner of a cell.
    cells : corners of the cells, shape (m, dim + 1).
    regions : numbers of the cells of each region.
    faces : corners of the facets of each face, on the surface, shape (k, dim).
    cracks : corners of the facets of each crack, inside of the body, shape (k, dim).
    notes : changes that reading it from a file made.
    """

    x: np.ndarray
    cells: np.ndarray
    regions: Mapping[str, np.ndarray]
    faces: Mapping[str, np.ndarray]
    cracks: Mapping[str, np.ndarray]
    notes: tuple[str, ...] = ()

    @property
    def dim(self) -> int:
        """Return the dimension, 2 or 3."""
        return int(self.x.shape[1])


def keys(rows: np.ndarray) -> np.ndarray:
    """Return a number for each row of corners, the same for any order of them, shape (k,)."""
    ordered = np.sort(rows, axis=1)
    largest = int(ordered.max(initial=0)) + 1
    if largest ** rows.shape[1] < 2**63:
        return np.asarray(np.ravel_multi_index(tuple(ordered.T), (largest,) * rows.shape[1]))
    return np.unique(ordered, axis=0, return_inverse=True)[1]


def facets(cells: np.ndarray) -> np.ndarray:
    """Return the facets of each cell, opposite to corner i in place i: (m, dim + 1, dim)."""
    width = cells.shape[1]
    return np.stack([np.delete(cells, i, axis=1) for i in range(width)], axis=1)


def count_bodies(mesh: Simplices) -> int:
    """Return the number of bodies of the mesh that share no point."""
    width = mesh.cells.shape[1]
    start, end = np.repeat(mesh.cells[:, 0], width - 1), mesh.cells[:, 1:].ravel()
    n = len(mesh.x)
    links = scipy.sparse.coo_array((np.ones(len(start), dtype=bool), (start, end)), shape=(n, n))
    return int(scipy.sparse.csgraph.connected_components(links, directed=False)[0])


def mesh_outline(mesh: Simplices) -> Outline:
    """Return the outline of the body, with the mean edge of its cells."""
    lower, upper = mesh.x.min(axis=0), mesh.x.max(axis=0)
    named = {"faces": mesh.faces, "cracks": mesh.cracks, "regions": mesh.regions}
    local = edges(mesh.x, mesh.cells, _edges(mesh), **named)
    return Outline(
        lower=tuple(lower.tolist()),
        upper=tuple(upper.tolist()),
        h=local.mean,
        edges=local,
        faces={name: _plane(mesh, rows) for name, rows in mesh.faces.items()},
        touching=pairs(_touching(mesh.faces)),
        regions=tuple(mesh.regions),
        cracks=tuple(mesh.cracks),
        n_cells=len(mesh.cells),
        n_vertices=len(mesh.x),
        notes=mesh.notes,
        places=OfMesh(
            cells=_sample(mesh.x, mesh.cells),
            regions={name: _sample(mesh.x, mesh.cells[c]) for name, c in mesh.regions.items()},
            vertices=as_space_points(mesh.x[some(len(mesh.x))]),
            faces={name: _corners(mesh.x, rows) for name, rows in mesh.faces.items()},
        ),
    )


def _sample(x: np.ndarray, cells: np.ndarray) -> Sample:
    """Return the cells parted by a grid: of each part the middle of the cell that is most in its
    middle, and the size of all."""
    corners = x[cells]
    sizes, middles = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])), corners.mean(axis=1)
    low, high = middles.min(axis=0), middles.max(axis=0)
    at = ALONG * (middles - low) / np.maximum(high - low, np.finfo(float).tiny)
    columns = tuple(np.minimum(at.astype(int), ALONG - 1).T)
    _, part = np.unique(np.ravel_multi_index(columns, (ALONG,) * x.shape[1]), return_inverse=True)
    size = np.bincount(part, sizes)
    center = np.stack([np.bincount(part, sizes * c) / size for c in middles.T], axis=1)
    order = np.lexsort((np.linalg.norm(middles - center[part], axis=1), part))
    first = order[np.searchsorted(part[order], np.arange(len(size)))]
    return Sample(as_space_points(middles[first]), size)


def _corners(x: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return some of the corners of facets."""
    corners = np.unique(rows)
    return as_space_points(x[corners[some(len(corners))]])


def _edges(mesh: Simplices) -> np.ndarray:
    """Return the two ends of each edge, each once, shape (k, 2)."""
    ends = np.concatenate([mesh.cells[:, p] for p in combinations(range(mesh.dim + 1), 2)])
    return ends[np.unique(keys(ends), return_index=True)[1]]


def _plane(mesh: Simplices, rows: np.ndarray) -> FlatFace | None:
    x = mesh.x[np.unique(rows)]
    small = SAME * np.ptp(mesh.x, axis=0).max()
    flat = np.flatnonzero(np.ptp(x, axis=0) <= small)
    if not len(flat):
        return None
    axis = int(flat[0])
    behind = mesh.x[mesh.cells[_cells_at(mesh, rows)], axis].mean(axis=1) - x[0, axis]
    if behind.min() < 0 < behind.max():
        return None
    return FlatFace(axis=axis, position=float(x[0, axis]), out=-1 if behind[0] > 0 else 1)


def _cells_at(mesh: Simplices, rows: np.ndarray) -> np.ndarray:
    """Return a cell for each facet."""
    near = np.flatnonzero(np.isin(mesh.cells, rows).sum(axis=1) >= mesh.dim)
    theirs = facets(mesh.cells[near]).reshape(-1, mesh.dim)
    every = keys(np.concatenate([theirs, rows]))
    _, first, place = np.unique(every, return_index=True, return_inverse=True)
    return near[first[place[len(theirs) :]] // (mesh.dim + 1)]


def _touching(faces: Mapping[str, np.ndarray]) -> Iterable[tuple[str, str]]:
    corners = {name: np.unique(rows) for name, rows in faces.items()}
    return (
        (one, other)
        for one, other in combinations(corners, 2)
        if np.intersect1d(corners[one], corners[other]).size
    )
