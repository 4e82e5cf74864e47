"""Backtracking: return to an earlier time at which the damage found later has a lower energy.

Irreversibility makes the damage of a step admissible at every earlier time. If it has a lower
energy there than the kept state, that state was no global minimum (Bourdin 2007, for loads in
proportion to time, where energies scale with its square; here each earlier time is solved with its
own temperature and displacements, so that any load is possible). The evolution returns to the
earliest such time, and continues from there. A return lowers the energy at its time by more than a
tolerance and does not change the times before: a descent in lexicographic order, which ends.

If the temperature depends on the cracks, both states have no common energy: the temperature at the
earlier time is the one that these cracks would have led to, and the returns to a time are limited.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from staffa.errors import SolveError
from staffa.evolution.advanced_step import Advance, Origin
from staffa.evolution.agree import agree
from staffa.evolution.coupling import ThermalState
from staffa.evolution.equilibrate import Loads, settle
from staffa.evolution.problem import Problem
from staffa.evolution.snapshot import restore, snapshot
from staffa.evolution.system import System
from staffa.minimize.alternate import Watch, equilibrium
from staffa.records.step import Heat, Return

# Returns to a time where cracks change the flow of heat, so that nothing tells that they end.
MOST_RETURNS = 3


@dataclass(frozen=True, kw_only=True)
class Past:
    """Record of an earlier step besides its damage and temperature.

    Attributes
    ----------
    loads : its loads.
    total, scale : its energy and the scale of that, see `records.energies`.
    loaded : energy on frozen cracks that it began with.
    work : work of the loads that led there.
    imbalance : error of the balance of that work.
    heat : account of heat; None without one.
    moved : True if its energy is that on an earlier mesh.
    """

    loads: Loads
    total: float
    scale: float
    loaded: float
    work: float
    imbalance: float
    heat: Heat | None
    moved: bool = False


class StepHistory:
    """Kept steps; their damage and temperature are on disk, each rank's part with ghosts.

    Attributes
    ----------
    steps : records of the kept steps.
    returns : number of returns to each step, by its index.
    failed : steps to which a return failed; they are not tried again.
    states : numbers of the states on disk, that before the first step and one a step; no number is
        used twice.
    """

    def __init__(self, system: System | None = None) -> None:
        """system: in the state before the first step; None where `remember` gives what was kept."""
        self.steps: list[Past] = []
        self.returns: Counter[int] = Counter()
        self.failed: set[int] = set()
        self.states: list[int] = []
        self._given = count()
        self._folder = TemporaryDirectory(prefix="staffa-")
        if system is not None:
            self.remember(system.state.alpha.x.array, system.thermal.read())

    def keep(self, loads: Loads, advance: Advance, system: System) -> None:
        """Add one step.

        Parameters
        ----------
        loads : its loads.
        advance : its result.
        system : holds its damage and its temperature.
        """
        total = advance.outcome.energies.total
        self.steps.append(
            Past(
                loads=loads,
                total=total,
                scale=advance.outcome.energies.scale,
                loaded=total + advance.released,
                work=advance.work,
                imbalance=advance.imbalance,
                heat=advance.all_heat,
            )
        )
        self.remember(system.state.alpha.x.array, system.thermal.read())

    def remember(self, alpha: np.ndarray, thermal: ThermalState) -> None:
        """Put the damage and the thermal state after the last step on disk."""
        number = next(self._given)
        self._write(number, alpha, thermal)
        self.states.append(number)

    def _write(self, number: int, alpha: np.ndarray, thermal: ThermalState) -> None:
        fields: dict[str, Any] = {"memory": thermal.memory, **thermal.fields()}
        np.savez(self._file(number), alpha=alpha, **fields)

    def state(self, number: int) -> tuple[np.ndarray, ThermalState]:
        """The damage and the thermal state, by their number in `states`."""
        with np.load(self._file(number)) as kept:
            return kept["alpha"], ThermalState(T=kept["T"], p=kept.get("p"), memory=kept["memory"])

    def drop(self, index: int) -> None:
        """Forget a step and all later ones."""
        del self.steps[index:]
        self.failed = {number for number in self.failed if number < index}
        for number in self.states[index + 1 :]:
            self._file(number).unlink()
        del self.states[index + 1 :]

    def before(self, index: int) -> tuple[np.ndarray, Origin]:
        """Return the damage that is a step's lower bound, and the start of its heat."""
        damage, thermal = self.state(self.states[index])
        time = self.steps[index - 1].loads.time if index else 0.0
        return damage, Origin(time=time, thermal=thermal)

    def thermal(self, index: int) -> ThermalState:
        """The thermal state after a step."""
        return self.state(self.states[index + 1])[1]

    def move(
        self,
        transfer: Callable[[np.ndarray], np.ndarray],
        prescribed: Callable[[float], np.ndarray],
    ) -> None:
        """Take every state to another mesh. Collective.

        Parameters
        ----------
        transfer : from values at the vertices of the one mesh to those of the other.
        prescribed : displacements (m) that supports of the other mesh prescribe at a time (s).
        """
        for number in self.states:
            alpha, thermal = self.state(number)
            self._write(number, transfer(alpha), thermal.moved(transfer))
        self.steps = [
            replace(
                past,
                loads=Loads(time=past.loads.time, values=prescribed(past.loads.time)),
                moved=True,
            )
            for past in self.steps
        ]

    def _file(self, number: int) -> Path:
        return Path(self._folder.name) / f"{number}.npz"

    def close(self) -> None:
        """Delete the files."""
        self._folder.cleanup()


@dataclass(frozen=True, kw_only=True)
class Better:
    """Earlier step whose energy the current damage lowers.

    Attributes
    ----------
    index : index of the step.
    found : its energy with that damage.
    """

    index: int
    found: float


def better_earlier(problem: Problem, system: System, history: StepHistory) -> Better | None:
    """Find the earliest step whose energy the last step's damage lowers; the state is unchanged.

    The damage is frozen, so that one factorization serves all times. Times whose whole energy is
    less than the surface energy of that damage need no solution. Collective.

    Parameters
    ----------
    problem : the problem.
    system : its system.
    history : the kept steps.
    """
    backtracking = problem.backtracking
    if backtracking is None:
        return None
    kept, limited = snapshot(system), system.coupling.agreement is not None
    loaded = not problem.forces.at_rest
    # Loads may make an energy less than that of its cracks.
    surface = -np.inf if loaded else system.energy.energies().surface
    try:
        for index, past in enumerate(history.steps[:-1]):
            enough = past.total - backtracking.tolerance * past.scale
            ended = limited and history.returns[index] >= MOST_RETURNS
            if surface >= enough or ended or index in history.failed:
                continue
            system.thermal.put(_thermal(system, history, index)[0])
            system.energy.external.at(past.loads.time)
            equilibrium(system.alternation, past.loads.values)
            found = system.energy.total()
            if found < enough and past.moved:
                enough = _on_this_mesh(system, history, index) - backtracking.tolerance * past.scale
                restore(system, kept)
            if found < enough:
                return Better(index=index, found=found)
        return None
    finally:
        restore(system, kept)


def _on_this_mesh(system: System, history: StepHistory, index: int) -> float:
    """Return the energy of an earlier step on the current mesh, which lowers it by itself."""
    past = history.steps[index]
    alpha, thermal = history.state(history.states[index + 1])
    system.state.alpha.x.array[:] = alpha
    system.thermal.put(thermal)
    equilibrium(system.alternation, past.loads.values)
    total = system.energy.total()
    loaded = past.loaded + total - past.total  # what cracks released then stays
    history.steps[index] = replace(past, total=total, loaded=loaded, moved=False)
    return total


def _thermal(system: System, history: StepHistory, index: int) -> tuple[ThermalState, Heat | None]:
    """The thermal state at an earlier step, with the current cracks if that matters."""
    past = history.steps[index]
    if system.coupling.agreement is None:
        return history.thermal(index), past.heat
    _, origin = history.before(index)
    return system.coupling.advance(origin.thermal, system.cracks, origin.time, past.loads.time)


def go_back(
    problem: Problem,
    system: System,
    history: StepHistory,
    better: Better,
    watch: Watch = lambda sweep: None,
) -> Advance:
    """Minimize at the earlier time from the current damage, within that time's bounds. Collective.

    Parameters
    ----------
    problem : the problem.
    system : its system.
    history : the kept steps.
    better : the earlier step.
    watch : called after each sweep.

    Raises
    ------
    SolveError
        A solver failed; the state is the one before it.
    """
    last, past = history.steps[-1], history.steps[better.index]
    state, kept = system.state, snapshot(system)
    damage = state.alpha.x.array.copy()
    thermal, heat = _thermal(system, history, better.index)
    system.thermal.put(thermal)
    state.alpha.x.array[:], origin = history.before(better.index)
    system.energy.external.at(past.loads.time)
    history.returns[better.index] += 1
    try:
        outcome, healing = settle(problem, system, past.loads, watch, damage=damage)
        advance = Advance(
            outcome=outcome,
            healing=healing,
            work=past.work,
            released=past.loaded - outcome.energies.total,
            imbalance=past.imbalance,
            returned=Return(
                index=len(history.steps) - 1,
                time=last.loads.time,
                before=past.total,
                found=better.found,
                number=history.returns[better.index],
                limit=None if system.coupling.agreement is None else MOST_RETURNS,
            ),
            heat=heat,
            origin=origin,
        )
        return agree(problem, system, past.loads, advance, watch)
    except SolveError:
        restore(system, kept)
        raise
