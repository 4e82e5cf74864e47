"""Records of cells: those that cracks cut out, and those of the mesh that are too long."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class CellSection:
    """The cells of a 3-D body on the plane at a depth, as `measure.cells` finds them.

    Attributes
    ----------
    depth
        Depth of the plane below the cooled face (m).
    pixel
        Edges of the raster (m), shape (2,).
    areas
        Area of each cell (m^2).
    perimeters
        Perimeter of each cell (m), shared with other cells.
    sides
        Number of sides of each cell.
    ends
        Number of axes along which each cell touches an end of the body: 2 in a corner, 0 inside.
    junctions
        Number of places where cracks meet as a "T", a "Y" or an "X".
    cracked
        Part of the plane that has more damage than the threshold.
    """

    depth: float
    pixel: tuple[float, float]
    areas: tuple[float, ...]
    perimeters: tuple[float, ...]
    sides: tuple[int, ...]
    ends: tuple[int, ...]
    junctions: dict[str, int]
    cracked: float

    @property
    def number(self) -> int:
        """Number of cells."""
        return len(self.areas)


@dataclass(frozen=True, kw_only=True)
class Coarse:
    """Cracks in cells that are too long for them, of a mesh whose edges differ.

    Attributes
    ----------
    share
        Part of the length of the cracks that runs through cells longer than ell/3.
    edge
        Mean edge of these cells (m).
    toughness
        Energy of a crack in them, over Gc.
    place
        Middle of the one with most damage (m), shape (2,) or (3,).
    region
        Region of that place; empty without a name.
    """

    share: float
    edge: float
    toughness: float
    place: tuple[float, ...]
    region: str = ""
