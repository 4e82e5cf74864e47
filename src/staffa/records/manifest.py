"""The description of a run, for those who read it later."""

from dataclasses import dataclass, field
from functools import cached_property
from math import inf, isfinite

from staffa.display_units import Magnitudes, Shown, Unit, choose_display_units
from staffa.records.reservoir_facts import ReservoirFacts
from staffa.records.step import Measures

SAME = 1e-9  # part of the largest value by which two values of the same object may differ


@dataclass(frozen=True, kw_only=True)
class Probe:
    """Points of the body at which fields are read off at each step.

    Attributes
    ----------
    name
        Name of the probe in the case file.
    points
        The points (m), shape (n, 2 or 3).
    """

    name: str
    points: tuple[tuple[float, ...], ...]


@dataclass(frozen=True, kw_only=True)
class Own:
    """A law, a split or a load that a script gave in place of the case's, to know it again by.

    Attributes
    ----------
    identity
        Its name and its parameters, or its `identity` if it has one.
    values
        Its values where it is tried.
    at
        Times of these values (s), if it is a load.
    """

    identity: str
    values: tuple[float, ...] = ()
    at: tuple[float, ...] = ()

    def alike(self, other: "Own") -> bool:
        """Return True if the values are those of another one, but for round-off.

        Parameters
        ----------
        other : an object that was tried at the same places and times.
        """
        pairs = list(zip(self.values, other.values, strict=False))
        bound = SAME * max((abs(value) for pair in pairs for value in pair), default=0.0)
        same = len(self.values) == len(other.values)
        return same and all(abs(a - b) <= bound for a, b in pairs)


@dataclass(frozen=True, kw_only=True)
class QuantityRecord:
    """A quantity of a script's own, as a run records it at each step.

    Attributes
    ----------
    name
        Name of the quantity.
    unit
        Unit of its numbers; empty for none.
    numbers
        How many numbers it gives at a step.
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
    """The description of a run, written once before its first step.

    Attributes
    ----------
    version
        Version of staffa that ran.
    commit
        Its git commit; None if that is not known.
    created
        Date and time (UTC, ISO 8601).
    ranks
        Number of MPI ranks that started the run, or went on with it last.
    title
        Title of the case.
    law
        Name of the damage law, of the case or of a script.
    scaled
        True if lengths and times are scaled, False if they are in m and s.
    size
        Extent of the body along each axis (m).
    face
        Name of the cooled face; None if it is no flat side of the body.
    h
        Edge of the cells (m).
    ell
        Regularization length (m).
    L
        Depth of the body below the cooled face (m).
    cells
        Number of cells of the mesh.
    unknowns
        Number of unknowns of displacement and damage.
    mesh
        Identity of the mesh: the same for the same cells.
    toughness_factor
        Effective Gc over nominal Gc.
    times
        Times that the run visits (s): all, or with `adaptive` those that it does not miss.
    taus
        Dimensionless time of each; None where nothing diffuses.
    requested
        True for each of them that is an output time.
    scales
        Derived numbers that `staffa check` prints, by name; empty with a load of a script.
    versions
        Versions of the libraries, and the flags of the C compiler, by name.
    petsc_options
        Options of PETSc by name.
    tip_reach
        Distance of sharp tips beyond the recorded ones (m), see `measure.tip`; None if it is not
        known.
    adaptive
        True if the steps between the times follow the cracks and the cooling.
    lower
        Lower corner of the body (m); None for the origin.
    side
        Side of a box that the cooled face is, if the face has another name.
    probes
        Points at which fields are read off.
    threshold
        Damage above which a point counts as cracked.
    split
        Name of the split of the energy, of the case or of a script.
    split_reason
        Why that is the split, in words.
    identity
        SHA-256 of what must stay of the case, see `case.values.attached_files`.
    own
        Laws and loads that a script gave in place of the case's, by the names of the arguments:
        "damage", "split", "temperature". None if that was not recorded.
    profile
        `temperature.profile` of the case; empty if it is not known.
    units
        Units in which results are shown, by the names of `display_units.Shown`; empty if scaled.
    reference
        Temperature (K) from which the field T counts; None if it is not one number, or not known.
    axial
        True for a body of revolution; its numbers are of the whole body.
    elements
        Elements of the displacement, see `physics.locking`.
    quantities
        Quantities of a script, recorded at each step.
    refined
        True for a mesh that follows the cracks: `cells`, `unknowns`, `mesh` are of the first one.
    cooled
        Sides of a box that are cooled besides the face that depths are measured from.
    face_cools
        False if other sides are cooled, and the face that depths are measured from is not.
    reservoir
        The reservoir before the first step; None where no water circulates.
    format
        Number of the format of the run directory.
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
    refined: bool = False
    cooled: tuple[str, ...] = ()
    face_cools: bool = True
    reservoir: ReservoirFacts | None = None
    format: int = 1

    @cached_property
    def shown(self) -> Shown:
        """The units in which results are shown; chosen by size for a run that tells none."""
        if self.scaled or self.units:
            return Shown(**self.units)
        last = self.times[-1] if self.times else 1.0
        sizes = Magnitudes(extent=max(self.size), depth=self.L, last=last)
        return choose_display_units(2 if self.plane else 3, sizes)

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
        return self.face_cools and bool(self.scales.get("dT"))

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


def check_numbers(manifest: Manifest) -> None:
    """Raise a ValueError if numbers of a manifest are impossible."""
    m, dim = manifest, len(manifest.size)
    positive = (m.h, m.ell, m.L, m.toughness_factor, m.cells, m.unknowns, m.ranks, *m.size)
    if dim not in (2, 3) or len(m.corner) != dim:
        raise ValueError("size and lower: two or three numbers each")
    if not all(0 < number < inf for number in positive):
        raise ValueError("h, ell, L, toughness_factor, cells, unknowns, ranks, size: positive")
    if not m.times or not len(m.times) == len(m.taus) == len(m.requested):
        raise ValueError("times, taus, requested: lists of one length, not empty")
    if not all(map(isfinite, m.times)) or list(m.times) != sorted(m.times):
        raise ValueError("times: finite, in increasing order")
