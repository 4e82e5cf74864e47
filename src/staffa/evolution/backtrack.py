"""Backtracking: a later damage that lowers the energy at an earlier time is taken back there.

Irreversibility makes the damage of a step admissible at every earlier time. Where it gives a lower
energy than the state kept there, that state was no global minimum (Bourdin 2007 for loads in
proportion to time, where energies scale with its square; here each earlier time is solved for with
its own temperature and displacements, so that any load will do). The evolution goes back to the
earliest such time, and on from there. A return lowers the energy at the time returned to by more
than a tolerance and leaves those before it as they are: a descent in lexicographic order, which
ends.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from staffa.errors import SolveError
from staffa.evolution.advance import Advance, restore, snapshot
from staffa.evolution.problem import Problem
from staffa.evolution.settle import Loads, settle, temperature
from staffa.evolution.system import System
from staffa.minimize.alternate import Sweep, equilibrium
from staffa.records import Return


@dataclass(frozen=True, kw_only=True)
class Past:
    """What is remembered of a step besides its damage.

    total: its energy. loaded, work, imbalance: the energy on frozen cracks that it began with, and
    the account of the loads that led there.
    """

    loads: Loads
    total: float
    loaded: float
    work: float
    imbalance: float


class History:
    """The steps kept so far; their damage lies on disk, each rank's own part, ghosts included."""

    def __init__(self, start: np.ndarray) -> None:
        """start: the damage before the first step."""
        self.steps: list[Past] = []
        self._folder = TemporaryDirectory(prefix="staffa-")
        self._write(0, start)

    def keep(self, loads: Loads, advance: Advance, damage: np.ndarray) -> None:
        """Remember one more step."""
        total = advance.outcome.energies.total
        self.steps.append(
            Past(
                loads=loads,
                total=total,
                loaded=total + advance.released,
                work=advance.work,
                imbalance=advance.imbalance,
            )
        )
        self._write(len(self.steps), damage)

    def drop(self, index: int) -> None:
        """Forget a step and all later ones."""
        del self.steps[index:]

    def damage_before(self, index: int) -> np.ndarray:
        """The damage that bounds a step's from below."""
        return np.load(self._file(index))

    def _write(self, number: int, damage: np.ndarray) -> None:
        np.save(self._file(number), damage)

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
    kept = snapshot(system)
    surface = system.energy.energies().surface
    try:
        for index, past in enumerate(history.steps[:-1]):
            enough = past.total - backtracking.tolerance * abs(past.total)
            if surface >= enough:
                continue
            system.state.T.x.array[:] = temperature(problem, system, past.loads.time)
            equilibrium(system.alternation, past.loads.values)
            found = system.energy.total()
            if found < enough:
                return Better(index=index, found=found)
        return None
    finally:
        restore(system, kept)


def go_back(
    problem: Problem,
    system: System,
    history: History,
    better: Better,
    watch: Callable[[Sweep], None] = lambda sweep: None,
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
    state.alpha.x.array[:] = history.damage_before(better.index)
    state.T.x.array[:] = temperature(problem, system, past.loads.time)
    try:
        outcome, healing = settle(problem, system, past.loads, watch, damage=damage)
    except SolveError:
        restore(system, kept)
        raise
    returned = Return(
        index=len(history.steps) - 1,
        time=last.loads.time,
        before=past.total,
        found=better.found,
    )
    return Advance(
        outcome=outcome,
        healing=healing,
        work=past.work,
        released=past.loaded - outcome.energies.total,
        imbalance=past.imbalance,
        returned=returned,
    )
