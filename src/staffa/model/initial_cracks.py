"""Vertices that break with an initial crack: the corners of the cells that it cuts."""

from dataclasses import dataclass
from itertools import combinations

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
from dolfinx import fem

from staffa.geometry.places import SAME
from staffa.model.fields import corners, vertices


@dataclass(frozen=True, kw_only=True)
class FlatCrack:
    """Flat round crack: a disc in 3-D, a segment in 2-D.

    Attributes
    ----------
    center : its center (m), three numbers.
    normal : unit vector across it, three numbers.
    radius : distance to its rim, half the length of a segment (m); may be infinite.
    """

    center: tuple[float, float, float]
    normal: tuple[float, float, float]
    radius: float


def broken(space: fem.FunctionSpace, crack: FlatCrack, *, h: float) -> np.ndarray:
    """Mark the corners of the cells that a crack cuts, ghosts included. Collective.

    These cells are a connected layer between the vertices on its two sides, so that no cell is left
    to hold them together. A vertex on the crack counts as below it, so that one layer breaks if the
    crack lies on vertices. A crack shorter than a cell counts as h long.

    Parameters
    ----------
    space : linear scalars.
    crack : the crack.
    h : mesh size (m).
    """
    x, cells = vertices(space), _own_cells(space)
    center = np.array(crack.center)
    across = (x - center) @ np.array(crack.normal)
    above = across > SAME * h
    astride = np.flatnonzero(above[cells].any(axis=1) & ~above[cells].all(axis=1))
    rim = max(crack.radius, h / 2) * (1 + SAME)
    cut = _nearest(x, cells[astride], across, above, center) <= rim
    return corners(space, astride[cut])


def _own_cells(space: fem.FunctionSpace) -> np.ndarray:
    topology = space.mesh.topology
    return np.asarray(space.dofmap.list[: topology.index_map(topology.dim).size_local])


def _nearest(
    x: np.ndarray, cells: np.ndarray, across: np.ndarray, above: np.ndarray, center: np.ndarray
) -> np.ndarray:
    """Return the distance from the crack's center to each cell's cut by the crack's plane, (n,).

    The cut is spanned by the points where edges cross the plane. The distance is to its boundary
    and diagonals: a center inside a cut is a fraction of a cell away from it.
    """
    ends = cells[:, list(combinations(range(cells.shape[1]), 2))]
    i, j = ends[..., 0], ends[..., 1]
    crosses = above[i] != above[j]
    share = np.divide(across[i], across[i] - across[j], where=crosses, out=np.zeros(i.shape))
    points = (1 - share)[..., None] * x[i] + share[..., None] * x[j] - center
    points[~crosses] = np.inf
    found = np.full(len(cells), np.inf)
    for a, b in combinations(range(points.shape[1]), 2):
        both = crosses[:, a] & crosses[:, b]
        start, way = points[both, a], points[both, b] - points[both, a]
        square = np.maximum((way**2).sum(axis=1), np.finfo(float).tiny)
        along = np.clip(-(start * way).sum(axis=1) / square, 0.0, 1.0)
        distance = np.linalg.norm(start + along[:, None] * way, axis=1)
        found[both] = np.minimum(found[both], distance)
    return found
