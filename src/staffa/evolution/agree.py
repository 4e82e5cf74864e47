"""Agreement of temperature and cracks at the end of a step, each of which changes the other."""

from dataclasses import replace

import numpy as np

from staffa.backend.parallel import max_over_ranks
from staffa.errors import SolveError
from staffa.evolution.advanced_step import Advance
from staffa.evolution.apply_loads import put_on
from staffa.evolution.coupling import ThermalState
from staffa.evolution.equilibrate import Loads, descend, raise_bounds
from staffa.evolution.problem import Problem
from staffa.evolution.system import System
from staffa.minimize.alternate import Watch
from staffa.model.fields import owned
from staffa.records.step import Heat


def agree(
    problem: Problem,
    system: System,
    end: Loads,
    advance: Advance,
    watch: Watch = lambda sweep: None,
) -> Advance:
    """Repeat the step's temperature with the cracks that it led to, and minimize again, until it no
    longer changes. Nothing is done where cracks do not change it. Collective.

    Cracks that a pass has made stay, as in time they would: otherwise cracks and temperatures come
    and go by turns, each the other's cause. They only grow then, and that ends.

    Raises
    ------
    SolveError
        They do not agree within the limit of passes: in too long a step cracks run ahead of
        the thermal boundary layer.
    """
    coupling, origin = system.coupling, advance.origin
    rule = coupling.agreement
    if rule is None:
        return advance
    passes, gap, spent = 0, np.inf, 0.0
    while advance.outcome.converged:
        thermal, heat = coupling.advance(origin.thermal, system.cracks, origin.time, end.time)
        gap = _gap(system, origin.thermal, thermal)
        if gap <= rule.tolerance:
            spent = heat.seconds if heat else 0.0
            break
        if passes == rule.passes:
            changed = "temperature" if thermal.p is None else "temperature or pressure"
            raise SolveError(
                f"the {changed} and the cracks that change it still differ by {gap:.1g} of its "
                f"change after {passes} passes; take shorter time steps, or a larger {rule.key}"
            )
        raise_bounds(problem.irreversibility, system)
        loading = put_on(problem, system, thermal, end.values, end)
        outcome, healing = descend(problem, system, end, watch)
        advance, passes = advance.again(outcome, healing, loading, heat), passes + 1
    kept = advance.heat or Heat()
    return replace(
        advance, heat=replace(kept, passes=passes, gap=gap, seconds=kept.seconds + spent)
    )


def _gap(system: System, before: ThermalState, after: ThermalState) -> float:
    """Return the largest difference of a thermal state to the current one, of temperatures and of
    pressures, over the largest change of each since t = 0. Collective.

    The change is that of the step, and not of its end alone, where it may be the first one again.
    """
    coupling, state = system.coupling, system.state
    comm = state.T.function_space.mesh.comm
    n = len(owned(state.T))

    def part(apart: np.ndarray, change: float) -> float:
        return max_over_ranks(comm, np.abs(apart[:n])) / (change or 1.0)

    change = max(coupling.span(before), coupling.span(after))
    gap = part(after.T - state.T.x.array, change)
    if before.p is None or after.p is None:
        return gap
    rest = system.energy.external.p_at_rest.x.array
    change = max(max_over_ranks(comm, np.abs(p - rest)) for p in (before.p, after.p))
    return max(gap, part(after.p - state.p.x.array, change))
