"""Times of a run that goes on: those behind stay, and the case may change those ahead."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from staffa.case.rules.time_rules import counts_in
from staffa.case.schema.case import Case
from staffa.errors import InputError
from staffa.evolution.problem import Problem
from staffa.evolution.schedule import Schedule
from staffa.records.manifest import Manifest
from staffa.records.step import Step

# Of the end of a run: times nearer to one another are the same.
SAME_TIME = 1e-9


def schedule_ahead(
    case: Case, setup: Problem, manifest: Manifest, steps: Sequence[Step]
) -> Schedule:
    """The times that were asked for up to the last step, and those of the case from there on.

    Raises
    ------
    InputError
        The case would have had other times up to here.
    """
    plan = setup.schedule
    if not steps:
        return plan
    now, near = steps[-1].time, SAME_TIME * steps[-1].time
    name, clock = f"time.{counts_in(case)}", _clock(steps[-1])
    if (plan.pace is not None) != manifest.adaptive:
        raise InputError(
            f"{name}: steps that adapt and steps that are given cannot follow one another; leave "
            f"them as they are, or begin a new run"
        )
    behind = [(t, r) for t, r in zip(manifest.times, manifest.requested, strict=True) if t <= now]
    asked = [t for t in plan.times if t <= now + near]
    visited = [step.time for step in steps]
    stand = set(_matched(asked, visited, near)) == {True}
    if manifest.adaptive:
        stand = stand and plan.times[-1] >= now - near
    else:
        stand = stand and len(asked) == len(visited)
    if not stand:
        raise InputError(
            f"{name} and output.at: the run has gone to {clock}, and the times up to there cannot "
            f"change; change later ones only"
        )
    ahead = [(t, r) for t, r in zip(plan.times, plan.requested, strict=True) if t > now + near]
    times, requested = zip(*behind, *ahead, strict=True) if behind or ahead else ((), ())
    return Schedule(times=tuple(times), requested=tuple(requested), pace=plan.pace)


def _matched(times: Sequence[float], among: Sequence[float], near: float) -> list[bool]:
    found = np.array(among)
    return [bool(np.any(np.abs(found - time) <= near)) for time in times]


def _clock(step: Step) -> str:
    return f"t = {step.time:.6g}" if step.tau is None else f"tau = {step.tau:.6g}"


def with_times(manifest: Manifest, setup: Problem) -> Manifest:
    """Return the manifest with the times of a problem."""
    plan, tau_of = setup.schedule, setup.tau_of
    return replace(
        manifest,
        times=plan.times,
        taus=tuple(None if tau_of is None else tau_of(t) for t in plan.times),
        requested=plan.requested,
    )
