"""Backtracking: a later damage that lowers the energy at an earlier time is taken back there.

Irreversibility makes the damage of a step admissible at every earlier time. Where it gives a lower
energy than the state kept there, that state was no global minimum (Bourdin 2007 for loads in
proportion to time, where energies scale with its square; here each earlier time is solved for with
its own temperature and displacements, so that any load will do). The evolution goes back to the
earliest such time, and on from there. A return lowers the energy at the time returned to by more
than a tolerance and leaves those before it as they are: a descent in lexicographic order, which
ends.

Where cracks change the flow of heat there is no energy that both share: the temperature at the
earlier time is the one that these cracks would have led to there, and the returns to a time are
limited.
"""

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
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

# Returns to a time where cracks change the flow of heat, so that nothing tells that they end.
MOST_RETURNS = 3


@dataclass(frozen=True, kw_only=True)
class Past:
    """What is remembered of a step besides its damage and temperature.

    total, scale: its energy, see `records.Energies`. loaded, work, imbalance: the energy on frozen
    cracks that it began with, and the account of the loads that led there. heat: what the heat
    equation did.
    """

    loads: Loads
    total: float
    scale: float
    loaded: float
    work: float
    imbalance: float
    heat: Heat | None


class History:
    """The steps kept so far; their damage and temperature lie on disk, each rank's own part, ghosts
    included.

    returns: how often each step, by its index, was returned to. failed: steps that could not be
    returned to, and are not tried again. states: the numbers of the states
    on disk, that before the first step and one a step; no number is given twice.
    """

    def __init__(self, state: State | None = None) -> None:
        """state: the one before the first step; without it, `remember` what was kept before."""
        self.steps: list[Past] = []
        self.returns: Counter[int] = Counter()
        self.failed: set[int] = set()
        self.states: list[int] = []
        self._given = count()
        self._folder = TemporaryDirectory(prefix="staffa-")
        if state is not None:
            self.remember(state.alpha.x.array, state.T.x.array)

    def keep(self, loads: Loads, advance: Advance, state: State) -> None:
        """Remember one more step."""
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
        """Put the damage and the temperature change (K) after the last step on disk."""
        number = next(self._given)
        np.save(self._file(number), np.stack([alpha, T]))
        self.states.append(number)

    def state(self, number: int) -> tuple[np.ndarray, np.ndarray]:
        """The damage and the temperature change (K) of a state, by its number in `states`."""
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
        """The damage that bounds a step's from below, and where its heat begins."""
        damage, T = self.state(self.states[index])
        return damage, Origin(time=self.steps[index - 1].loads.time if index else 0.0, T=T)

    def temperature(self, index: int) -> np.ndarray:
        """The temperature change (K) of a step."""
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
            np.save(self._file(number), np.stack([transfer(f) for f in self.state(number)]))
        self.steps = [
            replace(past, loads=Loads(time=past.loads.time, values=prescribed(past.loads.time)))
            for past in self.steps
        ]

    def _file(self, number: int) -> Path:
        return Path(self._folder.name) / f"{number}.npy"

    def close(self) -> None:
        """Delete the files."""
        self._folder.cleanup()


@dataclass(frozen=True, kw_only=True)
class Better:
    """An earlier step that the damage at hand improves, and its energy with that damage."""

    index: int
    found: float


def better_earlier(problem: Problem, system: System, history: History) -> Better | None:
    """The earliest step whose energy the last step's damage lowers; the state stays as it is.

    The damage is frozen, so that one factorization serves all times; times whose whole energy is
    less than the surface energy of that damage need no solution. Collective.
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


def _temperature(system: System, history: History, index: int) -> tuple[np.ndarray, Heat | None]:
    """The temperature change (K) at an earlier step, with the damage at hand if that matters."""
    past = history.steps[index]
    if not system.cooling.feels_cracks:
        return history.temperature(index), past.heat
    _, origin = history.before(index)
    alpha = system.state.alpha.x.array
    return system.cooling.advance(origin.T, alpha, origin.time, past.loads.time)


def go_back(
    problem: Problem,
    system: System,
    history: History,
    better: Better,
    watch: Watch = lambda sweep: None,
) -> Advance:
    """Minimize at the earlier time from the damage at hand, within that time's bounds. Collective.

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
