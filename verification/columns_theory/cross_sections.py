"""Cross-sections of one cell of an even array: a strip between parallel cracks, and a hexagon.

Lengths are over the spacing p of the cracks, the distance between opposite sides of the cell.
"""

from dataclasses import dataclass
from math import sqrt

import numpy as np
from scipy.optimize import brentq
from scipy.spatial import KDTree

CLOSE = 1e-8  # of the spacing: two points nearer than this are one


@dataclass(frozen=True, kw_only=True)
class CrossSection:
    """Cell of an array, cut across, and the cells of its mesh.

    Attributes
    ----------
    points : of the mesh, shape (points, dim); the middle of the cell is the origin.
    cells : points of each interval or quadrilateral, in the order of a tensor product.
    lattice : vectors from the middle of this cell to those of neighbors, shape (dim, dim).
    perimeter : points of the mesh on the walls, in turn; shape (nodes, dim).
    node : for each point, the node of the perimeter that it follows when the front moves.
    weight : for each point, the part of that movement that it makes.
    front : length of crack front in a cell; each wall is shared by two.
    """

    points: np.ndarray
    cells: np.ndarray
    lattice: np.ndarray
    perimeter: np.ndarray
    node: np.ndarray
    weight: np.ndarray
    front: float


def graded(first: float, ratio: float, largest: float, end: float) -> np.ndarray:
    """Distances from a singular place, from 0 to `end`; their steps grow.

    Parameters
    ----------
    first : first step.
    ratio : of one step to the step before, at most; it is lowered to meet the end.
    largest : largest step.
    end : last distance.
    """

    def steps(growth: float, count: int) -> np.ndarray:
        return np.minimum(first * growth ** np.arange(count), max(first, largest))

    count = 1
    while steps(ratio, count).sum() < end - CLOSE:
        count += 1
    if count == 1:
        return np.array([0.0, end])
    fitting = brentq(lambda growth: steps(growth, count).sum() - end, 1e-3, ratio + CLOSE)
    at = np.concatenate([[0.0], np.cumsum(steps(fitting, count))])
    return at * end / at[-1]


def strip(first: float, ratio: float) -> CrossSection:
    """Cell between two parallel cracks, in two dimensions.

    Parameters
    ----------
    first : first step of the mesh beside a crack.
    ratio : of one step to the step before.
    """
    half = graded(first, ratio, 0.1, 0.5)
    x = np.concatenate([-0.5 + half, 0.5 - half[-2::-1]])
    return CrossSection(
        points=x[:, None],
        cells=np.array([[i, i + 1] for i in range(len(x) - 1)]),
        lattice=np.array([[1.0]]),
        perimeter=np.array([[-0.5], [0.5]]),
        node=(x > 0).astype(int),
        weight=np.clip((np.abs(x) - 0.2) / 0.2, 0.0, 1.0),
        front=1.0,
    )


def hexagon(first: float, ratio: float, per_side: int) -> CrossSection:
    """Cell between six cracks: rings of quadrilaterals around a core, as symmetric as the cell.

    Parameters
    ----------
    first : first step of the mesh beside a crack.
    ratio : of one step to the step before.
    per_side : cells of the mesh along a side, an even number.
    """
    corner = np.array([[np.cos(t), np.sin(t)] for t in np.arange(7) * np.pi / 3]) / sqrt(3)
    along = np.arange(per_side) / per_side
    perimeter = np.concatenate(
        [corner[s] + along[:, None] * (corner[s + 1] - corner[s]) for s in range(6)]
    )
    scales = 1 - 2 * graded(first, ratio, 0.1, 0.24)
    count = len(perimeter)
    points = np.concatenate([scale * perimeter for scale in scales])
    after = np.roll(np.arange(count), -1)
    cells = [
        [r * count + i, r * count + after[i], (r + 1) * count + i, (r + 1) * count + after[i]]
        for r in range(len(scales) - 1)
        for i in range(count)
    ]
    node = np.tile(np.arange(count), len(scales))
    weight = np.repeat(np.clip((scales - scales[-1]) / (0.8 - scales[-1]), 0.0, 1.0), count)
    middle, quads = _core(scales[-1] * corner, per_side // 2)
    points, cells = _joined(points, np.array(cells), middle, quads)
    inside = len(points) - len(node)
    return CrossSection(
        points=points,
        cells=cells,
        lattice=np.array([[sqrt(0.75), 0.5], [0.0, 1.0]]),
        perimeter=perimeter,
        node=np.concatenate([node, np.zeros(inside, dtype=int)]),
        weight=np.concatenate([weight, np.zeros(inside)]),
        front=sqrt(3),
    )


def _core(corner: np.ndarray, parts: int) -> tuple[np.ndarray, np.ndarray]:
    """Mesh of a hexagon: six triangles, each of three quadrilaterals, each cut in parts x parts."""
    points, cells = np.empty((0, 2)), np.empty((0, 4), dtype=int)
    u, v = np.meshgrid(*[np.linspace(0, 1, parts + 1)] * 2, indexing="ij")
    u, v = u.reshape(-1, 1), v.reshape(-1, 1)
    at = np.arange((parts + 1) ** 2).reshape(parts + 1, parts + 1)
    quads = np.stack([at[:-1, :-1], at[1:, :-1], at[:-1, 1:], at[1:, 1:]], axis=-1).reshape(-1, 4)
    for side in range(6):
        triangle = [np.zeros(2), corner[side], corner[side + 1]]
        middle = np.mean(triangle, axis=0)
        for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
            first, before, after = triangle[a], triangle[c], triangle[b]
            grid = (
                (1 - u) * (1 - v) * first
                + u * (1 - v) * (first + after) / 2
                + (1 - u) * v * (first + before) / 2
                + u * v * middle
            )
            points, cells = _joined(points, cells, grid, quads)
    return points, cells


def _joined(
    points: np.ndarray, cells: np.ndarray, more: np.ndarray, quads: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Add a mesh to another; points of both at one place become one."""
    number = np.arange(len(more)) + len(points)
    if len(points):
        away, there = KDTree(points).query(more)
        fresh = away > CLOSE
        number = np.where(fresh, len(points) + np.cumsum(fresh) - 1, there)
        more = more[fresh]
    return np.concatenate([points, more]), np.concatenate([cells, number[quads]])
