"""Restart state of the time loop: all that its next step needs besides the case and the mesh.

Case, mesh, forms and solvers are made again. Each step starts with new preconditioners and takes
its first guesses from the state alone. So a resumed run gives the results of an uninterrupted one:
on one rank to the last bit, on the same number of ranks to round-off.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from staffa.evolution.advance import restore, snapshot
from staffa.evolution.audit import Before
from staffa.evolution.backtrack import Better, Past, StepHistory
from staffa.evolution.equilibrate import Loads
from staffa.evolution.initial_equilibrium import unmoved
from staffa.evolution.problem import Problem
from staffa.evolution.schedule import AdaptiveSteps
from staffa.evolution.system import System
from staffa.records.energies import Energies
from staffa.records.json_form import json_form, made
from staffa.records.step import Heat

# The fields of `snapshot`, in its order; u has a value for each component at a node. FACES has
# values in cells, and exists if crack faces touch.
FIELDS, FACES = ("u", "alpha", "T", "lower"), "faces"
# Those of a state of `StepHistory`.
PAST_FIELDS = ("alpha", "T")


@dataclass(frozen=True, kw_only=True)
class PastNumbers:
    """A step of `StepHistory`, as a checkpoint keeps it.

    Attributes
    ----------
    loads
        Time (s) of its loads, which tells the displacements prescribed then.
    total
        Its total energy, see `Energies`; so are `scale`, `loaded`, `work` and `imbalance`.
    scale
        Scale of its energy.
    loaded
        Energy on frozen cracks that it started with.
    work
        Work of the loads on the way there.
    imbalance
        Error in the account of that work.
    heat
        Account of the heat equation; None without one.
    """

    loads: float
    total: float
    scale: float
    loaded: float
    work: float
    imbalance: float
    heat: Heat | None = None


@dataclass(frozen=True, kw_only=True)
class LoopNumbers:
    """Numbers of a checkpoint: all of a `RestartState` but its fields.

    Attributes
    ----------
    index
        Index of the next step, unless `better` is an earlier one to go back to.
    start
        Time (s) that `AdaptiveSteps` has come to; None before the first step.
    length
        Length of its next step (s).
    loads
        Numbers of the external loads, the last part of `snapshot`.
    rest
        Energies that others count from.
    total
        Energy that the step before ended with; None in checkpoints of older versions.
    better
        Earlier step that is gone back to next; None for going on.
    past
        Steps of the history; empty without backtracking.
    returns
        Number of returns to each step, by its index.
    failed
        Indices of steps that could not be returned to.
    due
        True if the last step is still to be looked back from.
    """

    index: int
    start: float | None
    length: float
    loads: tuple[float, ...]
    rest: Energies
    total: float | None = None
    better: Better | None = None
    past: tuple[PastNumbers, ...] = ()
    returns: dict[int, int] = field(default_factory=dict)
    failed: tuple[int, ...] = ()
    due: bool = False


@dataclass(frozen=True, kw_only=True)
class RestartState:
    """Restart state of the time loop.

    Attributes
    ----------
    index : index of the next step, unless `better` is an earlier one to return to.
    start, length : time (s) and step length of `AdaptiveSteps`.
    kept : `snapshot` of the state.
    components : number of components of u (a rank may have no vertex).
    rest : energies from which others are counted.
    total : energy at the end of the step before; None in a checkpoint of an older version.
    better : earlier step to return to next; None to continue.
    past, returns, states : those of `history` at that time; empty without backtracking.
    failed : indices of steps to which a return failed.
    due : True if earlier steps must still be compared with the last one.
    history : kept steps; None without backtracking.
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
    history: StepHistory | None = None

    def numbers(self) -> dict[str, Any]:
        """Return all but the fields, as JSON holds it."""
        told = LoopNumbers(
            index=self.index,
            start=self.start,
            length=self.length,
            loads=tuple(self.kept[-1].tolist()),
            rest=self.rest,
            total=self.total,
            better=self.better,
            past=tuple(map(_numbers_of, self.past)),
            returns=dict(self.returns),
            failed=self.failed,
            due=self.due,
        )
        return json_form(told)

    def fields(self) -> dict[str, np.ndarray]:
        """Return the fields, ghosts included: shape (n_vertices,), of u (n_nodes, components)."""
        fields = dict(zip(FIELDS, self.kept, strict=False))
        return fields | {"u": fields["u"].reshape(-1, self.components)}

    def faces(self) -> np.ndarray | None:
        """Return the field of crack faces, cell by cell, ghosts included; None without."""
        return self.kept[len(FIELDS)] if len(self.kept) > len(FIELDS) + 1 else None

    def past_fields(self, number: int) -> dict[str, np.ndarray]:
        """Return the fields of one of the `states`, ghosts included."""
        assert self.history is not None
        return dict(zip(PAST_FIELDS, self.history.state(number), strict=True))

    def anew(self) -> "RestartState":
        """Return the same state, with failed returns allowed again, for changed solvers."""
        if self.history:
            self.history.failed.clear()
        return replace(self, failed=())

    def taken_up(self, problem: Problem, system: System) -> "Loop":
        """Restore the system, and return the loop that continues. Collective."""
        restore(system, self.kept)
        system.energy.rest = self.rest
        history = None
        if problem.backtracking:  # before the first step it may be new
            history = self.history or StepHistory(system.state)
        return Loop(
            walk=AdaptiveSteps(problem.schedule, self.start, self.length),
            history=history,
            index=self.index,
            total=self.total,
            better=self.better if problem.backtracking else None,
            due=self.due and history is not None,
        )


def restart_state(
    numbers: Mapping[str, Any],
    fields: Mapping[str, np.ndarray],
    past_fields: Iterable[Mapping[str, np.ndarray]] | None,
    system: System,
) -> RestartState:
    """Return the restart state from a checkpoint, on the current ranks.

    Parameters
    ----------
    numbers : numbers of the checkpoint, from `RestartState.numbers`.
    fields : fields of this rank's vertices, ghosts included, with FACES if crack faces touch.
    past_fields : fields of the history, likewise; None without backtracking.
    system : the system.
    """
    told = made(LoopNumbers, numbers)
    past = tuple(_past(one, system) for one in told.past)
    history = None
    if past_fields is not None:
        history = StepHistory()
        history.steps, history.returns = list(past), Counter(told.returns)
        history.failed = set(told.failed)
        for state in past_fields:
            history.remember(state["alpha"], state["T"])
    return RestartState(
        index=told.index,
        start=told.start,
        length=told.length,
        kept=(
            *(fields[name].ravel() for name in (*FIELDS, FACES) if name in fields),
            np.array(told.loads),
        ),
        components=system.spaces.u.dofmap.index_map_bs,
        rest=told.rest,
        total=told.total,
        better=told.better,
        past=past,
        returns=told.returns,
        failed=told.failed,
        due=told.due,
        states=tuple(history.states) if history else (),
        history=history,
    )


def _numbers_of(past: Past) -> PastNumbers:
    return PastNumbers(**{**vars(past), "loads": past.loads.time})


def _past(told: PastNumbers, system: System) -> Past:
    loads = Loads(time=told.loads, values=system.supports.values(told.loads))
    return Past(**{**vars(told), "loads": loads})


@dataclass(kw_only=True)
class Loop:
    """State of the loop that changes from step to step, besides the fields.

    Attributes
    ----------
    walk : position in the schedule.
    history : kept steps; None without backtracking.
    total : energy at the end of the step before.
    index : index of the next step, unless `better` is an earlier one to return to.
    better : earlier step to return to; None to continue.
    due : True if earlier steps must still be compared with the last one.
    """

    walk: AdaptiveSteps
    history: StepHistory | None
    total: float | None
    index: int = 0
    better: Better | None = None
    due: bool = False

    @property
    def next_index(self) -> int:
        """Index of the next step."""
        return self.better.index if self.better else self.index

    def next_time(self) -> float | None:
        """Return the time (s) of the next step; None at the end."""
        onward = self.walk.next()
        if self.better and self.history:
            return self.history.steps[self.better.index].loads.time
        return onward

    def start(self, system: System) -> Loads:
        """Return the loads of the current state."""
        time = self.walk.start
        if time is None:
            return unmoved(system)
        return Loads(time=time, values=system.supports.values(time))

    def before(self, kept: tuple[np.ndarray, ...]) -> Before:
        """Return the recorded state before the next step; `kept` is its `snapshot`."""
        if self.better and self.history:
            damage, origin = self.history.before(self.better.index)
            return Before(alpha=damage, T=origin.T, total=None)
        _, alpha, T, *_ = kept
        return Before(alpha=alpha, T=T, total=self.total)

    def standing(self, system: System) -> RestartState:
        """Return the restart state."""
        history = self.history
        return RestartState(
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
