"""Records of the crack network of one state."""

from dataclasses import dataclass

from staffa.records.cut_cells import CellSection, Coarse


@dataclass(frozen=True, kw_only=True)
class CracksAtHeight:
    """The cracks that cross a line through a 2-D body.

    Attributes
    ----------
    height
        Depth of the line below the cooled face (m), as `measures.depths` of the case has it.
    cracks
        Number of cracks.
    spacing
        Their mean spacing (m); None if it has no meaning.
    positions
        Their positions along x (m).
    elsewhere
        Number of further cracks on the line, which start on other cooled faces.
    """

    height: float
    cracks: int
    spacing: float | None
    positions: tuple[float, ...] = ()
    elsewhere: int = 0


@dataclass(frozen=True, kw_only=True)
class Tip:
    """The tip of one crack.

    Attributes
    ----------
    position
        Place of the tip (m), shape (2,) or (3,).
    depth
        Distance from the cooled face (m).
    room
        Distance from the tip to the end of the body, away from the cooled face (m); None if that
        is more than 3 ell. 0 where the crack is parted from that of another face.
    met
        True if the crack has met one of another cooled face: it is no tip any more, but the place
        to which it had grown by the step before, or halfway between the faces.
    """

    position: tuple[float, ...]
    depth: float
    room: float | None = None
    met: bool = False


@dataclass(frozen=True, kw_only=True)
class OtherCracks:
    """Cracks that start on a cooled face from which `Tip.depth` is not measured.

    Attributes
    ----------
    face
        Name of that face.
    cracks
        Number of their tips.
    deepest
        Largest distance of a recorded tip from that face (m).
    room
        As `Tip.room`, of that tip, away from that face.
    joined
        Largest depth (m) below the face of `Tip.depth` at which a crack that starts there touches
        this face too; None without such a crack.
    """

    face: str
    cracks: int
    deepest: float
    room: float | None = None
    joined: float | None = None

    def sharp(self, reach: float) -> float:
        """Return the distance (m) of the sharp tip from its face; 0 stays 0.

        Parameters
        ----------
        reach : distance of a sharp tip from the recorded one (m).
        """
        beyond = reach if self.room is None else min(reach, self.room)
        return self.deepest + beyond if self.deepest else 0.0


@dataclass(frozen=True, kw_only=True)
class Fluid:
    """The fluid in the cracks.

    Attributes
    ----------
    pressure
        Its pressure (Pa).
    volume
        The volume on which the pressure does work (m^3; in 2-D m^2), see `Energy.crack_volume`.
    """

    pressure: float
    volume: float


@dataclass(frozen=True, kw_only=True)
class Measures:
    """The crack network of one state.

    Attributes
    ----------
    sections
        Lines across a 2-D body, from the cooled face inwards.
    tips
        The tips of the cracks, but for those that start on other cooled faces.
    front
        Depth of the deepest crack (m), 0 without one.
    length_surface
        Length of the cracks (m; in 3-D their area, m^2) by their energy: the surface energy over
        the effective Gc, which of a mesh that was read is that of each cell.
    length_geometry
        Length of the cracks (m; in 3-D their area, m^2) by their shape: half the variation of the
        damage across them.
    volume
        Volume by which the cracks are open (m^3; in 2-D m^2), see `measure.opening`.
    fluid
        The fluid in the cracks; None without one.
    cells
        Planes through a 3-D body, from the cooled face inwards.
    coarse
        Cracks in cells that are too long for them; None without any.
    others
        The cracks that start on other cooled faces, face by face.
    """

    sections: tuple[CracksAtHeight, ...]
    tips: tuple[Tip, ...]
    front: float
    length_surface: float
    length_geometry: float
    volume: float = 0.0
    fluid: Fluid | None = None
    cells: tuple[CellSection, ...] = ()
    coarse: Coarse | None = None
    others: tuple[OtherCracks, ...] = ()
