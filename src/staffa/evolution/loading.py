"""New loads on frozen cracks, and the account of their work."""

from dataclasses import dataclass, replace

import numpy as np

from staffa.errors import LoadError
from staffa.evolution.problem import Problem
from staffa.evolution.settle import Loads
from staffa.evolution.system import System
from staffa.minimize.alternate import equilibrium, reactions
from staffa.parallel import any_over_ranks, sum_over_ranks
from staffa.records import Heat


@dataclass(frozen=True, kw_only=True)
class Loading:
    """What changing the loads did with the cracks frozen.

    work: of the temperature change and of the prescribed displacements, both along the straight
    path from the loads before; exact for elasticity. start, end: total energies. heat: what the
    heat equation did, if it gives the temperature.
    """

    work: float
    start: float
    end: float
    heat: Heat | None = None


def change_loads(problem: Problem, system: System, start: Loads, end: Loads) -> Loading:
    """Put on the loads of a time with the cracks frozen, and account for the work. Collective.

    Raises
    ------
    LoadError
        The temperature or a prescribed displacement is not finite.
    """
    state = system.state
    if any_over_ranks(problem.domain.comm, not np.all(np.isfinite(end.values))):
        raise _not_finite("displacement", end.time)
    T, heat = system.cooling.advance(
        state.T.x.array.copy(), state.alpha.x.array, start.time, end.time
    )
    return replace(put_on(problem, system, T, start.values, end), heat=heat)


def put_on(
    problem: Problem, system: System, T: np.ndarray, before: np.ndarray, end: Loads
) -> Loading:
    """The same with a temperature change (K) that is known, ghosts included. Collective.

    before: the prescribed displacements (m) at hand, shape (n_fixed,).
    """
    energy, state, parts = system.energy, system.state, system.alternation
    if any_over_ranks(problem.domain.comm, not np.all(np.isfinite(T))):
        raise _not_finite("temperature", end.time)

    def power() -> float:
        of_supports = float(reactions(parts) @ (end.values - before))
        return energy.thermal_power() + sum_over_ranks(problem.domain.comm, of_supports)

    energy.direction.x.array[:] = T - state.T.x.array
    at_first, power_before = energy.total(), power()
    state.T.x.array[:] = T
    equilibrium(parts, end.values)
    return Loading(work=(power_before + power()) / 2, start=at_first, end=energy.total())


def _not_finite(what: str, time: float) -> LoadError:
    return LoadError(
        f"the load gives a {what} that is not finite at time {time:.6g}; mend the load"
    )
