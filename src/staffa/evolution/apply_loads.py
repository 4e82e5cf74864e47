"""New loads on frozen cracks, and the balance of their work."""

from dataclasses import dataclass, replace

import numpy as np

from staffa.backend.parallel import any_over_ranks, sum_over_ranks
from staffa.errors import LoadError
from staffa.evolution.coupling import ThermalState
from staffa.evolution.equilibrate import Loads
from staffa.evolution.load_path import Path, power_of_loads
from staffa.evolution.problem import Problem
from staffa.evolution.system import System
from staffa.minimize.alternate import equilibrium, support_reactions
from staffa.records.step import CANCELED, Heat

# To which the work is found with a split, over the energy.
ACCURACY = 3e-6


@dataclass(frozen=True, kw_only=True)
class Loading:
    """Result of a change of the loads with frozen cracks.

    The work is taken along the straight path from the loads before: by the power at its ends, which
    is exact without a split, and with one by that between them too (see `evolution.load_path`).
    Where properties depend on temperature, the path has two legs: first temperature and loads
    change, then the displacement. The work of the first is the change of energy that they make by
    themselves, dE/dT and dGc/dT integrated; along the second the energy is as before.

    Attributes
    ----------
    work : work of the temperature change, of the prescribed displacements and of external loads.
    start, end : total energies.
    heat : account of heat; None where the coupling keeps none.
    spread : size of the terms that these energies are differences of, see `ElasticSolver.spread`.
    """

    work: float
    start: float
    end: float
    heat: Heat | None = None
    spread: float = 0.0


def change_loads(problem: Problem, system: System, start: Loads, end: Loads) -> Loading:
    """Apply the loads of a time with frozen cracks, and return the work. Collective.

    Parameters
    ----------
    problem : the problem.
    system : its system.
    start : loads before.
    end : loads after.

    Raises
    ------
    LoadError
        The temperature, a prescribed displacement or an external load is not finite.
    """
    if any_over_ranks(problem.domain.comm, not np.all(np.isfinite(end.values))):
        raise _not_finite("displacement", end.time)
    system.energy.book()  # at the toughness that the cracks met
    before = system.thermal.read()
    thermal, heat = system.coupling.advance(before, system.cracks, start.time, end.time)
    return replace(put_on(problem, system, thermal, start.values, end), heat=heat)


def put_on(
    problem: Problem, system: System, thermal: ThermalState, before: np.ndarray, end: Loads
) -> Loading:
    """The same with a temperature that is known. Collective.

    thermal: the state to put on. before: the prescribed displacements (m) of now, shape
    (n_fixed,).
    """
    energy, state, parts = system.energy, system.state, system.alternation
    comm = problem.domain.comm
    if any_over_ranks(comm, not np.all(np.isfinite(thermal.T))):
        raise _not_finite("temperature", end.time)
    if any_over_ranks(comm, thermal.p is not None and not np.all(np.isfinite(thermal.p))):
        raise _not_finite("pressure", end.time)
    start_time = energy.external.time

    def power() -> float:
        of_supports = float(support_reactions(parts) @ (end.values - before))
        return (
            energy.thermal_power()
            + power_of_loads(energy, start_time, end.time)
            + sum_over_ranks(comm, of_supports)
        )

    energy.direction.x.array[:] = thermal.T - state.T.x.array
    if thermal.p is not None:
        energy.pressing.x.array[:] = thermal.p - state.p.x.array
    lawful = bool(energy.of_temperature)
    path = None if energy.linear or lawful else Path(energy, parts)
    at_first, first, u = energy.total(), 0.0 if lawful else power(), parts.u.copy()
    system.thermal.put(thermal)
    energy.external.at(end.time)
    if any_over_ranks(comm, not energy.external.is_finite()):
        raise _not_finite("force", end.time)
    put = 0.0
    if lawful:  # temperature and loads first, which alone changes the energy by `put`
        put, path = energy.total() - at_first, Path(energy, parts)
        start_time = end.time
        energy.direction.x.array[:] = energy.pressing.x.array[:] = 0.0
    equilibrium(parts, end.values)
    at_last, last = energy.total(), power()
    if lawful and path is not None:
        first = path.slope_at_start()
    work, spread = put + (first + last) / 2, max(map(parts.elastic.spread, (u, parts.u)))
    u.destroy()
    if path is not None and not energy.linear:
        scale = max(abs(at_first), abs(at_last), energy.energies().scale, CANCELED * spread)
        work += path.bend(accuracy=ACCURACY * scale)
    return Loading(work=work, start=at_first, end=at_last, spread=spread)


def _not_finite(what: str, time: float) -> LoadError:
    return LoadError(f"the load gives a {what} that is not finite at time {time:.6g}; fix the load")
