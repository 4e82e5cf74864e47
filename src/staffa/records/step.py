"""What a run hands from floor to floor and keeps on disk: frozen results, and their JSON form."""

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any, Self

from staffa.records.cut_cells import CellSection as CellSection
from staffa.records.cut_cells import Coarse as Coarse
from staffa.records.json_form import made as made
from staffa.records.tip_release import Release

# What is left of a large number taken from another, over it, is no size to judge by.
ROUND_OFF = 1e-6
# An energy that is the difference of terms of this size is known to so much of them, at best, over
# the least that an audit allows: a body that moves or expands freely stores none, but for this.
CANCELED = 1e-9


@dataclass(frozen=True, kw_only=True)
class Energies:
    """Energies of a state, in 2-D per unit thickness (J/m, or scaled), else whole (J).

    loads: minus the work of external loads; friction: work of the faces of cracks. With forces,
    elastic and loads count from the state of rest before the first step; at_rest: both, unsigned.
    """

    elastic: float
    surface: float
    loads: float = 0.0
    friction: float = 0.0
    at_rest: float = 0.0

    @property
    def total(self) -> float:
        """All of them."""
        return self.elastic + self.surface + self.loads + self.friction

    @property
    def scale(self) -> float:
        """What a difference of energies is small or large against; the total may be near zero."""
        return abs(self.elastic) + abs(self.surface) + self.work + abs(self.friction)

    @property
    def work(self) -> float:
        """That of the loads, and what round-off in a state of rest is taken for."""
        return abs(self.loads) + ROUND_OFF * self.at_rest


@dataclass(frozen=True, kw_only=True)
class Stop:
    """When a state counts as a minimum; dimensionless.

    change: largest change of the damage in the last sweep, which starts from a displacement in
    equilibrium. residual: largest unbalanced force on the damage over Gc/(4 c_w ell), at a
    displacement in equilibrium again. sweeps: give up after these.
    """

    change: float = 1e-4
    residual: float = 1e-1
    sweeps: int = 5000


@dataclass(frozen=True, kw_only=True)
class Effort:
    """What a minimization did besides sweeps, and where it had to fall back.

    moves: Newton's proposals that were taken. guesses: first guesses of a coarser mesh that were
    taken, after so many coarse_sweeps there. refused: proposals of either that did not lower the
    energy, so that a plain sweep followed. iterations: of the linear solver within Newton's moves.
    fallbacks: times that the second damage solver took over. plain: times that all was begun again
    without proposals. halvings: times that a time step was cut in two. direct: times that a
    factorization took over from the iterative solver of the displacement.
    """

    moves: int = 0
    refused: int = 0
    iterations: int = 0
    fallbacks: int = 0
    plain: int = 0
    halvings: int = 0
    guesses: int = 0
    coarse_sweeps: int = 0
    direct: int = 0

    def __add__(self, other: "Effort") -> "Effort":
        """Both together."""
        return Effort(**{k: v + getattr(other, k) for k, v in asdict(self).items()})


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """The end of a minimization: its reason is the sentence that a user reads.

    before: the total energy of the state that it began with. spread: the size of the terms that its
    energy is the difference of, see `ElasticSolver.spread`.
    """

    converged: bool
    reason: str
    sweeps: int
    change: float
    residual: float
    largest_rise: float
    energies: Energies
    before: float
    effort: Effort = Effort()
    spread: float = 0.0

    @property
    def scale(self) -> float:
        """Scale against which an error of the energy is judged; positive."""
        return max(self.energies.scale, CANCELED * self.spread, 1e-300)

    def then(self, other: "Outcome") -> "Outcome":
        """This minimization and another that went on from it."""
        return replace(
            other,
            sweeps=self.sweeps + other.sweeps,
            largest_rise=max(self.largest_rise, other.largest_rise),
            before=self.before,
            effort=self.effort + other.effort,
            spread=max(self.spread, other.spread),
        )


@dataclass(frozen=True, kw_only=True)
class Audit:
    """What was checked after a step, each figure dimensionless, and the sentences on what failed.

    largest_rise: largest rise of the total energy in a half sweep, over the total energy.
    healing: largest decrease of the damage below its irreversibility bound or the step before.
    optimality: first-order residual of the whole problem (see `minimize.alternate`), of the state
    that is kept.
    balance: error of E_i = E_(i-1) + work - released + renewed, with the work of the loads done on
    frozen cracks, over the total energy.
    work, released: the two terms of that balance, in units of energy.
    renewed: by how much new normals and pressures of faces that touch changed the energy.
    gap: difference between two energies of one state, over the total energy: at the end of the step
    before and at the start of this one, or of parts of a step; None: an older version's run.
    notes: sentences on what is not violated but may not be meant.
    """

    largest_rise: float
    healing: float
    optimality: float
    balance: float
    work: float
    released: float
    renewed: float = 0.0
    gap: float | None = None
    violations: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Section:
    """The cracks that cross one height: their number, positions along x, and mean spacing."""

    height: float
    cracks: int
    spacing: float | None
    positions: tuple[float, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Tip:
    """One crack: where it ends, and how far that is from the cooled face.

    room: how far the body goes on beyond, away from the face (m); None if that is more than 3 ell.
    """

    position: tuple[float, ...]
    depth: float
    room: float | None = None


@dataclass(frozen=True, kw_only=True)
class Fluid:
    """What presses in the cracks: its pressure (Pa), and the volume on which that does work, see
    `external.crack_volume` (m^3; in 2-D m^2)."""

    pressure: float
    volume: float


@dataclass(frozen=True, kw_only=True)
class Measures:
    """The crack network of one state.

    sections: lines in 2-D; cells: planes in 3-D, from the cooled face inwards. front: depth of the
    deepest crack, 0 without one.
    length_surface: surface energy over Gc and the discrete toughness factor, which of a mesh that
    was read is that of each cell (area in 3-D).
    length_geometry: half the variation of the damage across the cracks (area in 3-D). volume: of
    the cracks, by which they are open (see `measure.opening`; area in 2-D). fluid: in them, if any.
    coarse: cracks in cells that are too long for them, if any.
    """

    sections: tuple[Section, ...]
    tips: tuple[Tip, ...]
    front: float
    length_surface: float
    length_geometry: float
    volume: float = 0.0
    fluid: Fluid | None = None
    cells: tuple[CellSection, ...] = ()
    coarse: Coarse | None = None


@dataclass(frozen=True, kw_only=True)
class Stability:
    """Second order of the energy at a state (see `minimize.stability`), over Gc/(4 c_w ell).

    bifurcation: smallest value on the space; None where no damage may move, so that the state is
    unique. stability: smallest value on the cone; None where the one on the space is not negative,
    so that the state is stable. negative: eigenvalues below zero on the space.
    escapes: times that the state was left along a mode of negative value, and minimized again.
    failure: why it was not found out, if it was not; the step stands all the same.
    """

    bifurcation: float | None
    stability: float | None
    negative: int
    escapes: int = 0
    failure: str | None = None


@dataclass(frozen=True, kw_only=True)
class Curvature:
    """Second-order test of a step's state (see `minimize.lanczos`).

    Attributes
    ----------
    smallest : curvature of the energy along the softest direction found, over that without the
        coupling of displacement and damage; negative where the energy falls along it; None where
        the state was not tested, or no damage may move.
    iterations : of the last search.
    escapes : times that a state was left for one of lower energy.
    bifurcation : True where the curvature is negative but, within the bounds of the damage, the
        energy does not fall along the direction.
    reason : of a state that was not tested, or that was kept with a negative curvature.
    """

    smallest: float | None = None
    iterations: int = 0
    escapes: int = 0
    bifurcation: bool = False
    reason: str | None = None


@dataclass(frozen=True, kw_only=True)
class Heat:
    """Account of the heat equation in a step; heat as `Energies` in J/m or J.

    stored: heat that the body gained. entered: where from, by side, "source" and "cracks"; negative
    where it left. imbalance: of the two, over what was stored or crossed, or the body has stored
    since the start if that is more. substeps: its own steps. passes: those in which the temperature
    followed the cracks, till both agreed to gap (over the largest change of temperature). seconds:
    all of it took.
    """

    stored: float = 0.0
    entered: dict[str, float] = field(default_factory=dict)
    imbalance: float = 0.0
    substeps: int = 0
    passes: int = 0
    gap: float = 0.0
    seconds: float = field(default=0.0, compare=False)

    def then(self, other: "Heat") -> "Heat":
        """This one and the next, one after the other in time."""
        names = self.entered.keys() | other.entered.keys()

        def together(name: str) -> float:
            return self.entered.get(name, 0.0) + other.entered.get(name, 0.0)

        return Heat(
            stored=self.stored + other.stored,
            entered={name: together(name) for name in sorted(names)},
            imbalance=max(self.imbalance, other.imbalance),
            substeps=self.substeps + other.substeps,
            passes=self.passes + other.passes,
            gap=max(self.gap, other.gap),
            seconds=self.seconds + other.seconds,
        )


@dataclass(frozen=True, kw_only=True)
class Return:
    """Backtracking: a later damage gave an earlier time a lower energy, and was taken back there.

    index, time: the step that it came from. before: total energy kept at the time returned to;
    found: the energy there with the later damage, from which the minimization went on. number: of
    the returns to this time; limit: of these, None if there is none.
    """

    index: int
    time: float
    before: float
    found: float
    number: int = 1
    limit: int | None = None


@dataclass(frozen=True, kw_only=True)
class Moment:
    """Which step, and when: index, time (s), and tau, None where nothing diffuses."""

    index: int
    time: float
    tau: float | None


REJECTED = "rejected"


@dataclass(frozen=True, kw_only=True)
class Step:
    """One load state, as recorded in `steps.jsonl`.

    returned: how backtracking came to this step again, which supersedes all recorded before it that
    have its index or a later one (see `kept`); of a rejected one, how it would have.

    status: "converged", "not converged" (out of sweeps), "failed" (a solver failed; the state is
    the last one before that, without audit and measures), or "rejected" (the step was too long, and
    is taken again, or a return to it failed: it stands for no state of the run). fields: the file
    of its fields, if kept.
    reactions: the force that each held side exerts on the body (N; N/m in 2-D). probed: T (K), u
    (m), alpha at the manifest's probes in turn. hoop: see `measure.hoop`. released: at the tips,
    where fields are kept. quantities: numbers of the script's own quantities, by name.
    """

    index: int
    time: float
    tau: float | None
    energies: Energies
    sweeps: int
    status: str
    reason: str
    audit: Audit | None = None
    measures: Measures | None = None
    effort: Effort = Effort()
    seconds: float = 0.0
    fields: str | None = None
    returned: Return | None = None
    stability: Stability | None = None
    curvature: Curvature | None = None
    heat: Heat | None = None
    reactions: dict[str, tuple[float, ...]] = field(default_factory=dict)
    probed: tuple[tuple[float, ...], ...] = ()
    hoop: float | None = None
    released: tuple[Release, ...] = ()
    quantities: dict[str, tuple[float, ...]] = field(default_factory=dict)

    def to_record(self) -> dict[str, Any]:
        """The step as a dictionary that JSON can hold, the total energy written out."""
        record = asdict(self)
        record["energies"]["total"] = self.energies.total
        return record

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> Self:
        """The step that `to_record` wrote, of this version or of an earlier one."""
        # Runs of version 0.1.0 counted nothing else.
        return made(cls, {"effort": {"fallbacks": record.get("fallbacks", 0)}, **record})


def kept(steps: Iterable[Step]) -> tuple[Step, ...]:
    """The steps that were not rejected, nor superseded by backtracking, in order of time."""
    found: list[Step] = []
    for step in (step for step in steps if step.status != REJECTED):
        while found and found[-1].index >= step.index:
            found.pop()
        found.append(step)
    return tuple(found)
