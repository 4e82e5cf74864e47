"""What is known of a block before there is a mesh: its sides, and how many cells it has."""

from math import ceil, prod

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
    """The axis normal to a side, 0 for x."""
    return SIDES[dim][face][0]


def face_position(face: str, size: tuple[float, ...]) -> float:
    """Coordinate of a side along its axis (m)."""
    axis, end = SIDES[len(size)][face]
    return float(size[axis]) if end > 0 else 0.0


def opposite(face: str, dim: int) -> str:
    """The side across the body."""
    axis, end = SIDES[dim][face]
    return next(name for name, side in SIDES[dim].items() if side == (axis, -end))


def divisions(size: tuple[float, ...], h: float) -> tuple[int, ...]:
    """Cells along each axis such that none is longer than h (up to round-off)."""
    return tuple(max(1, ceil(length / h - 1e-9)) for length in size)


def edge(size: tuple[float, ...], h: float) -> float:
    """The longest cell edge along an axis of the block meshed with at most h."""
    counts = divisions(size, h)
    return max(length / count for length, count in zip(size, counts, strict=True))


def cells_and_vertices(size: tuple[float, ...], h: float, cells: str) -> tuple[int, int]:
    """Number of cells and vertices of the block; triangles are four to a square, tetrahedra six
    to a cube."""
    counts = divisions(size, h)
    blocks, corners = prod(counts), prod(n + 1 for n in counts)
    per_block = {"quadrilateral": 1, "triangle": 4, "hexahedron": 1, "tetrahedron": 6}[cells]
    return per_block * blocks, corners + (blocks if cells == "triangle" else 0)
