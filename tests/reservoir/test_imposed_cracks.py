"""Cracks that are given change the production as they should, by sign and by size."""

from pathlib import Path

import numpy as np
import pytest

from support.imposed_cracks import (
    IN_ONE_CELL,
    Produced,
    across,
    channel,
    dead_ends,
    network,
    plan_view,
    produced,
    wall,
)
from support.reservoirs import DAY, YEAR

pytestmark = pytest.mark.slow
DAYS = np.array([5.0, 20.0, 40.0, 60.0]) * DAY
YEARS = np.arange(1.0, 11.0) * YEAR
BREAKTHROUGH = 186.0 + 273.15  # K: a drawdown of 10 %


@pytest.fixture(scope="module")
def bare_wall(darts_python: Path) -> Produced:
    return produced(wall(), [], DAYS, darts_python)


@pytest.fixture(scope="module")
def bare_plan(darts_python: Path) -> Produced:
    return produced(plan_view(), [], YEARS, darts_python)


def test_dead_ends_across_the_flow_change_nothing(bare_wall: Produced, darts_python: Path) -> None:
    found = produced(wall(), dead_ends(1e-3), DAYS, darts_python, IN_ONE_CELL)
    assert np.abs(found.T - bare_wall.T).max() < 0.01
    assert found.drop == pytest.approx(bare_wall.drop, rel=1e-6)


def test_dead_ends_spread_over_two_cells_change_nothing_if_they_are_thin(
    bare_wall: Produced, darts_python: Path
) -> None:
    found = produced(wall(), dead_ends(1e-4), DAYS, darts_python)
    assert np.abs(found.T - bare_wall.T).max() < 0.01


def test_a_connected_network_keeps_the_water_warm(bare_wall: Produced, darts_python: Path) -> None:
    found = produced(wall(), network(3e-4), DAYS, darts_python)
    assert found.T[-1] - bare_wall.T[-1] > 3.0
    assert found.drop < bare_wall.drop


def test_a_channel_brings_breakthrough_earlier_and_takes_less_pressure(
    bare_plan: Produced, darts_python: Path
) -> None:
    found = produced(plan_view(), channel(), YEARS, darts_python)
    assert bare_plan.T[-1] > BREAKTHROUGH
    assert found.T[-2] < BREAKTHROUGH
    assert found.drop < 0.85 * bare_plan.drop


def test_a_crack_across_the_way_at_the_injector_delays_the_cold(
    bare_plan: Produced, darts_python: Path
) -> None:
    found = produced(plan_view(), across(), YEARS, darts_python)
    assert found.T[-1] - bare_plan.T[-1] > 1.0
    assert found.drop < bare_plan.drop
