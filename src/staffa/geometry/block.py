"""Facts of a block before there is a mesh: its sides, and its number of cells."""

from dataclasses import dataclass
from math import ceil, floor, log2, prod

import numpy as np

UNSTRUCTURED = "unstructured"

# Edges of a block that was refined, over those that were asked for, at least.
SHORTER = 5 / 6

# Axis across each side, and which end of the body it is; the last axis is the height.
SIDES = {
    2: {"left": (0, -1), "right": (0, 1), "bottom": (1, -1), "top": (1, 1)},
    3: {
        "left": (0, -1),
        "right": (0, 1),
        "front": (1, -1),
        "back": (1, 1),
        "bottom": (2, -1),
        "top": (2, 1),
    },
}


def face_axis(face: str, dim: int) -> int:
    """Return the axis normal to a side, 0 for x."""
    return SIDES[dim][face][0]


def face_position(face: str, size: tuple[float, ...]) -> float:
    """Return the coordinate of a side along its axis (m)."""
    axis, end = SIDES[len(size)][face]
    return float(size[axis]) if end > 0 else 0.0


def opposite(face: str, dim: int) -> str:
    """Return the side across the body."""
    axis, end = SIDES[dim][face]
    return next(name for name, side in SIDES[dim].items() if side == (axis, -end))


def divisions(size: tuple[float, ...], h: float) -> tuple[int, ...]:
    """Return the numbers of cells along the axes; none is longer than h (up to round-off)."""
    return tuple(max(1, ceil(length / h - 1e-9)) for length in size)


def halvings(longest: float, h: float, size: tuple[float, ...] = ()) -> int:
    """Return how often an edge can be halved until it is h long.

    Parameters
    ----------
    longest : edge that must not be exceeded at the start (m).
    h : edge in the end (m).
    size : extent of a block along each axis (m), whose cells then end at h, or up to a sixth
        shorter; empty for other bodies.
    """
    times = max(0, floor(log2(longest / h) + 1e-9))
    while times and any(
        length / count / 2**times < SHORTER * h
        for length, count in zip(size, divisions(size, 2**times * h), strict=True)
    ):
        times -= 1
    return times


@dataclass(frozen=True, kw_only=True)
class PixelGrid:
    """Pixels over a rectangle.

    Attributes
    ----------
    counts : number of pixels along both axes.
    pixel : edges of a pixel along both axes (m).
    """

    counts: tuple[int, int]
    pixel: tuple[float, float]

    @property
    def middles(self) -> np.ndarray:
        """Return the middles of the pixels from the rectangle's corner (m), shape (n_x n_y, 2)."""
        return (np.indices(self.counts).reshape(2, -1).T + 0.5) * self.pixel


def section_raster(size: tuple[float, float], h: float) -> PixelGrid:
    """Return the pixels on which the cells of a section are found; none is longer than h/2 (m)."""
    across, along = divisions(size, h / 2)
    return PixelGrid(counts=(across, along), pixel=(size[0] / across, size[1] / along))


def edge(size: tuple[float, ...], h: float, cells: str) -> float:
    """Return the longest cell edge of a block (m); of unstructured cells the mean edge, h.

    Parameters
    ----------
    size : extent along each axis (m).
    h : largest edge that is asked for (m).
    cells : kind of the cells.
    """
    if cells == UNSTRUCTURED:
        return h
    counts = divisions(size, h)
    return max(length / count for length, count in zip(size, counts, strict=True))


def cells_and_vertices(size: tuple[float, ...], h: float, cells: str) -> tuple[int, int]:
    """Return the numbers of cells and vertices of a block.

    There are four triangles to a square and six tetrahedra to a cube. The numbers of unstructured
    cells are estimates, within 10 % for a body that is four cells thick or more.

    Parameters
    ----------
    size : extent along each axis (m).
    h : largest edge that is asked for (m).
    cells : kind of the cells.
    """
    if cells == UNSTRUCTURED:
        return _about(tuple(length / h for length in size))
    counts = divisions(size, h)
    blocks, corners = prod(counts), prod(n + 1 for n in counts)
    per_block = {"quadrilateral": 1, "triangle": 4, "hexahedron": 1, "tetrahedron": 6}[cells]
    return per_block * blocks, corners + (blocks if cells == "triangle" else 0)


def broken_layer_thickness(dim: int, cells: str) -> float:
    """Return the mean thickness, in h, of the layer of cells that a crack breaks.

    Of unstructured cells as `evolution.effective_toughness` finds it, from ell = 3 h to 6 h, with
    both laws.
    """
    return {2: 1.2, 3: 1.5}[dim] if cells == UNSTRUCTURED else 1.0


def _about(size: tuple[float, ...]) -> tuple[int, int]:
    """Return the number of unstructured cells and vertices of a block, from the size in cells."""
    content = prod(size)
    surface = 2 * sum(content / length for length in size)
    return simplices(content, surface, 4 * sum(size), len(size))


def simplices(content: float, surface: float, edges: float, dim: int) -> tuple[int, int]:
    """Estimate the numbers of cells and vertices of a mesh of triangles or tetrahedra by Gmsh.

    It is fitted to meshes of 400 to 40,000 cells, of cubes and of thin bodies.

    Parameters
    ----------
    content : area (in h^2) or volume (in h^3) of the body.
    surface : perimeter (in h) or surface (in h^2) of the body.
    edges : length of the edges of a 3-D body (in h).
    dim : dimension of the body.
    """
    if dim == 2:
        n_cells = 2.63 * content
        return round(n_cells), round((n_cells + surface) / 2 + 1)  # Euler: C = 2 V - 2 - boundary
    n_cells = 8.37 * content + 2.63 * surface
    return round(n_cells), round(1.456 * content + 1.146 * surface + 1.135 * edges)
