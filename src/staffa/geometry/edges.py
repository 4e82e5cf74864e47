"""Lengths of the edges of a mesh from place to place: at faces, along cracks, in regions."""

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np

# Of a face or a crack so much has edges shorter than those told, of a region so much longer ones:
# what is beyond is scatter, of which a mesh of even edges has +-20 %.
MOST = 0.9


@dataclass(frozen=True, kw_only=True)
class Edges:
    """Lengths (m) of the edges of a mesh.

    Attributes
    ----------
    mean : mean over all edges.
    finest : mean edge of the cell whose mean is least.
    faces : for each face, the edge that nine tenths of it do not exceed.
    cracks : for each crack, the edge that nine tenths of it do not exceed.
    regions : for each region, the edge in its finest tenth.
    """

    mean: float
    finest: float
    faces: Mapping[str, float]
    cracks: Mapping[str, float]
    regions: Mapping[str, float]


Rows = Mapping[str, np.ndarray]


def edges(
    x: np.ndarray,
    cells: np.ndarray,
    ends: np.ndarray,
    *,
    faces: Rows,
    cracks: Rows,
    regions: Rows,
) -> Edges:
    """Measure the edges of a mesh of simplices.

    Parameters
    ----------
    x : points (m), shape (n, dim).
    cells : their corners, shape (m, dim + 1).
    ends : those of each edge once, shape (k, 2).
    faces, cracks : corners of the facets of each, by name.
    regions : numbers of the cells of each, by name.
    """
    length = np.linalg.norm(x[ends[:, 0]] - x[ends[:, 1]], axis=1)
    at = _mean_at(ends, length, len(x))
    of_cell, size = cell_edges(x[cells]), _content(x[cells])

    def along(rows: np.ndarray) -> float:
        return _quantile(at[rows].mean(axis=1), _content(x[rows]), MOST)

    return Edges(
        mean=float(length.mean()),
        finest=float(of_cell.min()),
        faces={name: along(rows) for name, rows in faces.items()},
        cracks={name: along(rows) for name, rows in cracks.items()},
        regions={n: _quantile(of_cell[c], size[c], 1 - MOST) for n, c in regions.items()},
    )


def cell_edges(corners: np.ndarray) -> np.ndarray:
    """Return the mean edge of each simplex (m), shape (m,); corners: shape (m, dim + 1, dim)."""
    one, other = np.array(list(combinations(range(corners.shape[1]), 2))).T
    return np.asarray(np.linalg.norm(corners[:, one] - corners[:, other], axis=2).mean(axis=1))


def _mean_at(ends: np.ndarray, length: np.ndarray, n: int) -> np.ndarray:
    """Return the mean length of the edges that meet at each point."""
    total = sum(np.bincount(ends[:, k], length, n) for k in (0, 1))
    return np.asarray(total / sum(np.bincount(ends[:, k], minlength=n) for k in (0, 1)))


def _content(corners: np.ndarray) -> np.ndarray:
    """Return a number in proportion to the length, area or volume of each simplex."""
    legs = corners[:, 1:] - corners[:, :1]
    return np.asarray(np.sqrt(np.abs(np.linalg.det(legs @ legs.transpose(0, 2, 1)))))


def _quantile(values: np.ndarray, weight: np.ndarray, share: float) -> float:
    """Return the value that so much of the weight does not exceed."""
    order = np.argsort(values)
    below = np.cumsum(weight[order])
    place = np.searchsorted(below, share * below[-1])
    return float(values[order][min(place, len(values) - 1)])
