"""The record of one step, and what it holds besides energies and measures."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Self

from staffa.records.circulation import Circulation as Circulation
from staffa.records.crack_measures import CracksAtHeight as CracksAtHeight
from staffa.records.crack_measures import Fluid as Fluid
from staffa.records.crack_measures import Measures as Measures
from staffa.records.crack_measures import OtherCracks as OtherCracks
from staffa.records.crack_measures import Tip as Tip
from staffa.records.curvature import Curvature as Curvature
from staffa.records.curvature import Stability as Stability
from staffa.records.cut_cells import CellSection as CellSection
from staffa.records.cut_cells import Coarse as Coarse
from staffa.records.energies import Energies as Energies
from staffa.records.json_form import json_form
from staffa.records.json_form import made as made
from staffa.records.minimization import CANCELED as CANCELED
from staffa.records.minimization import Outcome as Outcome
from staffa.records.minimization import SolverStatistics as SolverStatistics
from staffa.records.minimization import Stop as Stop
from staffa.records.refined_mesh import RefinedMesh as RefinedMesh
from staffa.records.status import Status
from staffa.records.tip_release import Release


@dataclass(frozen=True, kw_only=True)
class Audit:
    """The checks of a step; each figure is dimensionless unless it has a unit.

    Attributes
    ----------
    largest_rise
        Largest rise of the total energy in half a sweep, over the total energy.
    healing
        Irreversibility violation: the largest decrease of the damage below its bound or below the
        step before.
    optimality
        First-order residual of the whole problem at the state that is kept, see
        `minimize.alternate`.
    balance
        Error of E_i = E_(i-1) + work - released + renewed, with the work of the loads done on
        frozen cracks, over the total energy.
    work
        Work of the loads in that balance (J; in 2-D J/m).
    released
        Energy that cracks released in that balance (J; in 2-D J/m).
    renewed
        Change of the energy by new normals and pressures of faces that touch (J; in 2-D J/m).
    gap
        Difference between two energies of one state, over the total energy: at the end of the step
        before and at the start of this one, or of parts of a step. None in runs of older versions.
    violations
        A sentence on each check that failed.
    notes
        Sentences on what is no violation but may not be meant.
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
class Heat:
    """Account of the heat equation in a step; heat in J, in 2-D in J/m.

    Attributes
    ----------
    stored
        Heat that the body gained.
    entered
        Heat that entered, by side, "source" and "cracks"; negative where it left.
    imbalance
        Difference of the two, over the largest of what was stored, what crossed the boundary, and
        what the body has stored since the start.
    allowed
        Largest imbalance that round-off and the tolerances of its solver explain.
    substeps
        Number of time steps of the heat equation.
    passes
        Number of staggered iterations of temperature and cracks.
    gap
        Difference to which both agree in the end, over the largest change of temperature.
    circulation
        Account of the water and of its wells; None where no water circulates.
    shadow
        Account of the same water without what cooling does to cracks: with the permeability before
        the first step. None where it is not computed.
    seconds
        Time that all of it took (s).
    """

    stored: float = 0.0
    entered: dict[str, float] = field(default_factory=dict)
    imbalance: float = 0.0
    allowed: float = 1e-8
    substeps: int = 0
    passes: int = 0
    gap: float = 0.0
    circulation: Circulation | None = None
    shadow: Circulation | None = None
    seconds: float = field(default=0.0, compare=False)

    def then(self, other: "Heat") -> "Heat":
        """Return the account of this step and of the next one."""
        names = self.entered.keys() | other.entered.keys()

        def together(name: str) -> float:
            return self.entered.get(name, 0.0) + other.entered.get(name, 0.0)

        return Heat(
            stored=self.stored + other.stored,
            entered={name: together(name) for name in sorted(names)},
            imbalance=max(self.imbalance, other.imbalance),
            allowed=max(self.allowed, other.allowed),
            substeps=self.substeps + other.substeps,
            passes=self.passes + other.passes,
            gap=max(self.gap, other.gap),
            circulation=_both(self.circulation, other.circulation),
            shadow=_both(self.shadow, other.shadow),
            seconds=self.seconds + other.seconds,
        )


def _both(one: Circulation | None, other: Circulation | None) -> Circulation | None:
    """Return the account of a step and of the next one, or the one that is given."""
    return one.then(other) if one and other else one or other


@dataclass(frozen=True, kw_only=True)
class Return:
    """Backtracking: a later damage gave an earlier time a lower energy, and was taken back there.

    Attributes
    ----------
    index
        Index of the step that the damage came from.
    time
        Time of that step (s).
    before
        Total energy that was kept at the time returned to.
    found
        Energy at that time with the later damage, from which the minimization went on.
    number
        Number of this return among those to the same time.
    limit
        Largest number of returns to one time; None if there is no limit.
    """

    index: int
    time: float
    before: float
    found: float
    number: int = 1
    limit: int | None = None


@dataclass(frozen=True, kw_only=True)
class Moment:
    """Index and time of a step.

    Attributes
    ----------
    index
        Index of the step, from 0.
    time
        Its time (s, or scaled).
    tau
        Its dimensionless time; None where nothing diffuses.
    """

    index: int
    time: float
    tau: float | None


@dataclass(frozen=True, kw_only=True)
class Step:
    """One load state, as recorded in `steps.jsonl`.

    Attributes
    ----------
    index
        Index of the step, from 0. A step with `returned` supersedes all steps recorded before it
        that have its index or a later one, see `kept`.
    time
        Its time (s, or scaled).
    tau
        Its dimensionless time; None where nothing diffuses.
    energies
        Energies of its state.
    sweeps
        Number of sweeps of its minimization.
    status
        Converged; not converged (out of sweeps); failed (a solver failed: the state is the last
        one before that, without audit and measures); or rejected (the step was too long and is
        taken again, or a return to it failed: it is no state of the run).
    reason
        The sentence on its end that a user reads.
    audit
        Checks of the step.
    measures
        Crack network of its state.
    effort
        What its minimization did besides sweeps.
    seconds
        Time that it took (s).
    fields
        File of its fields, below the run directory; None if they were not kept.
    returned
        How backtracking came to this step again, or, of a rejected one, how it would have.
    stability
        Eigenvalues of the second-order test; None where they were not asked for.
    curvature
        Second-order test of its state; None where there was none.
    heat
        Account of the heat equation; None without one.
    reactions
        Force that each constrained side exerts on the body (N; in 2-D N/m), shape (dim,).
    probed
        T (K), u (m) and alpha at the points of the manifest's probes in turn.
    hoop
        Share of the damage that grew in the step where no stress pulls more than the one around the
        axis, see `measure.hoop`; None but in bodies of revolution.
    released
        Energy release rates at the tips, where fields are kept.
    quantities
        Numbers of a script's quantities, by name.
    mesh
        Mesh of its state; None where the mesh stays as it is.
    """

    index: int
    time: float
    tau: float | None
    energies: Energies
    sweeps: int
    status: Status
    reason: str
    audit: Audit | None = None
    measures: Measures | None = None
    effort: SolverStatistics = field(default_factory=SolverStatistics)
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
    mesh: RefinedMesh | None = None

    @property
    def reached(self) -> bool:
        """True if its state is one of the run: its minimization converged."""
        return self.status == Status.CONVERGED

    @property
    def tips(self) -> tuple[Tip, ...]:
        """Tips of the cracks; none where nothing was measured."""
        return self.measures.tips if self.measures else ()

    def to_record(self) -> dict[str, Any]:
        """Return the step as a dictionary that JSON can hold, with the total energy."""
        record = json_form(self)
        record["energies"]["total"] = self.energies.total
        return record

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> Self:
        """Return the step that `to_record` wrote, of this version or of an earlier one."""
        # Runs of version 0.1.0 counted nothing else.
        return made(cls, {"effort": {"fallbacks": record.get("fallbacks", 0)}, **record})


def kept(steps: Iterable[Step]) -> tuple[Step, ...]:
    """Return the steps that were neither rejected nor superseded by backtracking, in order."""
    found: list[Step] = []
    for step in (step for step in steps if step.status != Status.REJECTED):
        while found and found[-1].index >= step.index:
            found.pop()
        found.append(step)
    return tuple(found)
