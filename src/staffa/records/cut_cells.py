"""Records of cells: those that cracks cut out, and those of the mesh that are too long."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class CellSection:
    """The cells of a 3-D body on the plane at a depth, as `measure.cells` finds them.

    pixel: edges of the raster (m). areas (m^2), perimeters (m, shared with other cells), sides and
    ends: of each cell. junctions: how many cracks meet as a T, a Y or an X. cracked: the part of
    the plane that has more damage than the threshold.
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

    share: part of the cracks' length in cells longer than ell/3. edge: mean edge of these (m).
    toughness: over Gc, what a crack costs in them. place: middle of the one with most damage (m).
    region: where that is, empty without a name.
    """

    share: float
    edge: float
    toughness: float
    place: tuple[float, ...]
    region: str = ""
