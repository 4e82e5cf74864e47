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
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from staffa.errors import SolveError
from staffa.evolution.advance import Advance, Origin, agree, restore, snapshot
from staffa.evolution.equilibrate import Loads, settle
from staffa.evolution.problem import Problem
from staffa.evolution.system import System
from staffa.minimize.alternate import Watch, equilibrium
from staffa.model.fields import State
from staffa.records.step import Heat, Return

# Most returns to a time if the temperature depends on the cracks: then nothing ensures an end.
MOST_RETURNS = 3


@dataclass(frozen=True, kw_only=True)
class Past:
    """Record of a step for backtracking, besides its damage and temperature.

    Attributes
    ----------
    loads : its loads.
    total, scale : its energy and the scale of that, see `records.Energies`.
    loaded : energy on frozen cracks at its start.
    work, imbalance : work of the loads before, and error of the energy balance.
    heat : heat balance; None without the heat equation.
    """

    loads: Loads
    total: float
    scale: float
    loaded: float
    work: float
    imbalance: float
    heat: Heat | None


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

    def __init__(self, state: State | None = None) -> None:
        """Start with the state before the first step; None if states follow by `remember`."""
        self.steps: list[Past] = []
        self.returns: Counter[int] = Counter()
        self.failed: set[int] = set()
        self.states: list[int] = []
        self._given = count()
        self._folder = TemporaryDirectory(prefix="staffa-")
        if state is not None:
            self.remember(state.alpha.x.array, state.T.x.array)

    def keep(self, loads: Loads, advance: Advance, state: State) -> None:
        """Add one step.

        Parameters
        ----------
        loads : its loads.
        advance : its result.
        state : its fields.
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
        self.remember(state.alpha.x.array, state.T.x.array)

    def remember(self, alpha: np.ndarray, T: np.ndarray) -> None:
        """Write the damage and the temperature change (K) after the last step to disk."""
        number = next(self._given)
        np.save(self._file(number), np.stack([alpha, T]))
        self.states.append(number)

    def state(self, number: int) -> tuple[np.ndarray, np.ndarray]:
        """Return damage and temperature change (K) of a state, by its number in `states`."""
        alpha, T = np.load(self._file(number))
        return alpha, T

    def drop(self, index: int) -> None:
        """Forget a step and all later ones."""
        del self.steps[index:]
        self.failed = {number for number in self.failed if number < index}
        for number in self.states[index + 1 :]:
            self._file(number).unlink()
        del self.states[index + 1 :]

    def before(self, index: int) -> tuple[np.ndarray, Origin]:
        """Return the damage that is a step's lower bound, and the start of its heat."""
        damage, T = self.state(self.states[index])
        return damage, Origin(time=self.steps[index - 1].loads.time if index else 0.0, T=T)

    def temperature(self, index: int) -> np.ndarray:
        """Return the temperature change (K) of a step."""
        return self.state(self.states[index + 1])[1]

    def _file(self, number: int) -> Path:
        return Path(self._folder.name) / f"{number}.npy"

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
    kept, limited = snapshot(system), system.cooling.feels_cracks
    loaded = not problem.forces.at_rest
    # Loads may make an energy less than that of its cracks.
    surface = -np.inf if loaded else system.energy.energies().surface
    try:
        for index, past in enumerate(history.steps[:-1]):
            enough = past.total - backtracking.tolerance * past.scale
            ended = limited and history.returns[index] >= MOST_RETURNS
            if surface >= enough or ended or index in history.failed:
                continue
            system.state.T.x.array[:] = _temperature(system, history, index)[0]
            system.energy.external.at(past.loads.time)
            equilibrium(system.alternation, past.loads.values)
            found = system.energy.total()
            if found < enough:
                return Better(index=index, found=found)
        return None
    finally:
        restore(system, kept)


def _temperature(
    system: System, history: StepHistory, index: int
) -> tuple[np.ndarray, Heat | None]:
    """Return the temperature change (K) at an earlier step, for the current damage."""
    past = history.steps[index]
    if not system.cooling.feels_cracks:
        return history.temperature(index), past.heat
    _, origin = history.before(index)
    alpha = system.state.alpha.x.array
    return system.cooling.advance(origin.T, alpha, origin.time, past.loads.time)


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
    state.T.x.array[:], heat = _temperature(system, history, better.index)
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
                limit=MOST_RETURNS if system.cooling.feels_cracks else None,
            ),
            heat=heat,
            origin=origin if system.cooling.feels_cracks else None,
        )
        return agree(problem, system, past.loads, advance, watch)
    except SolveError:
        restore(system, kept)
        raise
