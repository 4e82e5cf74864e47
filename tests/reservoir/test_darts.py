"""The real simulator: a pure function of its state, balances, and closed forms."""

import os
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from staffa.records.circulation import Circulation
from staffa.reservoir.darts import Darts
from staffa.reservoir.grid import grid_around
from staffa.reservoir.interpreter import answers
from staffa.reservoir.simulator import Flow, ReservoirModel, Well
from staffa.reservoir.single import SingleFracture
from support.reservoirs import BOTTOM, COLD, DAY, ROCK, YEAR, fracture_wall, reservoir

GRAVITY = 9.81


@contextmanager
def simulator_of(model: ReservoirModel, python: Path) -> Iterator[Darts]:
    """Give the simulator, and end its process."""
    simulator = Darts(model, python)
    try:
        yield simulator
    finally:
        simulator.close()


def doublet(**changes: Any) -> ReservoirModel:
    """Return a plan view with two wells in permeable rock."""
    grid = grid_around((0.0, 0.0), (300.0, 200.0), 20.0, thickness=50.0)
    wells = [
        Well(name="in", cells=(grid.cell_at((90.0, 100.0)),), rate=5.0, T=COLD),
        Well(name="out", cells=(grid.cell_at((210.0, 100.0)),), pressure=20e6),
    ]
    return reservoir(grid, wells, permeability=5e-14, porosity=0.1, **changes)


def bits(flow: Flow) -> tuple[bytes, bytes, bytes]:
    return flow.hidden.tobytes(), flow.T.tobytes(), flow.p.tobytes()


def to_times(
    simulator: Darts | SingleFracture, times: Sequence[float]
) -> Iterator[tuple[Flow, Circulation]]:
    """Give state and account of each time (s), from a start at rest."""
    flow, now = simulator.start(), 0.0
    for t in times:
        flow, account, _ = simulator.advance(flow, None, t - now)
        now = t
        yield flow, account


def test_it_answers_with_its_version(darts_python: Path) -> None:
    assert answers(darts_python) == "open-darts 2.0.0"


@pytest.mark.parametrize("water", ["constant", "iapws"])
def test_the_same_state_gives_the_same_bits_also_in_another_process(
    darts_python: Path, water: str
) -> None:
    model = doublet() if water == "constant" else doublet(water=None)
    other_k = model.permeability * np.linspace(0.5, 2.0, model.grid.size)
    with simulator_of(model, darts_python) as one:
        start = one.start()
        first, _, _ = one.advance(start, None, 90 * DAY)
        second, account, steps = one.advance(first, other_k, 30 * DAY)
        one.advance(first, None, 700 * DAY)  # another trial
        again, its, _ = one.advance(first, other_k, 30 * DAY)
        assert bits(again) == bits(second) and its == account
        assert bits(one.start()) == bits(start)
    with simulator_of(model, darts_python) as other:
        after, its, n = other.advance(first, other_k, 30 * DAY)
        assert bits(after) == bits(second) and its == account and n == steps


@pytest.mark.parametrize("water", ["constant", "iapws"])
def test_wells_bring_what_the_reservoir_gains(darts_python: Path, water: str) -> None:
    model = doublet() if water == "constant" else doublet(water=None)
    with simulator_of(model, darts_python) as simulator:
        total = None
        for _, account in to_times(simulator, [30 * DAY, 365 * DAY, 4 * YEAR]):
            assert account.imbalance < 1e-7
            brought = sum(well.mass for well in account.wells.values())
            assert abs(brought - account.mass_stored) < 1e-7 * account.wells["in"].mass
            total = account if total is None else total.then(account)
    assert total is not None
    # The rate that was asked for, once the well itself is full of cold water.
    assert total.wells["in"].mass == pytest.approx(5.0 * 4 * YEAR, rel=1e-3)
    assert account.wells["in"].mass == pytest.approx(5.0 * account.duration, rel=1e-6)
    assert abs(account.wells["in"].T - COLD) < 1e-3
    assert COLD < account.wells["out"].T < ROCK
    shrinks = -total.wells["out"].mass / total.wells["in"].mass
    assert shrinks == pytest.approx(1.0, abs=1e-6) if water == "constant" else shrinks < 0.99


def test_a_given_rate_of_production_is_kept(darts_python: Path) -> None:
    model = doublet()
    first, last = model.wells
    pair = [replace(first, rate=None, pressure=21e6), replace(last, rate=-4.0, pressure=None)]
    with simulator_of(replace(model, wells=pair), darts_python) as simulator:
        *_, (_, account) = to_times(simulator, [30 * DAY, 60 * DAY])
    assert account.wells["out"].mass == pytest.approx(-4.0 * 30 * DAY, rel=1e-6)
    assert account.wells["in"].pressure == pytest.approx(21e6, abs=200.0)  # at the well head
    assert account.imbalance < 1e-7


def test_the_pressure_between_wells_is_that_of_two_line_sources(darts_python: Path) -> None:
    beyond = dict.fromkeys([(0, -1), (0, 1), (1, -1), (1, 1)], 8000.0)
    grid = grid_around((0.0, 0.0), (475.0, 475.0), 19.0, thickness=100.0, beyond=beyond)
    wells = [
        Well(name="in", cells=(grid.cell_at((0.1, 237.5)),), rate=50.0, T=ROCK),
        Well(name="out", cells=(grid.cell_at((474.9, 237.5)),), rate=-50.0),
    ]
    water = replace(reservoir(grid, []).water, mu=2e-4)
    model = reservoir(grid, wells, permeability=1e-13, porosity=0.1, water=water)
    with simulator_of(model, darts_python) as simulator:
        *_, (_, account) = to_times(simulator, [10 * DAY, 11 * DAY])
    places = grid.centers[[well.cells[0] for well in wells], 0]
    # mu Q/(pi k h) ln(D/rw)
    exact = 2e-4 * 0.05 / (np.pi * 1e-13 * 100.0) * np.log(np.ptp(places) / 0.1)
    drop = account.wells["in"].pressure - account.wells["out"].pressure
    assert drop == pytest.approx(exact, rel=0.01)


def test_the_pressure_along_a_fracture_is_that_of_the_cubic_law(darts_python: Path) -> None:
    with simulator_of(fracture_wall(cells=20, T=COLD), darts_python) as simulator:
        *_, (flow, account) = to_times(simulator, [1 * DAY, 2 * DAY])
    drop = account.wells["in"].pressure - account.wells["out"].pressure
    assert drop == pytest.approx(12 * 3e-4 * 60.0 * 2e-5 / 2e-4**3, rel=1e-6)
    closed = SingleFracture(replace(fracture_wall(cells=20), T=np.full(flow.T.size, ROCK)))
    row, (driven, *_) = closed.row, closed.advance(closed.start(), None, DAY)
    assert flow.p[row] == pytest.approx(driven.p[row], abs=10.0)


@pytest.mark.slow
def test_parallel_fractures_produce_what_gringarten_says(darts_python: Path) -> None:
    times = [20 * DAY, 40 * DAY, 60 * DAY, 100 * DAY, 160 * DAY]
    exact = [190.85, 173.04, 159.70, 141.25, 121.12]
    model = fracture_wall(60.0, 5.0, q=2e-5, cells=180, opening=1e-3)
    with simulator_of(model, darts_python) as simulator:
        for value, (_, account) in zip(exact, to_times(simulator, times), strict=True):
            assert abs(account.wells["out"].T - 273.15 - value) < 0.6
            assert account.imbalance < 1e-7


@pytest.mark.slow
def test_a_wall_cools_as_lauwerier_says(darts_python: Path) -> None:
    times = [60 * DAY, 150 * DAY, 365 * DAY]
    made = fracture_wall(60.0, 55.0, q=2e-5, cells=120, opening=1e-3, h=2.0)
    closed = SingleFracture(made)
    with simulator_of(made, darts_python) as simulator:
        pairs = zip(to_times(simulator, times), to_times(closed, times), strict=True)
        for (flow, account), (exact, its) in pairs:
            assert abs(account.wells["out"].T - its.wells["out"].T) < 1.5
            wall = made.grid.row(BOTTOM)
            assert np.abs(flow.T - exact.T)[wall].mean() < 0.01 * (ROCK - COLD)
            exact_heat = its.wells["in"].heat + its.wells["out"].heat
            assert account.heat_stored == pytest.approx(exact_heat, rel=0.01)


def test_new_permeability_is_that_of_a_model_made_with_it(darts_python: Path) -> None:
    model = doublet()
    channel = np.where(np.abs(model.grid.centers[:, 1] - 100.0) < 20.0, 20.0, 1.0)
    k = model.permeability * channel
    with simulator_of(model, darts_python) as simulator:
        start = simulator.start()
        changed, account, _ = simulator.advance(start, k, 200 * DAY)
        plain, _, _ = simulator.advance(start, None, 200 * DAY)
    with simulator_of(replace(model, permeability=k), darts_python) as simulator:
        made, its, _ = simulator.advance(simulator.start(), None, 200 * DAY)
    assert bits(made) == bits(changed) and its == account
    assert np.abs(plain.T - changed.T).max() > 5.0


@pytest.mark.parametrize("gravity", [(0.0, -GRAVITY), (6.0, -7.0), (0.0, 0.0, GRAVITY)])
def test_water_at_rest_stays_at_rest(darts_python: Path, gravity: tuple[float, ...]) -> None:
    dim = len(gravity)
    grid = grid_around((0.0,) * dim, (50.0, 40.0, 30.0)[:dim], 10.0)
    down = np.array([*gravity, 0.0][:3])
    p = 20e6 + 1000.0 * grid.nodes @ down
    model = reservoir(
        grid, [], permeability=1e-13, porosity=0.1, p=p, gravity=tuple(map(float, down))
    )
    with simulator_of(model, darts_python) as simulator:
        *_, (flow, _) = to_times(simulator, [100 * DAY])
    assert flow.p == pytest.approx(p, abs=0.1)
    assert np.abs(flow.T - ROCK).max() < 1e-9


def test_warm_water_rises(darts_python: Path) -> None:
    grid = grid_around((0.0, 0.0), (100.0, 100.0), 10.0)
    x, y = grid.nodes[:, 0], grid.nodes[:, 1]
    T = ROCK - 80.0 * (np.abs(x - 50.0) < 20.0) * (y > 70.0)
    p = 20e6 - 880.0 * GRAVITY * y
    model = reservoir(
        grid, [], permeability=1e-12, porosity=0.3, p=p, T=T, water=None,
        gravity=(0.0, -GRAVITY, 0.0),
    )  # fmt: skip
    with simulator_of(model, darts_python) as simulator:
        *_, (flow, _) = to_times(simulator, [3 * YEAR])

    def height(field: np.ndarray) -> float:
        lacking = ROCK - field
        return float((lacking * y).sum() / lacking.sum())

    assert height(flow.T) < height(T) - 5.0


def killed_while(act: Callable[[], Any], pid: int, after: float) -> Any:
    """Return what a call returns during which a process is killed."""
    timer = threading.Timer(after, os.kill, (pid, 9))
    timer.start()
    try:
        return act()
    finally:
        timer.cancel()


def test_a_killed_process_leaves_no_trace_in_the_numbers(darts_python: Path) -> None:
    model = doublet()
    with simulator_of(model, darts_python) as simulator:
        first, _, _ = simulator.advance(simulator.start(), None, 90 * DAY)
        second, account, _ = simulator.advance(first, None, 900 * DAY)
        assert simulator.child is not None
        os.kill(simulator.child.process.pid, 9)
        again, its, _ = simulator.advance(first, None, 900 * DAY)
        assert bits(again) == bits(second) and its == account
        pid = simulator.child.process.pid
        again, its, _ = killed_while(
            lambda: simulator.advance(first, None, 900 * DAY), pid, after=0.05
        )
        assert simulator.child.process.pid != pid
        assert bits(again) == bits(second) and its == account


def test_smaller_tolerance_takes_more_steps_to_a_closer_result(darts_python: Path) -> None:
    found = {}
    for tolerance in (1e-2, 1e-3, 1e-4):
        model = fracture_wall(cells=20, opening=1e-3, tolerance=tolerance)
        with simulator_of(model, darts_python) as simulator:
            _, account, steps = simulator.advance(simulator.start(), None, 60 * DAY)
        found[tolerance] = (account.wells["out"].T, steps)
    best = found[1e-4][0]
    assert abs(found[1e-3][0] - best) < abs(found[1e-2][0] - best)
    assert abs(found[1e-3][0] - best) < 0.003 * (ROCK - COLD)
    assert found[1e-2][1] < found[1e-3][1] < found[1e-4][1]
