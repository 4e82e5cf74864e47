"""Bodies of a few numbers, whose parts have names, meshed by Gmsh."""

from collections.abc import Iterable
from dataclasses import dataclass
from math import pi
from typing import Any, Protocol

import numpy as np

from staffa.errors import StaffaError
from staffa.geometry.block import simplices
from staffa.geometry.gmsh_model import generate, open_gmsh
from staffa.geometry.msh import collected
from staffa.geometry.outline import Outline, box_edges, flat_faces, flat_sides, pairs
from staffa.geometry.places import SAME, Bounds, BoxGrid
from staffa.geometry.simplices import Simplices

ROCK = "rock"  # the region of a body that has but one
FLAT = 1e-3  # in cells: Gmsh's boxes around parts are wider by 1e-7


class Shape(Protocol):
    """A body of a few numbers (m)."""

    def bounds(self) -> Bounds:
        """Return lower and upper corner of the box around it."""

    def faces(self) -> dict[str, str | None]:
        """Return the faces, each with the side of the box in which it lies; None if round."""

    def touching(self) -> frozenset[frozenset[str]]:
        """Return the pairs of faces that share an edge or a corner."""

    def boxes(self) -> tuple[tuple[str, Bounds], ...]:
        """Return the boxes that it is made of, or cut out of: region and corners of each."""

    def contains(self, x: np.ndarray, h: float) -> np.ndarray:
        """Which points of these boxes, shape (3, n), are in it, and in cells of edge h too, which
        cut round faces short."""

    def content(self) -> tuple[float, float, float]:
        """Return area, perimeter and 0; or volume, surface and length of all edges."""

    def scaled(self, factor: float) -> "Shape":
        """Return the shape enlarged by a factor."""

    def draw(self, occ: Any) -> dict[str, list[int]]:
        """Model it with Gmsh; return the tags of each region."""


def shape_outline(shape: Shape, h: float) -> Outline:
    """Return the outline of a shape that is meshed with cells of mean edge h (m)."""
    lower, upper = shape.bounds()
    sides = flat_sides(lower, upper)
    faces = {name: sides[side] if side else None for name, side in shape.faces().items()}
    content, surface, edges = shape.scaled(1 / h).content()
    n_cells, n_vertices = simplices(content, surface, edges, len(lower))
    return Outline(
        lower=lower,
        upper=upper,
        h=h,
        faces=faces,
        touching=shape.touching(),
        regions=tuple(dict.fromkeys(region for region, _ in shape.boxes())),
        n_cells=n_cells,
        n_vertices=n_vertices,
        places=BoxGrid(boxes=shape.boxes(), flat=flat_faces(faces), contains=shape.contains, h=h),
    )


def meshed(shape: Shape, h: float, where: str) -> Simplices:
    """Return the triangles or tetrahedra of a shape.

    Parameters
    ----------
    shape : the shape.
    h : mean edge of the cells (m).
    where : the key and its value, for messages.

    Raises
    ------
    InputError
        Gmsh is not there.
    StaffaError
        Gmsh made no mesh.
    """
    lower, upper = shape.bounds()
    with open_gmsh(where, "give domain.size for a rectangle or a box") as gmsh:
        try:
            _name(gmsh, shape.scaled(1 / h))  # in cells, as `unstructured` does
            generate(gmsh, len(lower))
        except Exception as error:  # Gmsh raises this very class
            raise StaffaError(
                f"{where}: Gmsh made no mesh with domain.h = {h:g} ({error}); take another domain.h"
            ) from error
        mesh = collected(gmsh, where, h)
    extent = max(high - low for low, high in zip(lower, upper, strict=True))
    for axis, ends in enumerate(zip(lower, upper, strict=True)):  # on flat sides exactly
        for end in ends:
            mesh.x[np.abs(mesh.x[:, axis] - end) <= SAME * extent, axis] = end
    return mesh


def _name(gmsh: Any, shape: Shape) -> None:
    """Draw a shape and give names to its regions and faces."""
    regions = shape.draw(gmsh.model.occ)
    gmsh.model.occ.synchronize()
    dim = len(shape.bounds()[0])
    for name, tags in regions.items():
        gmsh.model.addPhysicalGroup(dim, tags, name=name)
    bodies = [(dim, tag) for tags in regions.values() for tag in tags]
    found: dict[str, list[int]] = {name: [] for name in shape.faces()}
    for _, tag in gmsh.model.getBoundary(bodies, combined=True, oriented=False):
        found[_face(gmsh, dim - 1, tag, shape)].append(tag)
    for name, tags in found.items():
        gmsh.model.addPhysicalGroup(dim - 1, tags, name=name)


def _face(gmsh: Any, dim: int, tag: int, shape: Shape) -> str:
    """Return the face that a curve or a surface around a shape belongs to."""
    flat = gmsh.model.getType(dim, tag) in ("Line", "Plane")
    box, sides = gmsh.model.getBoundingBox(dim, tag), flat_sides(*shape.bounds())
    for name, side in shape.faces().items():
        if side is None:
            if not flat:
                return name
            continue
        plane = sides[side]
        ends = box[plane.axis], box[3 + plane.axis]
        if flat and max(abs(end - plane.position) for end in ends) < FLAT:
            return name
    raise StaffaError("a part of the surface is in no face")


def _box_sides(dim: int) -> dict[str, str | None]:
    return {name: name for name in flat_sides((0.0,) * dim, (1.0,) * dim)}


@dataclass(frozen=True, kw_only=True)
class Bored:
    """A rectangle with a round hole, or a box with a round bore from bottom to top.

    The lower corner is at the origin. The face of the hole is `hole`, that of the bore `well`.

    Attributes
    ----------
    size : extent along each axis (m).
    radius : radius of the hole (m).
    center : center of the hole (m), two numbers.
    """

    size: tuple[float, ...]
    radius: float
    center: tuple[float, float]

    @property
    def _round(self) -> str:
        return "hole" if len(self.size) == 2 else "well"

    def bounds(self) -> Bounds:
        """See `Shape`."""
        return (0.0,) * len(self.size), self.size

    def faces(self) -> dict[str, str | None]:
        """Return the sides of a block, and the hole."""
        return {**_box_sides(len(self.size)), self._round: None}

    def touching(self) -> frozenset[frozenset[str]]:
        """Return the pairs of faces; a bore ends at bottom and top."""
        dim = len(self.size)
        ends = ["bottom", "top"] if dim == 3 else []
        return box_edges(dim) | pairs((self._round, end) for end in ends)

    def boxes(self) -> tuple[tuple[str, Bounds], ...]:
        """One."""
        return ((ROCK, self.bounds()),)

    def contains(self, x: np.ndarray, h: float) -> np.ndarray:
        """Return whether each point is outside of the hole."""
        away = np.hypot(x[0] - self.center[0], x[1] - self.center[1])
        return np.asarray(away >= (1 - SAME) * self.radius + _sagitta(h, self.radius))

    def content(self) -> tuple[float, float, float]:
        """See `Shape`."""
        a, b = self.size[:2]
        area, around = a * b - pi * self.radius**2, 2 * (a + b) + 2 * pi * self.radius
        return _prism(area, around, self.size[2], 4) if len(self.size) == 3 else (area, around, 0.0)

    def scaled(self, factor: float) -> "Bored":
        """See `Shape`."""
        x, y = _times(self.center, factor)
        return Bored(size=_times(self.size, factor), radius=factor * self.radius, center=(x, y))

    def draw(self, occ: Any) -> dict[str, list[int]]:
        """Cut the hole out of the block."""
        dim = len(self.size)
        if dim == 2:
            body = occ.addRectangle(0.0, 0.0, 0.0, *self.size)
            hole = occ.addDisk(*self.center, 0.0, self.radius, self.radius)
        else:
            body = occ.addBox(0.0, 0.0, 0.0, *self.size)
            hole = occ.addCylinder(*self.center, 0.0, 0.0, 0.0, self.size[2], self.radius)
        left, _ = occ.cut([(dim, body)], [(dim, hole)])
        return {ROCK: [tag for _, tag in left]}


@dataclass(frozen=True, kw_only=True)
class Round:
    """A disc around the origin, or a cylinder along z that stands on z = 0.

    The face of a disc is `side`; a cylinder has `bottom` and `top` too.

    Attributes
    ----------
    radius : radius (m).
    height : height of the cylinder (m), None for a disc.
    """

    radius: float
    height: float | None = None

    def bounds(self) -> Bounds:
        """See `Shape`."""
        r = self.radius
        if self.height is None:
            return (-r, -r), (r, r)
        return (-r, -r, 0.0), (r, r, self.height)

    def faces(self) -> dict[str, str | None]:
        """See `Shape`."""
        ends = {"bottom": "bottom", "top": "top"} if self.height is not None else {}
        return {"side": None, **ends}

    def touching(self) -> frozenset[frozenset[str]]:
        """Return the pairs of faces; the side ends at bottom and top."""
        return pairs(("side", end) for end in self.faces() if end != "side")

    def boxes(self) -> tuple[tuple[str, Bounds], ...]:
        """One."""
        return ((ROCK, self.bounds()),)

    def contains(self, x: np.ndarray, h: float) -> np.ndarray:
        """Return whether each point is within the radius."""
        return np.asarray(
            np.hypot(x[0], x[1]) <= (1 + SAME) * self.radius - _sagitta(h, self.radius)
        )

    def content(self) -> tuple[float, float, float]:
        """See `Shape`."""
        area, around = pi * self.radius**2, 2 * pi * self.radius
        return (area, around, 0.0) if self.height is None else _prism(area, around, self.height, 0)

    def scaled(self, factor: float) -> "Round":
        """See `Shape`."""
        height = None if self.height is None else factor * self.height
        return Round(radius=factor * self.radius, height=height)

    def draw(self, occ: Any) -> dict[str, list[int]]:
        """See `Shape`."""
        if self.height is None:
            return {ROCK: [occ.addDisk(0.0, 0.0, 0.0, self.radius, self.radius)]}
        return {ROCK: [occ.addCylinder(0.0, 0.0, 0.0, 0.0, 0.0, self.height, self.radius)]}


@dataclass(frozen=True, kw_only=True)
class Layered:
    """A rectangle or a box of horizontal layers, the lower corner at the origin.

    Attributes
    ----------
    base : extent along x, or x and y (m).
    layers : region and thickness (m) of each layer from the bottom up; a region may recur.
    """

    base: tuple[float, ...]
    layers: tuple[tuple[str, float], ...]

    @property
    def _size(self) -> tuple[float, ...]:
        return (*self.base, sum(thickness for _, thickness in self.layers))

    def bounds(self) -> Bounds:
        """See `Shape`."""
        return (0.0,) * len(self._size), self._size

    def faces(self) -> dict[str, str | None]:
        """Return the sides of a block."""
        return _box_sides(len(self._size))

    def touching(self) -> frozenset[frozenset[str]]:
        """Return the pairs of faces of a block."""
        return box_edges(len(self._size))

    def boxes(self) -> tuple[tuple[str, Bounds], ...]:
        """Return the layers, from the bottom up."""
        ends = np.cumsum([0.0, *(thickness for _, thickness in self.layers)]).tolist()
        zero = (0.0,) * len(self.base)
        return tuple(
            (name, ((*zero, low), (*self.base, high)))
            for (name, _), low, high in zip(self.layers, ends[:-1], ends[1:], strict=True)
        )

    def contains(self, x: np.ndarray, h: float) -> np.ndarray:
        """Return True for each point."""
        return np.ones(x.shape[1], dtype=bool)

    def content(self) -> tuple[float, float, float]:
        """See `Shape`."""
        if len(self.base) == 1:
            width, height = self._size
            return width * height, 2 * (width + height), 0.0
        a, b, height = self._size
        return _prism(a * b, 2 * (a + b), height, 4)

    def scaled(self, factor: float) -> "Layered":
        """See `Shape`."""
        layers = tuple((name, factor * thickness) for name, thickness in self.layers)
        return Layered(base=_times(self.base, factor), layers=layers)

    def draw(self, occ: Any) -> dict[str, list[int]]:
        """Draw a block for each layer; where two meet they share a face."""
        dim, below, drawn = len(self._size), 0.0, []
        for _, thickness in self.layers:
            if dim == 2:
                tag = occ.addRectangle(0.0, below, 0.0, self.base[0], thickness)
            else:
                tag = occ.addBox(0.0, 0.0, below, *self.base, thickness)
            drawn.append((dim, tag))
            below += thickness
        pieces = occ.fragment(drawn[:1], drawn[1:])[1] if len(drawn) > 1 else [drawn]
        found: dict[str, list[int]] = {name: [] for name, _ in self.layers}
        for (name, _), piece in zip(self.layers, pieces, strict=True):
            found[name] += [tag for _, tag in piece]
        return found


def _sagitta(h: float, radius: float) -> float:
    """Return the distance of a chord's middle from its circle (m), with room for longer edges."""
    return min(h**2 / (2 * radius), radius / 4)


def _times(numbers: Iterable[float], factor: float) -> tuple[float, ...]:
    """Rounded, so that 30 um and 0.03 mm give the same mesh."""
    return tuple(round(factor * number, 9) for number in numbers)


def _prism(area: float, around: float, height: float, corners: int) -> tuple[float, float, float]:
    """Return volume, surface and edges of what stands upright on an area."""
    return area * height, 2 * area + around * height, 2 * around + corners * height
