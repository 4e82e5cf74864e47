"""The times that a run visits: those asked for are hit exactly, each time once, in order."""

from dataclasses import replace

import numpy as np
import pytest

from staffa.evolution.schedule import SAFETY, AdaptiveSteps, Pace, Schedule, schedule

THIRDS = tuple(np.linspace(0.1, 0.7, 7))  # 0.30000000000000004 and the like
ASKED = (0.3, 0.7)


def test_requested_times_are_hit_to_the_last_digit() -> None:
    found = schedule(THIRDS, ASKED)
    assert set(ASKED) <= set(found.times), f"{found.times} lacks some of {ASKED}"
    assert len(found.times) == len(THIRDS), f"{found.times}: a time and its near copy"


def test_a_time_between_the_others_is_put_in_its_place() -> None:
    found = schedule((1.0, 2.0, 3.0), (2.5, 0.5))
    assert found.times == (0.5, 1.0, 2.0, 2.5, 3.0)
    assert found.requested == (True, False, False, True, False)


def test_times_come_in_increasing_order_however_they_are_given() -> None:
    found = schedule((3.0, 1.0, 2.0), (2.7, 0.3))
    assert found.times == tuple(sorted(found.times)) and len(found.times) == 5


@pytest.mark.parametrize(("gap", "visited"), [(0.9e-9, 2), (1.1e-9, 3)])
@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e9])
def test_only_times_within_1e_9_of_themselves_are_the_same(
    gap: float, visited: int, sign: int, scale: float
) -> None:
    """Relative to the time, and not to the last one: a run of years may begin by the second."""
    asked = 2.0 * scale
    found = schedule((asked * (1 + sign * gap), 10.0 * scale), (asked,))
    assert len(found.times) == visited, f"{len(found.times)} times of a gap {gap}: {found.times}"
    assert asked in found.times and found.times[-1] == 10.0 * scale
    assert found.requested == tuple(t == asked for t in found.times)


def test_the_first_second_of_thirty_years_is_told_apart() -> None:
    found = schedule((1.0, 9.5e8), (1.5, 2.0))
    assert found.times == (1.0, 1.5, 2.0, 9.5e8)


def test_without_requests_nothing_is_kept_and_nothing_merged() -> None:
    found = schedule((1.0, 1.0 + 1e-12, 2.0))
    assert found.times == (1.0, 1.0 + 1e-12, 2.0) and found.requested == (False,) * 3


def pace(**changes) -> Pace:
    """Between .01 and .1 long, cracks running .05 at most."""
    return replace(Pace(shortest=0.01, longest=0.1, advance=0.05), **changes)


def walked(plan: Schedule, ran, most: int = 1000) -> list[tuple[float, float]]:
    """(start, end) of the accepted steps, if in a step from a to b cracks run ran(a, b)."""
    walk, found, tries = AdaptiveSteps(plan), [], 0
    while (time := walk.next()) is not None:
        tries += 1
        assert tries < most, "it comes to an end"
        start = walk.start or 0.0
        far = ran(start, time)
        if walk.goes_too_far(far):
            nearer = walk.next()
            assert start < nearer < time
            continue
        found.append((start, time))
        walk.onward(time, far)
    return found


def test_without_a_pace_only_the_times_given_are_visited_whatever_cracks_do() -> None:
    plan = schedule((1.0, 2.0, 3.0), (2.5,))
    assert [end for _, end in walked(plan, lambda a, b: 100.0)] == [1.0, 2.0, 2.5, 3.0]


def test_every_time_of_the_schedule_is_hit_to_the_last_digit_at_any_pace() -> None:
    plan = schedule((0.1, 0.7), (0.3, 1 / 3), pace())
    ends = [end for _, end in walked(plan, lambda a, b: 0.4 * (b - a))]
    assert {0.1, 0.3, 1 / 3, 0.7} <= set(ends) and ends[-1] == 0.7
    assert ends == sorted(ends)


def test_steps_are_as_long_as_cracks_allow() -> None:
    """Cracks of speed 1 may run .05 a step: steps settle where they run SAFETY of it."""
    plan = schedule((1.0, 3.0), pace=pace())
    steps = np.array([b - a for a, b in walked(plan, lambda a, b: b - a)])[1:]
    assert steps[:-2].max() <= 0.05 * (1 + 1e-9), f"{steps} exceed the advance"
    assert steps[2:-2] == pytest.approx(SAFETY * 0.05, rel=1e-6), f"{steps} do not settle"


def test_steps_stay_between_floor_and_ceiling() -> None:
    plan = schedule((1.0, 3.0), pace=pace())
    still = np.array([b - a for a, b in walked(plan, lambda a, b: 0.0)])[1:]
    assert still.max() == pytest.approx(0.1), "no crack runs: as long as may be"
    wild = np.array([b - a for a, b in walked(plan, lambda a, b: np.inf)])[1:]
    assert wild[:-1] == pytest.approx(0.01), "one that cannot be shortened stands"


def test_the_cold_grows_by_no_more_than_its_fraction_in_a_step() -> None:
    """On the clock sqrt(t), as tau is, steps are in proportion to it."""
    root = pace(growth=0.2, clock=np.sqrt, time_at=np.square, shortest=1e-3, longest=1.0)
    steps = walked(schedule((0.01, 1.0), pace=root), lambda a, b: 0.0)[1:]
    growth = np.array([np.sqrt(b / a) - 1 for a, b in steps])
    assert growth.max() <= 0.2 * (1 + 1e-9) and growth[:-2] == pytest.approx(0.2)


def test_a_jump_of_cracks_is_closed_in_on_down_to_the_shortest_step() -> None:
    """Cracks start at 2.345: the step that holds it is the shortest, as any finite jump."""
    plan = schedule((1.0, 3.0), pace=pace())
    steps = walked(plan, lambda a, b: np.inf if a < 2.345 <= b else 0.0)
    (jump,) = [b - a for a, b in steps if a < 2.345 <= b]
    assert jump == pytest.approx(0.01)
    assert max(b - a for a, b in steps[1:]) == pytest.approx(0.1), "longer again before and after"


@pytest.mark.parametrize("start", [1e-3, 1.0, 200 * 86400 + 0.3])
@pytest.mark.parametrize("shortest", [0.3, 0.1, 0.01])
def test_a_shortest_step_stands_however_late_it_is(start: float, shortest: float) -> None:
    """The difference of two late times is not what it was meant to be, to the last digit."""
    plan = schedule((start, start + 1.7), pace=pace(shortest=shortest, longest=0.5))
    steps = [b - a for a, b in walked(plan, lambda a, b: np.inf)]
    assert steps[1:-2] == pytest.approx([shortest] * len(steps[1:-2]), rel=1e-6)


def test_a_crack_that_runs_just_as_far_as_it_may_is_no_matter_of_round_off() -> None:
    walk = AdaptiveSteps(schedule((1.0, 3.0), pace=pace(advance=6 * 0.01)))
    walk.onward(walk.next(), 0.0)
    for cell in range(100):
        depths = [0.01 * (cell + k) for k in (0, 6)]
        walk.next()
        assert not walk.goes_too_far(depths[1] - depths[0]), f"rejected at {depths}"
    assert walk.goes_too_far(7 * 0.01)


def test_a_run_that_starts_at_zero_is_walked_like_any_other() -> None:
    steps = walked(schedule((0.0, 2.0), pace=pace()), lambda a, b: np.inf if b > 0 else 0.0)
    assert [b - a for a, b in steps[1:-2]] == pytest.approx([0.01] * (len(steps) - 3))


def test_a_step_is_halved_before_a_time_only_if_both_halves_are_long_enough() -> None:
    plan = schedule((1.0, 2.5), pace=pace(shortest=1.0, longest=1.0))
    assert [end for _, end in walked(plan, lambda a, b: 0.0)] == [1.0, 2.0, 2.5]
    plan = schedule((1.0, 2.5), pace=pace(shortest=0.1, longest=1.0))
    assert [end for _, end in walked(plan, lambda a, b: 0.0)] == [1.0, 1.75, 2.5]


def test_after_going_back_steps_are_short_again() -> None:
    walk = AdaptiveSteps(schedule((1.0, 3.0), pace=pace()))
    for _ in range(3):
        walk.onward(walk.next(), 0.0)
    walk.back(1.05)
    assert walk.next() == pytest.approx(1.06)
