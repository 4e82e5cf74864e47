"""Where the time loop stands between two steps: all that its next step depends on.

Of the case and its mesh nothing is kept here: both are made again, and so are forms and solvers.
Each step begins with new preconditioners and takes its first guesses from the state alone, so that
a run that goes on from here gives what it would have given: on one rank to the last bit, on as many
ranks as before to round-off.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from staffa.evolution.advance import restore, snapshot
from staffa.evolution.audit import Before
from staffa.evolution.backtrack import Better, History, Past
from staffa.evolution.equilibrate import Loads
from staffa.evolution.initial_equilibrium import unmoved
from staffa.evolution.schedule import Walk
from staffa.evolution.session import Session
from staffa.evolution.system import System
from staffa.minimize.alternate import equilibrium
from staffa.records.step import Energies, Heat, made

# The fields of `snapshot`, in its order; u has a value for each component at a node. FACES has some
# for each cell, and is there where faces of cracks touch.
FIELDS, FACES = ("u", "alpha", "T", "lower"), "faces"
# Those of a state of `History`.
PAST_FIELDS = ("alpha", "T")


@dataclass(frozen=True, kw_only=True)
class Standing:
    """What a checkpoint keeps.

    index: of the next step, unless `better` is an earlier one to go back to. start, length: of
    `Walk`. kept: `snapshot` of the state. components: of u (a rank may have no vertex). rest:
    energies that others count from. total: energy that the step before ended with, None in
    checkpoints of older versions. past, returns, states: of `history`, as they were then; empty
    without backtracking.
    """

    index: int
    start: float | None
    length: float
    kept: tuple[np.ndarray, ...]
    components: int
    rest: Energies
    total: float | None
    better: Better | None = None
    past: tuple[Past, ...] = ()
    returns: Mapping[int, int]
    failed: tuple[int, ...] = ()
    due: bool = False
    states: tuple[int, ...] = ()
    history: History | None = None

    def numbers(self) -> dict[str, Any]:
        """All but the fields, as JSON can hold it."""
        return {
            "index": self.index,
            "start": self.start,
            "length": self.length,
            "loads": self.kept[-1].tolist(),
            "rest": asdict(self.rest),
            "total": self.total,
            "better": None if self.better is None else asdict(self.better),
            "past": [_numbers_of(past) for past in self.past],
            "returns": {str(index): times for index, times in self.returns.items()},
            "failed": list(self.failed),
            "due": self.due,
        }

    def fields(self) -> dict[str, np.ndarray]:
        """The fields, ghosts included: shape (n_vertices,), of u (n_nodes, components)."""
        fields = dict(zip(FIELDS, self.kept, strict=False))
        return fields | {"u": fields["u"].reshape(-1, self.components)}

    def faces(self) -> np.ndarray | None:
        """Kept numbers of the faces of cracks, cell by cell, ghosts included; None for nothing."""
        return self.kept[len(FIELDS)] if len(self.kept) > len(FIELDS) + 1 else None

    def past_fields(self, number: int) -> dict[str, np.ndarray]:
        """Those of one of the `states`, ghosts included."""
        assert self.history is not None
        return dict(zip(PAST_FIELDS, self.history.state(number), strict=True))

    def anew(self) -> "Standing":
        """The same, for solvers that may do what others could not: returns that failed are tried
        again."""
        if self.history:
            self.history.failed.clear()
        return replace(self, failed=())

    def taken_up(self, session: Session) -> "Loop":
        """Make the session what it was; the loop goes on from there. Collective."""
        problem, system = session.problem, session.system
        restore(system, self.kept)
        system.energy.rest = self.rest
        if problem.backtracking:  # before the first step it may be new
            session.history = self.history or History(system.state)
        return Loop(
            session=session,
            walk=Walk(problem.schedule, self.start, self.length),
            index=self.index,
            total=self.total,
            better=self.better if problem.backtracking else None,
            due=self.due and session.history is not None,
            changes=session.changes,
        )


def standing(
    numbers: Mapping[str, Any],
    fields: Mapping[str, np.ndarray],
    past_fields: Iterable[Mapping[str, np.ndarray]] | None,
    system: System,
) -> Standing:
    """What `numbers`, `fields` and `past_fields` told, on the ranks at hand.

    fields, past_fields: of this rank's vertices, ghosts included; None without backtracking. fields
    has FACES too, where faces of cracks touch.
    """
    past = tuple(_past(record, system) for record in numbers["past"])
    returns = Counter({int(index): times for index, times in numbers["returns"].items()})
    history = None
    if past_fields is not None:
        history = History()
        history.steps, history.returns = list(past), returns
        history.failed = set(numbers.get("failed", ()))
        for state in past_fields:
            history.remember(state["alpha"], state["T"])
    return Standing(
        index=numbers["index"],
        start=numbers["start"],
        length=numbers["length"],
        kept=(
            *(fields[name].ravel() for name in (*FIELDS, FACES) if name in fields),
            np.array(numbers["loads"]),
        ),
        components=system.spaces.u.dofmap.index_map_bs,
        rest=made(Energies, numbers["rest"]),
        total=numbers.get("total"),
        better=None if numbers["better"] is None else made(Better, numbers["better"]),
        past=past,
        returns=returns,
        failed=tuple(numbers.get("failed", ())),
        due=numbers.get("due", False),
        states=tuple(history.states) if history else (),
        history=history,
    )


def _numbers_of(past: Past) -> dict[str, Any]:
    """A past step without its prescribed displacements, which its time tells."""
    heat = None if past.heat is None else asdict(past.heat)
    return {**vars(past), "loads": past.loads.time, "heat": heat}


def _past(record: Mapping[str, Any], system: System) -> Past:
    time, heat = record["loads"], record["heat"]
    loads = Loads(time=time, values=system.supports.values(time))
    known = Past(**{**record, "loads": loads})
    return replace(known, heat=None if heat is None else made(Heat, heat))


@dataclass(kw_only=True)
class Loop:
    """The time loop: all that changes from step to step besides the state.

    Attributes
    ----------
    session : owner of the mesh, the state and earlier states.
    walk : time and length of the next step.
    total : energy that the step before ended with; None where it is not known.
    index : number of the next step, unless `better` is an earlier one to go back to.
    better : earlier step to go back to.
    due : True if the last step is still to be looked back from.
    changes : those of the session's mesh that the loop knows of.
    """

    session: Session
    walk: Walk
    total: float | None
    index: int = 0
    better: Better | None = None
    due: bool = False
    changes: int = 0

    @property
    def history(self) -> History | None:
        """Earlier states on the current mesh; None without backtracking."""
        return self.session.history

    def meet_mesh(self) -> None:
        """Where the mesh has changed, find equilibrium on it with frozen cracks. Collective.

        The energy that the step before ended with is then none to compare with.
        """
        if self.changes != self.session.changes:
            equilibrium(self.session.system.alternation, self.start().values)
            self.changes, self.total = self.session.changes, None

    @property
    def next_index(self) -> int:
        """Of the step that comes now."""
        return self.better.index if self.better else self.index

    def next_time(self) -> float | None:
        """Its time (s); None at the end."""
        onward = self.walk.next()
        if self.better and self.history:
            return self.history.steps[self.better.index].loads.time
        return onward

    def start(self) -> Loads:
        """The loads that the state at hand bears."""
        time, system = self.walk.start, self.session.system
        if time is None:
            return unmoved(system)
        return Loads(time=time, values=system.supports.values(time))

    def before(self, kept: tuple[np.ndarray, ...]) -> Before:
        """The state that the step now follows on, as it is on record; kept: `snapshot`."""
        if self.better and self.history:
            damage, origin = self.history.before(self.better.index)
            return Before(alpha=damage, T=origin.T, total=None)
        _, alpha, T, *_ = kept
        return Before(alpha=alpha, T=T, total=self.total)

    def standing(self) -> Standing:
        """What of it is to be kept."""
        history, system = self.history, self.session.system
        return Standing(
            index=self.index,
            start=self.walk.start,
            length=self.walk.length,
            kept=snapshot(system),
            components=system.spaces.u.dofmap.index_map_bs,
            rest=system.energy.rest,
            total=self.total,
            better=self.better,
            past=tuple(history.steps) if history else (),
            returns=dict(history.returns) if history else {},
            failed=tuple(sorted(history.failed)) if history else (),
            due=self.due,
            states=tuple(history.states) if history else (),
            history=history,
        )
