"""The times that a run visits: those asked for are hit exactly, each time once, in order."""

import numpy as np
import pytest

from staffa.evolution.schedule import schedule

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
def test_only_times_within_1e_9_of_the_whole_are_the_same(
    gap: float, visited: int, sign: int, scale: float
) -> None:
    """Relative to the last time, 10 here, and not to the time itself."""
    asked = 2.0 * scale
    found = schedule((asked + sign * gap * 10.0 * scale, 10.0 * scale), (asked,))
    assert len(found.times) == visited, f"{len(found.times)} times of a gap {gap}: {found.times}"
    assert asked in found.times and found.times[-1] == 10.0 * scale
    assert found.requested == tuple(t == asked for t in found.times)


def test_the_whole_goes_to_the_last_time_also_if_that_is_a_requested_one() -> None:
    found = schedule((2.0 + 5e-9,), (2.0, 10.0))
    assert found.times == (2.0, 10.0) and found.requested == (True, True)


def test_without_requests_nothing_is_kept_and_nothing_merged() -> None:
    found = schedule((1.0, 1.0 + 1e-12, 2.0))
    assert found.times == (1.0, 1.0 + 1e-12, 2.0) and found.requested == (False,) * 3
