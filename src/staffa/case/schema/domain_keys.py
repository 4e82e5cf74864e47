"""The table [domain]: which body a case is about, as keys."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, PrivateAttr

from staffa.case.schema.field_types import CaseTable, FilePath, Length
from staffa.case.schema.json_schema import Rule
from staffa.case.schema.refine_keys import Refine, RefineKeys, multiple
from staffa.case.schema.shape_keys import ShapeKeys
from staffa.geometry import shapes
from staffa.geometry.block import UNSTRUCTURED, edge, halvings
from staffa.geometry.outline import Outline, is_axis, of_block, without_axis
from staffa.units import Quantity

# Cells along the shortest side of a body whose mesh follows the cracks, at the start.
COARSEST = 16

BLOCKS = {2: "quadrilateral", 3: "hexahedron"}


def _two_or_three(size: tuple[Quantity, ...]) -> tuple[Quantity, ...]:
    if len(size) not in (2, 3):
        raise ValueError("it needs two numbers (2-D) or three (3-D)")
    return size


class DomainKeys(CaseTable):
    """The body: a rectangle or a box with its lower corner at the origin (size), a shape, or a mesh
    (mesh) whose names are its regions, faces and cracks."""

    size: Annotated[tuple[Length, ...], Rule(_two_or_three, minItems=2, maxItems=3)] | None = Field(
        default=None,
        description="extent along x, y (2-D) or x, y, z (3-D); the last is the height",
        examples=[[5.0, 1.0]],
    )
    shape: ShapeKeys | None = Field(
        default=None,
        description="in place of size: a plate with hole, a wellbore, a disc, a cylinder, or "
        "layers, with named faces and regions (docs/how-to/geometry.md; needs Gmsh)",
        examples=[{"kind": "plate with hole", "size": [2.0, 2.0], "radius": 0.1}],
    )
    mesh: FilePath | None = Field(
        default=None,
        description="in place of size: a file of a mesh, .msh (Gmsh), .med, .unv, .inp, .vtu and "
        "others (docs/how-to/geometry.md), as seen from the folder of this file",
        examples=["rock.msh"],
    )
    unit: Length | None = Field(
        default=None,
        description="of a mesh: how long what it counts as 1 is; needed in a case with units",
        examples=["1 mm"],
    )
    h: Length | None = Field(
        default=None,
        description="cell edge; at most damage.ell/3 resolves a crack; a mesh has its own, "
        "and needs h only where it is finer there than in the mean",
        examples=[0.01],
    )
    cells: (
        Literal["quadrilateral", "triangle", "hexahedron", "tetrahedron", "unstructured"] | None
    ) = Field(
        default=None,
        description="quadrilateral or triangle in 2-D, hexahedron or tetrahedron in 3-D; "
        "triangles are four to a square, so that they favor no diagonal; unstructured: triangles "
        "or tetrahedra of mean edge h that favor no direction at all (needs Gmsh)",
        examples=["quadrilateral"],
    )
    symmetry: Literal["axis"] | None = Field(
        default=None,
        description="axis: a body of revolution, given by its section, x = r from the axis x = 0 "
        "outward and y = z along it; energies, areas and forces are then of the whole body, and "
        "only cracks that run around the axis exist (docs/how-to/geometry.md)",
        examples=["axis"],
    )
    hole: Length | None = Field(
        default=None,
        description="with symmetry and size: radius of a hole along the axis, at which x begins",
        examples=[0.1],
    )
    elements: Literal["linear", "quadratic", "reduced"] | None = Field(
        default=None,
        description="of the displacement: linear; quadratic (triangles and tetrahedra); reduced "
        "(quadrilaterals and hexahedra: the volume change in the middle of each cell alone). "
        "Default: linear, but quadratic or reduced where nu is 0.45 or more in plane strain, a "
        "body of revolution or 3-D, where linear ones are too stiff "
        "(docs/how-to/choose-a-solver.md)",
        examples=["linear"],
    )
    refine: Refine | None = Field(
        default=None,
        description="true, or a table of settings: the mesh begins coarse, and is refined down to "
        "h where cracks are and before they come (triangles and tetrahedra; "
        "docs/how-to/refinement.md)",
        examples=[{"coarsest": "8 h"}],
    )
    _file: Path | None = PrivateAttr(default=None)
    _outline: Outline | None = PrivateAttr(default=None)

    @property
    def file(self) -> Path | None:
        """Return the path of the mesh, once it was found."""
        return self._file

    def with_mesh(self, file: Path, outline: Outline) -> "DomainKeys":
        """Return the keys with the mesh found and its outline; the mesh goes by its file's name."""
        keys = self.model_copy(update={"mesh": file.name})
        keys._file, keys._outline = file, outline
        return keys

    @property
    def outline(self) -> Outline:
        """Return the body from outside; the axis of a body of revolution is no face of it."""
        return without_axis(self._section) if self.symmetry else self._section

    @property
    def axis_faces(self) -> tuple[str, ...]:
        """Return the names of what lies on the axis of a body of revolution."""
        if not self.symmetry:
            return ()
        return tuple(name for name in self._section.faces if is_axis(self._section, name))

    @property
    def _section(self) -> Outline:
        """Return the body from outside, with the axis."""
        if self._outline is not None:
            return self._outline
        h = float(self.h or 0.0)
        if self.shape is not None:
            return shapes.shape_outline(self.shape.shape(), h)
        size, cells = self._extent, self.cells or BLOCKS[len(self._extent)]
        lower = (float(self.hole or 0.0), *(0.0,) * (len(size) - 1))
        if self.halvings:  # the finest cells may be a little shorter than h
            h = edge(size, h * 2**self.halvings, cells) / 2**self.halvings
        return of_block(size, h, cells, lower)

    @property
    def _extent(self) -> tuple[float, ...]:
        """Return the extent of a block or a shape along each axis (m)."""
        if self.size is not None:
            return tuple(float(s) for s in self.size)
        assert self.shape is not None
        lower, upper = self.shape.shape().bounds()
        return tuple(b - a for a, b in zip(lower, upper, strict=True))

    @property
    def refining(self) -> RefineKeys | None:
        """Return how the mesh follows the cracks; None where it stays as it is."""
        if isinstance(self.refine, bool):
            return RefineKeys() if self.refine else None
        return self.refine

    @property
    def halvings(self) -> int:
        """Return how often cells may be halved; 0 for a mesh that stays as it is."""
        keys, h = self.refining, self.h
        if keys is None or h is None:
            return 0
        if self.mesh is not None:
            edges = self._outline.edges if self._outline else None
            return halvings(edges.mean, float(h)) if edges else 0
        return halvings(self.longest, float(h), self._extent if self.is_block else ())

    @property
    def longest(self) -> float:
        """Return the longest edge (m) with which cells of a block or a shape may begin."""
        keys = self.refining
        if keys is None or keys.coarsest is None:
            return min(self._extent) / COARSEST
        return multiple(keys.coarsest) * float(self.h or 0.0)

    @property
    def is_block(self) -> bool:
        """Return True for a rectangle or a box of `size`."""
        return self.size is not None

    @property
    def has_simplices(self) -> bool:
        """Return True for triangles or tetrahedra that lie anywhere."""
        return not self.is_block or self.cells == UNSTRUCTURED
