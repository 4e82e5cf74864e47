"""Records of the cracks that water flows in, as the flow of a step met them."""

from dataclasses import dataclass, field


@dataclass(frozen=True, kw_only=True)
class SideOpening:
    """Opening of a fracture along a side of the body.

    Attributes
    ----------
    narrowest
        Smallest opening along the side, before its bounds act (m).
    widest
        Largest opening along the side, likewise (m).
    at_smallest
        Share of the side on which the lower bound acts.
    at_largest
        Share of the side on which the upper bound acts.
    """

    narrowest: float
    widest: float
    at_smallest: float = 0.0
    at_largest: float = 0.0


@dataclass(frozen=True, kw_only=True)
class CrackFlow:
    """Cracks of the rock in the reservoir's cells; in 2-D of the whole thickness of the layer.

    Attributes
    ----------
    area
        Area of cracks (m^2).
    volume
        Volume of cracks that are open (m^3).
    opened
        Volume by which fractures along sides have opened, what lies in the cells of it (m^3).
    widest
        Largest opening of a cell, before its bounds act (m).
    at_smallest
        Share of the area of cracks on which the lower bound acts.
    at_largest
        Share of the area of cracks on which the upper bound acts.
    permeability
        Largest permeability of a cell with cracks (m^2).
    spacing
        Distance of half of the area of cracks to the next crack, across it (m), at most five times
        the spread; None without cracks.
    sides
        Opening of fractures along sides, by the side.
    """

    area: float
    volume: float
    opened: float = 0.0
    widest: float = 0.0
    at_smallest: float = 0.0
    at_largest: float = 0.0
    permeability: float = 0.0
    spacing: float | None = None
    sides: dict[str, SideOpening] = field(default_factory=dict)
