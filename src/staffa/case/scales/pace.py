"""Case -> Schedule: the times that a run visits, and how long steps between them are."""

from functools import partial
from typing import Any

from staffa.case.rules import adaptive
from staffa.case.scales.case_scales import Numbers
from staffa.case.scales.knots import Knots, knots
from staffa.case.scales.prescribed import curves, visited_times
from staffa.case.schema.case import Case
from staffa.evolution.schedule import FROM_THE_START, Pace, Schedule, schedule
from staffa.physics.scales import tau_of_time, time_of_tau


def plan(case: Case, derived: Numbers) -> Schedule:
    """Return the times of a case, those of its outputs, and how steps between them are chosen."""
    return schedule(derived.times, derived.requested, pace(case, derived))


def pace(case: Case, derived: Numbers) -> Pace | None:
    """Return the rule for the length of adaptive time steps; None if times are given."""
    keys = adaptive(case)
    if keys is None:
        return None
    clock: dict[str, Any] = {}
    if case.time.tau is not None:
        scale = {"kappa": derived.kappa, "L": derived.L}
        clock = {
            "clock": partial(tau_of_time, **scale),
            "time_at": partial(time_of_tau, **scale),
        }
    found = prescribed_knots(case)
    heated = [told for where, told in found.items() if where.startswith("heat.")]
    return Pace(
        shortest=float(keys.shortest),
        longest=float(keys.longest),
        advance=keys.advance * float(case.damage.ell),
        growth=keys.growth if derived.cooled or case.reservoir is not None else None,
        knots=tuple(sorted({t for told in found.values() for t in told.times.tolist() if t > 0})),
        onsets=(FROM_THE_START, *sorted(onset for told in heated for onset in told.onsets)),
        **clock,
    )


def prescribed_knots(case: Case) -> dict[str, Knots]:
    """Return the knots of each prescribed value that changes in time, by its key."""
    visited = visited_times(case).tolist()
    found = ((c.where, knots(c.t, c.values, through=visited)) for c in curves(case))
    return {where: told for where, told in found if told is not None}
