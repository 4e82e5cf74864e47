"""What a run is, for those who read it later: written once, before its first step."""

from dataclasses import dataclass, field
from functools import cached_property

from staffa.display_units import Magnitudes, Shown, Unit, shown
from staffa.records.step import Measures


@dataclass(frozen=True, kw_only=True)
class Probe:
    """Points of the body at which fields are read off: shape (n, 2 or 3), m."""

    name: str
    points: tuple[tuple[float, ...], ...]


@dataclass(frozen=True, kw_only=True)
class Own:
    """A law, a split or a load that a script gave in place of the case's, to know it again by.

    identity: its name and its parameters, or the text that it has as `identity`. values: what it
    gives where it is tried; at: at these times (s), if it is a load.
    """

    identity: str
    values: tuple[float, ...] = ()
    at: tuple[float, ...] = ()


@dataclass(frozen=True, kw_only=True)
class QuantityRecord:
    """A quantity of a script's own, as a run records it at each step.

    Attributes
    ----------
    name : name of the quantity.
    unit : unit of its numbers; "" for none.
    numbers : how many numbers it gives at a step.
    """

    name: str
    unit: str
    numbers: int = 1

    @property
    def shown(self) -> Unit:
        """Its unit, in which its numbers are recorded and shown."""
        return Unit(name="" if self.unit == "1" else self.unit)

    @property
    def columns(self) -> tuple[str, ...]:
        """A name for each of its numbers."""
        if self.numbers == 1:
            return (self.name,)
        return tuple(f"{self.name}_{number}" for number in range(1, self.numbers + 1))


@dataclass(frozen=True, kw_only=True)
class Manifest:
    """What a run is: written once, before its first step.

    title, law, split: the case's own, or the law and the split of a script; split_reason: why that
    is the split, in words. scaled: True if lengths
    and times are scaled, False if in m and s.
    size: extent along each axis, lower: where the body begins (None: at the origin); face: name of
    the cooled face, if it is a flat side of the body; side: which of a box's that is, if it has
    another name; h: cell edge; L: depth of the body below the face. toughness_factor: measured
    discrete toughness over Gc. tip_reach: how far sharp tips lie beyond the recorded ones (see
    `measure.tip`), None if not known. times, taus: all that the run will visit, or with adaptive
    steps those that it will not miss; requested: whether each is an output time. threshold: damage
    above which a point counts as cracked. probes: where fields are read off at each step. scales:
    the derived numbers that `staffa check` prints, by name; none of a load that a script gave.
    identity: SHA-256 of what must stay of the case, see `cases.attached`. own: what a script gave
    in place of the case's, by the names of the arguments: "damage", "split", "temperature"; None
    if that was not recorded. profile: `temperature.profile` of the case, empty if not known.
    units: in which results are shown, by the names of `display_units.Shown`; empty if scaled.
    axial: the body is one of revolution, and its numbers are of all of it.
    reference: the temperature (K) from which the field T counts, if that is one and is known.
    elements: of the displacement, see `physics.locking`. quantities: of a script, recorded at
    each step.
    """

    version: str
    commit: str | None
    created: str
    ranks: int
    title: str
    law: str
    scaled: bool
    size: tuple[float, ...]
    face: str | None
    h: float
    ell: float
    L: float
    cells: int
    unknowns: int
    mesh: str
    toughness_factor: float
    times: tuple[float, ...]
    taus: tuple[float | None, ...]
    requested: tuple[bool, ...]
    scales: dict[str, float | None]
    versions: dict[str, str]
    petsc_options: dict[str, str]
    tip_reach: float | None = None
    adaptive: bool = False
    lower: tuple[float, ...] | None = None
    side: str | None = None
    probes: tuple[Probe, ...] = ()
    threshold: float = 0.8
    split: str = "none"
    split_reason: str = ""
    identity: str | None = None
    own: dict[str, Own] | None = None
    profile: str = ""
    units: dict[str, Unit] = field(default_factory=dict)
    reference: float | None = None
    axial: bool = False
    elements: str = "linear"
    quantities: tuple[QuantityRecord, ...] = ()
    format: int = 1

    @cached_property
    def shown(self) -> Shown:
        """The units in which results are shown; chosen by size for a run that tells none."""
        if self.scaled or self.units:
            return Shown(**self.units)
        last = self.times[-1] if self.times else 1.0
        sizes = Magnitudes(extent=max(self.size), depth=self.L, last=last)
        return shown(2 if self.plane else 3, sizes)

    @property
    def flat(self) -> bool:
        """True if the fields are those of a plane: of a 2-D body, or of a section."""
        return len(self.size) == 2

    @property
    def plane(self) -> bool:
        """True for a 2-D body, whose energies, volumes and forces are per thickness."""
        return self.flat and not self.axial

    @property
    def cools(self) -> bool:
        """True if the face that depths are measured from is cooled; it may be heated."""
        return bool(self.scales.get("dT"))

    @property
    def surface(self) -> str:
        """The name of that face."""
        return "cooled face" if self.cools else f"face '{self.face}'"

    @property
    def corner(self) -> tuple[float, ...]:
        """Lower corner of the box around the body."""
        return self.lower or (0.0,) * len(self.size)

    @property
    def cooled_side(self) -> str | None:
        """The side of a box that the cooled face is."""
        return self.side or self.face

    @property
    def own_load(self) -> Own | None:
        """The load that a script gave, if it did."""
        return (self.own or {}).get("temperature")

    def sharp(self, depth: float, room: float | None = None) -> float:
        """Depth (m) of the sharp tip of a crack whose recorded tip is so deep: at most that of the
        body, which goes on by `room` beyond it; 0 stays 0."""
        reach = self.tip_reach or 0.0
        beyond = reach if room is None else min(reach, room)
        return min(depth + beyond, self.L) if depth else 0.0

    def deepest(self, measures: Measures) -> float:
        """Depth (m) of the sharp tip of the deepest crack, 0 without one."""
        found = (self.sharp(tip.depth, tip.room) for tip in measures.tips)
        return max(found, default=self.sharp(measures.front))
