"""Cartesian grid of a reservoir, and the way from its cells to points of the rock."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from staffa.errors import InputError

# Axis of the outward normal of a side, and -1 for its lower end or 1 for its upper one.
Side = tuple[int, int]
NEAR, FAR = 1.15, 1.25  # growth from cell to cell: in the body, and beyond it
FIRST = 1.2  # first cell beside a row of fracture, over the height of the row


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Cartesian cells, the first axis fastest. In 2-D the last axis has one cell of the thickness.

    Attributes
    ----------
    edges : coordinates of the faces of cells along x, y and z (m), each increasing.
    dim : dimension of the rock, 2 or 3.
    rows : sides beyond which the last row of cells holds half a fracture.
    """

    edges: tuple[np.ndarray, np.ndarray, np.ndarray]
    dim: int
    rows: tuple[Side, ...] = ()

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of cells along each axis."""
        x, y, z = (len(edges) - 1 for edges in self.edges)
        return x, y, z

    @property
    def size(self) -> int:
        """Number of cells."""
        return int(np.prod(self.shape))

    @cached_property
    def sizes(self) -> np.ndarray:
        """Edge lengths of each cell (m), shape (size, 3)."""
        return _product([np.diff(edges) for edges in self.edges])

    @cached_property
    def centers(self) -> np.ndarray:
        """Center of each cell (m), shape (size, 3)."""
        return _product([_middles(edges) for edges in self.edges])

    @cached_property
    def nodes(self) -> np.ndarray:
        """Point of each cell at which its temperature and pressure hold (m), shape (size, 3).

        It is the center, but in a row of a fracture the point on the side of the body: the height
        of the row is no length of the rock, and the water in it touches the wall.
        """
        return _product(self._axes)

    @cached_property
    def volumes(self) -> np.ndarray:
        """Volume of each cell (m^3), shape (size,)."""
        return np.asarray(self.sizes.prod(axis=1))

    def row(self, side: Side) -> np.ndarray:
        """Return the indices of the cells of the row beyond a side, shape (n,)."""
        axis, end = side
        places = np.unravel_index(np.arange(self.size), self.shape, order="F")[axis]
        return np.flatnonzero(places == (0 if end < 0 else self.shape[axis] - 1))

    def cell_at(self, point: Sequence[float]) -> int:
        """Return the index of the cell that holds a point; on a side with a fracture, of its row.

        Parameters
        ----------
        point : coordinates (m) in as many dimensions as the rock has.

        Raises
        ------
        InputError
            It lies outside all cells.
        """
        places = [0, 0, 0]
        for axis, x in enumerate(tuple(point)[: self.dim]):
            edges = self.edges[axis]
            if not edges[0] <= x <= edges[-1]:
                said = f"({', '.join(f'{c:g}' for c in point)}) lies outside the reservoir"
                end = f"which goes from {edges[0]:g} m to {edges[-1]:g} m along {'xyz'[axis]}"
                raise InputError(f"{said}, {end}.")
            # A point on a face belongs to the upper cell, and on the last one to the last cell.
            place = min(int(np.searchsorted(edges, x, side="right")) - 1, len(edges) - 2)
            near = 1e-9 * (edges[-1] - edges[0])
            if (axis, -1) in self.rows and abs(x - edges[1]) <= near:
                place = 0
            if (axis, 1) in self.rows and abs(x - edges[-2]) <= near:
                place = len(edges) - 2
            places[axis] = place
        return int(np.ravel_multi_index(places, self.shape, order="F"))

    def cells_around(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the cell of each point, shape (n_points,), and True for those within all cells.

        The cell of a point outside is one of those at the end.

        Parameters
        ----------
        points : coordinates (m), shape (n_points, dim or more).
        """
        places = np.zeros((3, len(points)), dtype=np.int64)
        inside = np.ones(len(points), dtype=bool)
        for axis in range(self.dim):
            edges, x = self.edges[axis], points[:, axis]
            inside &= (x >= edges[0]) & (x <= edges[-1])
            place = np.searchsorted(edges, x, side="right") - 1
            places[axis] = np.clip(place, 0, len(edges) - 2)
        x, y, z = places
        return np.asarray(np.ravel_multi_index((x, y, z), self.shape, order="F")), inside

    def weights(self, points: np.ndarray) -> "scipy.sparse.csr_matrix":
        """Return the matrix of interpolation from values in cells to values at points.

        Linear along each axis between `nodes`, and constant beyond the outermost ones.

        Parameters
        ----------
        points : coordinates (m), shape (n_points, dim or more).

        Returns
        -------
        csr_matrix
            Shape (n_points, size); each row adds up to 1.
        """
        n = len(points)
        cells, weights = np.zeros((n, 1), dtype=np.int64), np.ones((n, 1))
        stride = 1
        for axis in range(self.dim):
            lower, part = _between(self._axes[axis], points[:, axis])
            upper = np.minimum(lower + 1, self.shape[axis] - 1)
            cells = np.hstack([cells + stride * lower[:, None], cells + stride * upper[:, None]])
            weights = np.hstack([weights * (1 - part)[:, None], weights * part[:, None]])
            stride *= self.shape[axis]
        rows = np.repeat(np.arange(n), cells.shape[1])
        entries = (weights.ravel(), (rows, cells.ravel()))
        return scipy.sparse.csr_matrix(entries, shape=(n, self.size))

    @cached_property
    def _axes(self) -> list[np.ndarray]:
        """Coordinates of the nodes along each axis (m)."""
        axes = [_middles(edges) for edges in self.edges]
        for axis, end in self.rows:
            axes[axis][0 if end < 0 else -1] = self.edges[axis][1 if end < 0 else -2]
        return axes


def grid_around(
    lower: Sequence[float],
    upper: Sequence[float],
    h: float,
    *,
    beyond: Mapping[Side, float] | None = None,
    fractures: Mapping[Side, float] | None = None,
    thickness: float = 1.0,
) -> Grid:
    """Return the grid of a reservoir in and around a body.

    Cells are `h` long in the body. Beside a fracture they start with the size of its row and grow
    by 15 % from cell to cell; beyond the body they grow by 25 %.

    Parameters
    ----------
    lower, upper : ends of the body (m), each of as many numbers as it has dimensions.
    h : size of cells in the body (m).
    beyond : length (m) by which the reservoir goes on, by side.
    fractures : height (m) of the cells of a whole fracture, by the side along which it lies.
    thickness : extent of a 2-D body across its plane (m).

    Raises
    ------
    InputError
        The reservoir goes on beyond a side along which a fracture lies.
    """
    beyond, fractures = dict(beyond or {}), dict(fractures or {})
    dim = len(lower)
    for axis, end in beyond.keys() & fractures.keys():
        side = f"the {'lower' if end < 0 else 'upper'} end of {'xyz'[axis]}"
        raise InputError(
            f"The reservoir cannot go on beyond {side}, along which a fracture lies: half of the "
            "fracture, by symmetry. Take away `beyond` there, or the fracture."
        )
    edges = [
        _edges_of_axis(
            (lower[axis], upper[axis]), h,
            beyond=[beyond.get((axis, end), 0.0) for end in (-1, 1)],
            rows=[fractures.get((axis, end), 0.0) / 2 for end in (-1, 1)],
        )
        for axis in range(dim)
    ]  # fmt: skip
    if dim == 2:
        edges.append(np.array([0.0, thickness]))
    x, y, z = edges
    return Grid(edges=(x, y, z), dim=dim, rows=tuple(sorted(fractures)))


def _edges_of_axis(
    ends: tuple[float, float], h: float, *, beyond: Sequence[float], rows: Sequence[float]
) -> np.ndarray:
    """Return the faces along an axis: rows of fractures or growing cells beyond the ends."""
    low, high = ends
    firsts = [min(h, FIRST * row) if row else h for row in rows]
    inside = low + _steps(high - low, h, firsts, NEAR)
    sizes = np.diff(inside)
    below = _steps(beyond[0], np.inf, [FAR * sizes[0], np.inf], FAR)
    above = _steps(beyond[1], np.inf, [FAR * sizes[-1], np.inf], FAR)
    return np.concatenate(
        [
            [low - rows[0]] if rows[0] else low - below[:0:-1],
            inside[:-1],
            [high],
            [high + rows[1]] if rows[1] else high + above[1:],
        ]
    )


def _steps(length: float, h: float, firsts: Sequence[float], growth: float) -> np.ndarray:
    """Return coordinates from 0 to `length` whose distances grow from both ends, up to `h`.

    Parameters
    ----------
    length : the last coordinate (m).
    h : largest distance (m); infinite for none.
    firsts : distances at both ends (m).
    growth : ratio of neighboring distances.
    """
    sizes: list[float] = []
    reached = 0.0
    while reached < length * (1 - 1e-9):
        left = length - reached
        # The sums of geometric sequences from the lower end, and to the upper one.
        from_lower = firsts[0] + (growth - 1) * reached
        to_upper = (firsts[1] + (growth - 1) * left) / growth
        sizes.append(min(h, from_lower, max(to_upper, firsts[1])))
        reached += sizes[-1]
    if np.isinf(h) and len(sizes) > 1 and reached - length > sizes[-1] / 2:
        reached -= sizes.pop()
    places = np.concatenate([[0.0], np.cumsum(sizes)])
    return places * (length / reached) if sizes else places


def _between(nodes: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the node below each place, and the part of the way to the next one, 0 to 1."""
    if len(nodes) == 1:
        return np.zeros(len(x), dtype=np.int64), np.zeros(len(x))
    lower = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, len(nodes) - 2)
    part = (x - nodes[lower]) / (nodes[lower + 1] - nodes[lower])
    return lower, np.clip(part, 0.0, 1.0)


def _middles(edges: np.ndarray) -> np.ndarray:
    return np.asarray((edges[1:] + edges[:-1]) / 2)


def _product(axes: Iterable[np.ndarray]) -> np.ndarray:
    """Return one row for each cell, the first axis fastest."""
    return np.stack([a.ravel(order="F") for a in np.meshgrid(*axes, indexing="ij")], axis=1)
