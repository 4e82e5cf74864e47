"""Facts of a body before its mesh is distributed: extent, names, and number of cells."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from itertools import combinations

import numpy as np

from staffa.geometry.block import SIDES, cells_and_vertices, edge
from staffa.geometry.edges import Edges
from staffa.geometry.places import SAME, BoxGrid, Places


@dataclass(frozen=True, kw_only=True)
class FlatFace:
    """Face that is flat across an axis.

    Attributes
    ----------
    axis : the axis, 0, 1 or 2.
    position : coordinate of the face along the axis (m).
    out : direction out of the body along the axis, +1 or -1.
    """

    axis: int
    position: float
    out: int


@dataclass(frozen=True, kw_only=True)
class Outline:
    """Outline of a body: the facts that are known before its mesh is distributed.

    Attributes
    ----------
    lower, upper : corners of the box around the body (m).
    h : edge of the cells (m), see `block.edge`.
    faces : named parts of the surface, each with its plane if it is flat across an axis.
    touching : pairs of faces that share an edge or a corner.
    regions : names of the regions.
    cracks : names of the initial cracks.
    n_cells, n_vertices : estimated numbers of cells and vertices.
    places : places at which properties are sampled.
    notes : changes that reading it from a file made.
    edges : edges of a mesh from place to place; None for a body that is meshed evenly.
    hinges : points (m) shared by parts that have no facet in common.
    sides : side of the box around the body in which each face lies, None for a face in none.
    """

    lower: tuple[float, ...]
    upper: tuple[float, ...]
    h: float
    faces: Mapping[str, FlatFace | None]
    touching: frozenset[frozenset[str]]
    regions: tuple[str, ...] = ()
    cracks: tuple[str, ...] = ()
    n_cells: int
    n_vertices: int
    places: Places = field(compare=False, repr=False)
    notes: tuple[str, ...] = ()
    edges: Edges | None = None
    hinges: tuple[tuple[float, ...], ...] = ()
    sides: Mapping[str, str | None] = field(init=False)

    def __post_init__(self) -> None:
        """Find for each face the side of the box in which all of it lies, None without one."""
        found = {name: self._side(plane) for name, plane in self.faces.items()}
        object.__setattr__(self, "sides", found)

    @property
    def dim(self) -> int:
        """Return the dimension, 2 or 3."""
        return len(self.lower)

    @property
    def size(self) -> tuple[float, ...]:
        """Return the extent of the box along each axis (m)."""
        return tuple(high - low for low, high in zip(self.lower, self.upper, strict=True))

    def axis(self, face: str) -> int | None:
        """Return the axis normal to a face, None if it is no plane across one."""
        plane = self.faces[face]
        return plane.axis if plane else None

    def across(self, face: str) -> str | None:
        """Return the face on the other end of the body, else the first flat one, else None."""
        plane = self.faces[face]
        others = {name: p for name, p in self.faces.items() if p and name != face}
        facing = [
            n for n, p in others.items() if plane and (p.axis, p.out) == (plane.axis, -plane.out)
        ]
        return next(iter([*facing, *others]), None)

    def _side(self, plane: FlatFace | None) -> str | None:
        if plane is None:
            return None
        end = (self.upper if plane.out > 0 else self.lower)[plane.axis]
        if abs(plane.position - end) > SAME * max(self.size):
            return None
        return next(n for n, side in SIDES[self.dim].items() if side == (plane.axis, plane.out))


def on_axis(r: np.ndarray, size: tuple[float, ...]) -> np.ndarray:
    """Tell which distances r (m), shape (n,), from the axis of a body of this size are none."""
    return r <= SAME * max(size)


def without_axis(body: Outline) -> Outline:
    """Return a section x >= 0 without the faces that lie on the axis x = 0: they bound nothing."""
    faces = {name: plane for name, plane in body.faces.items() if not is_axis(body, name)}
    touching = frozenset(pair for pair in body.touching if pair <= faces.keys())
    return replace(body, faces=faces, touching=touching)


def is_axis(body: Outline, face: str) -> bool:
    """Return True if a face of a section lies on the axis x = 0."""
    plane = body.faces[face]
    return plane is not None and plane.axis == 0 and plane.position <= SAME * max(body.size)


def of_block(
    size: tuple[float, ...], h: float, cells: str, lower: tuple[float, ...] | None = None
) -> Outline:
    """Return the outline of a rectangle or a box.

    Parameters
    ----------
    size : extent along each axis (m).
    h : largest edge of the cells (m).
    cells : kind of the cells.
    lower : lower corner (m), None for the origin.
    """
    n_cells, n_vertices = cells_and_vertices(size, h, cells)
    lower = lower or (0.0,) * len(size)
    upper = tuple(low + length for low, length in zip(lower, size, strict=True))
    faces = flat_sides(lower, upper)
    return Outline(
        lower=lower,
        upper=upper,
        h=edge(size, h, cells),
        faces=faces,
        touching=box_edges(len(size)),
        n_cells=n_cells,
        n_vertices=n_vertices,
        places=BoxGrid(boxes=(("", (lower, upper)),), flat=flat_faces(faces)),
    )


def flat_faces(faces: Mapping[str, FlatFace | None]) -> dict[str, tuple[int, float]]:
    """Return axis and position of the faces that are flat."""
    return {name: (plane.axis, plane.position) for name, plane in faces.items() if plane}


def flat_sides(lower: tuple[float, ...], upper: tuple[float, ...]) -> dict[str, FlatFace]:
    """Return the sides of a box by name."""
    return {
        name: FlatFace(axis=axis, position=float((upper if out > 0 else lower)[axis]), out=out)
        for name, (axis, out) in SIDES[len(lower)].items()
    }


def box_edges(dim: int) -> frozenset[frozenset[str]]:
    """Return the pairs of sides of a box that meet."""
    sides = SIDES[dim]
    return pairs((a, b) for a, b in combinations(sides, 2) if sides[a][0] != sides[b][0])


def pairs(given: Iterable[tuple[str, str]]) -> frozenset[frozenset[str]]:
    """Return pairs of names without an order."""
    return frozenset(frozenset(pair) for pair in given)
