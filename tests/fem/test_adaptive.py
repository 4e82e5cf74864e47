"""Steps that follow the cracks: none runs too far in one, and what was tried leaves no trace."""

from dataclasses import replace

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from fem.test_backtrack import front
from staffa.evolution.march import march
from staffa.evolution.problem import Measuring, Problem
from staffa.evolution.schedule import Pace, schedule
from staffa.evolution.system import build
from staffa.measure.growth import crack_advance
from staffa.model.fields import vertices
from staffa.model.supports import SideSupport, no_displacement
from staffa.physics.scales import tau_of_time, time_of_tau
from staffa.records.step import kept
from support.bodies import body, quench, rock, run

ELL, H = 0.1, 0.05
SHORTEST, LONGEST, ADVANCE = 0.005, 0.1, 2.5 * ELL


def tau(time: float) -> float:
    """With kappa = L = 1."""
    return tau_of_time(time, kappa=1.0, L=1.0)


def time_at(clock: float) -> float:
    """The inverse of tau."""
    return time_of_tau(clock, kappa=1.0, L=1.0)


def plate(**more) -> Problem:
    """A cooled cell, held at its sides, whose face cracks at tau = .12; two times are asked for."""
    sides = tuple(
        SideSupport(side=side, components={0: no_displacement}) for side in ("left", "right")
    )
    pace = Pace(
        shortest=SHORTEST, longest=LONGEST, advance=ADVANCE, growth=0.5, clock=tau, time_at=time_at
    )
    plan = schedule([time_at(0.05), time_at(0.4)], [time_at(0.17), time_at(0.3)], pace)
    return body(
        (0.55, 1.0),
        H,
        load=quench(8.0),
        material=rock(ell=ELL),
        sides=sides,
        times=plan,
        tau_of=tau,
        measuring=Measuring(threshold=0.8),
        **more,
    )


def test_no_accepted_step_runs_too_far_unless_it_is_the_shortest() -> None:
    problem = plate()
    system, found = build(problem), []
    before, at = np.zeros(len(system.state.alpha.x.array)), 0.05
    rejected = 0
    for step in march(problem, system):
        if step.status == "rejected":
            rejected += 1
            assert "taken again, shorter" in step.reason and step.fields is None
            continue
        ran = crack_advance(system.state, before, threshold=0.8)
        if step.index:
            found.append((step.tau - at, ran))
        before, at = system.state.alpha.x.array.copy(), step.tau
    system.destroy()
    assert rejected, "nothing was rejected: the test sees nothing"
    assert max(length for length, _ in found) <= LONGEST + 1e-9
    far = [(length, ran) for length, ran in found if ran > ADVANCE]
    assert [length for length, _ in far] == pytest.approx([SHORTEST] * len(far), rel=0.2), far
    assert any(0 < ran <= ADVANCE for _, ran in found), "cracks ran in no step that may stand"


def test_requested_times_are_hit_and_rejected_steps_are_no_part_of_the_run() -> None:
    steps = run(plate())
    assert any(step.status == "rejected" for step in steps)
    standing = kept(steps)
    assert [step.index for step in standing] == list(range(len(standing)))
    assert all(step.status == "converged" for step in standing)
    assert {time_at(0.17), time_at(0.3)} <= {step.time for step in standing}
    assert standing[-1].time == time_at(0.4)


def test_what_was_rejected_leaves_no_trace() -> None:
    """A run at just the times that were accepted, with none rejected, has the same energies."""
    standing = kept(run(plate()))
    problem = plate()

    plain = replace(problem, schedule=schedule([step.time for step in standing]))
    expected = [step.energies.total for step in run(plain)]
    assert [step.energies.total for step in standing] == pytest.approx(expected, rel=1e-9)
    assert all(step.audit.violations == () for step in standing)


def test_steps_follow_the_cracks_also_after_going_back() -> None:
    pace = Pace(
        shortest=0.004, longest=0.05, advance=0.5, growth=0.5, clock=np.sqrt, time_at=np.square
    )
    steps = run(replace(front(), schedule=schedule([0.05**2, 0.4**2], pace=pace)))
    standing = kept(steps)
    assert any(step.returned for step in steps), "it never went back: the test sees nothing"
    assert any(step.status == "rejected" for step in steps)
    assert [step.index for step in standing] == list(range(len(standing)))
    times = [step.time for step in standing]
    assert times == sorted(times) and times[-1] == 0.4**2


def test_the_advance_is_the_way_from_the_cracks_there_were() -> None:
    system = build(plate())
    state = system.state
    x = vertices(state.alpha.function_space)
    before = np.where((x[:, 0] < 0.1) & (x[:, 1] < 0.31), 1.0, 0.0)
    state.alpha.x.array[:] = before
    assert crack_advance(state, before, threshold=0.8) == 0.0
    state.alpha.x.array[(x[:, 0] < 0.1) & (x[:, 1] < 0.51)] = 0.9
    assert crack_advance(state, before, threshold=0.8) == pytest.approx(0.2)
    assert crack_advance(state, before, threshold=0.95) == 0.0, "not yet a crack"
    assert crack_advance(state, np.zeros_like(before), threshold=0.8) == np.inf, "it starts"
    system.destroy()
