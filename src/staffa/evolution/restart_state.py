"""Restart state of the time loop: all that its next step needs besides the case and the mesh.

Case, mesh, forms and solvers are made again. Each step starts with new preconditioners and takes
its first guesses from the state, or from the damage of a try that is kept with it. So a resumed run
gives the results of an uninterrupted one: on one rank to the last bit, on the same number of ranks
to round-off.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from staffa.evolution.audit import Before
from staffa.evolution.backtrack import Better, Past, StepHistory
from staffa.evolution.coupling import ThermalState
from staffa.evolution.equilibrate import Loads
from staffa.evolution.initial_equilibrium import unmoved
from staffa.evolution.loop_numbers import Finer, LoopNumbers, PastNumbers
from staffa.evolution.schedule import AdaptiveSteps
from staffa.evolution.session import Session
from staffa.evolution.snapshot import Snapshot, restore, snapshot
from staffa.evolution.system import System
from staffa.minimize.alternate import equilibrium
from staffa.records.energies import Energies
from staffa.records.json_form import json_form, made

# Kept numbers of the faces of cracks, for each cell, where faces touch; and those of the source of
# temperatures, which belong to no place, where it has some; and the damage that a try of the next
# step came to.
FACES, MEMORY, TRIED = "faces", "memory", "tried"


@dataclass(frozen=True, kw_only=True)
class FirstGuess:
    """Damage that a try of a step on coarser cells came to.

    Attributes
    ----------
    time : time of the step (s).
    alpha : the damage on the current mesh, ghosts included, shape (n_local,).
    """

    time: float
    alpha: np.ndarray


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
    finer : what other meshes changed since the step before.
    tried : what a try of the next step on coarser cells came to; None without.
    history : kept steps; None without backtracking.
    """

    index: int
    start: float | None
    length: float
    kept: Snapshot
    components: int
    rest: Energies
    total: float | None
    better: Better | None = None
    past: tuple[Past, ...] = ()
    returns: Mapping[int, int]
    failed: tuple[int, ...] = ()
    due: bool = False
    finer: Finer = field(default_factory=Finer)
    tried: FirstGuess | None = None
    states: tuple[int, ...] = ()
    history: StepHistory | None = None

    def numbers(self) -> dict[str, Any]:
        """Return all but the fields, as JSON holds it."""
        told = LoopNumbers(
            index=self.index,
            start=self.start,
            length=self.length,
            loads=tuple(self.kept.loads.tolist()),
            rest=self.rest,
            total=self.total,
            better=self.better,
            past=tuple(map(_numbers_of, self.past)),
            returns=dict(self.returns),
            failed=self.failed,
            due=self.due,
            finer=self.finer,
            tried=self.tried.time if self.tried else None,
        )
        return json_form(told)

    def fields(self) -> dict[str, np.ndarray]:
        """Return the fields, ghosts included: shape (n_vertices,), of u (n_nodes, components)."""
        kept = self.kept
        return {
            "u": kept.u.reshape(-1, self.components),
            "alpha": kept.alpha,
            "lower": kept.lower,
            **({TRIED: self.tried.alpha} if self.tried else {}),
            **kept.thermal.fields(),
        }

    def faces(self) -> np.ndarray | None:
        """Return the field of crack faces, cell by cell, ghosts included; None without."""
        return self.kept.frozen[0] if self.kept.frozen else None

    def past_fields(self, number: int) -> tuple[dict[str, np.ndarray], np.ndarray]:
        """Return the fields of one of the `states`, with ghosts, and the memory of the coupling."""
        assert self.history is not None
        alpha, thermal = self.history.state(number)
        return {"alpha": alpha, **thermal.fields()}, thermal.memory

    def for_new_solvers(self) -> "RestartState":
        """Return the same state, with failed returns allowed again, for changed solvers."""
        if self.history:
            self.history.failed.clear()
        return replace(self, failed=())

    def taken_up(self, session: Session) -> "Loop":
        """Make the session what it was; the loop goes on from there. Collective."""
        problem, system = session.problem, session.system
        restore(system, self.kept)
        system.energy.rest = self.rest
        if problem.backtracking:  # before the first step it may be new
            session.history = self.history or StepHistory(system)
        return Loop(
            session=session,
            walk=AdaptiveSteps(problem.schedule, self.start, self.length),
            index=self.index,
            total=self.total,
            better=self.better if problem.backtracking else None,
            due=self.due and session.history is not None,
            finer=self.finer,
            tried=self.tried,
            changes=session.changes,
        )


def restart_state(
    numbers: Mapping[str, Any],
    fields: Mapping[str, np.ndarray],
    past_fields: Iterable[Mapping[str, np.ndarray]] | None,
    system: System,
) -> RestartState:
    """Return the restart state of a checkpoint. Collective.

    Parameters
    ----------
    numbers : see `RestartState.numbers`.
    fields : values at this rank's vertices, ghosts included; FACES where faces of cracks touch,
        and MEMORY where the coupling has one.
    past_fields : the same of earlier states, without FACES; None without backtracking.
    system : system on the same mesh.
    """
    told = made(LoopNumbers, numbers)
    past = tuple(_past(one, system) for one in told.past)
    history = None
    if past_fields is not None:
        history = StepHistory()
        history.steps, history.returns = list(past), Counter(told.returns)
        history.failed = set(told.failed)
        for state in past_fields:
            history.remember(state["alpha"], _thermal(state))
    return RestartState(
        index=told.index,
        start=told.start,
        length=told.length,
        kept=Snapshot(
            u=fields["u"].ravel(),
            alpha=fields["alpha"],
            lower=fields["lower"],
            thermal=_thermal(fields),
            frozen=(fields[FACES].ravel(),) if FACES in fields else (),
            loads=np.array(told.loads),
        ),
        components=system.spaces.u.dofmap.index_map_bs,
        rest=told.rest,
        total=told.total,
        better=told.better,
        past=past,
        returns=told.returns,
        failed=told.failed,
        due=told.due,
        finer=told.finer,
        tried=None if told.tried is None else FirstGuess(time=told.tried, alpha=fields[TRIED]),
        states=tuple(history.states) if history else (),
        history=history,
    )


def _thermal(fields: Mapping[str, np.ndarray]) -> ThermalState:
    """Return the thermal state; checkpoints of older versions have no memory and no pressure."""
    memory = fields.get(MEMORY, np.zeros(0))
    return ThermalState(T=fields["T"], p=fields.get("p"), memory=memory)


def _numbers_of(past: Past) -> PastNumbers:
    return PastNumbers(**{**vars(past), "loads": past.loads.time})


def _past(told: PastNumbers, system: System) -> Past:
    loads = Loads(time=told.loads, values=system.supports.values(told.loads))
    return Past(**{**vars(told), "loads": loads})


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
    finer : what other meshes changed since the step before.
    tried : what a try of the next step on coarser cells came to; None without.
    changes : those of the session's mesh that the loop knows of.
    """

    session: Session
    walk: AdaptiveSteps
    total: float | None
    index: int = 0
    better: Better | None = None
    due: bool = False
    finer: Finer = field(default_factory=Finer)
    tried: FirstGuess | None = None
    changes: int = 0

    @property
    def history(self) -> StepHistory | None:
        """Earlier states on the current mesh; None without backtracking."""
        return self.session.history

    def meet_mesh(self) -> None:
        """Find equilibrium with frozen cracks on a mesh that has changed. Collective.

        A finer mesh has a lower energy by itself: what comes is compared with the energy on it.
        """
        if self.changes == self.session.changes:
            return
        system = self.session.system
        equilibrium(system.alternation, self.start().values)
        total, before = system.energy.total(), self.total
        self.finer = Finer(
            changes=self.finer.changes + self.session.changes - self.changes,
            energy=self.finer.energy + (0.0 if before is None else total - before),
        )
        self.changes, self.total = self.session.changes, total

    def guess(self, time: float) -> np.ndarray | None:
        """Return the first guess of the damage of a step to a time (s), if there is one and the
        case asks for guesses."""
        asked = self.session.problem.solvers.guess != "none"
        return self.tried.alpha if asked and self.tried and self.tried.time == time else None

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

    def start(self) -> Loads:
        """Return the loads of the current state."""
        time, system = self.walk.start, self.session.system
        if time is None:
            return unmoved(system)
        return Loads(time=time, values=system.supports.values(time))

    def before(self, kept: Snapshot) -> Before:
        """Return the recorded state before the next step; `kept` is its `snapshot`."""
        if self.better and self.history:
            damage, origin = self.history.before(self.better.index)
            return Before(alpha=damage, thermal=origin.thermal, total=None)
        return Before(alpha=kept.alpha, thermal=kept.thermal, total=self.total)

    def restart(self) -> RestartState:
        """Return the restart state."""
        history, system = self.history, self.session.system
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
            finer=self.finer,
            tried=self.tried,
            states=tuple(history.states) if history else (),
            history=history,
        )
