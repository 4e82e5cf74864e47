"""Permeability from cracks that are sorted into the cells, and the flow with its shadow."""

from dataclasses import replace

import numpy as np
import pytest

from staffa.records.circulation import Circulation, WellAccount
from staffa.records.reservoir_facts import CrackRule
from staffa.reservoir.crack_permeability import CrackedCells, CrackPermeability
from staffa.reservoir.flow_in_cracks import FlowInCracks
from staffa.reservoir.grid import Grid, grid_around
from staffa.reservoir.permeability import along_axes
from staffa.reservoir.simulator import Flow, ReservoirModel
from support.reservoirs import BOTTOM, fracture_wall, reservoir

RULE = CrackRule(smallest=1e-5, largest=2e-3, spread=2.0)


def empty(model: ReservoirModel) -> CrackedCells:
    nothing = np.zeros(model.grid.size)
    rows = sum(len(model.grid.row(fracture.side)) for fracture in model.fractures)
    along, across = (np.zeros((model.grid.size, *shape)) for shape in ((3,), (2, 2)))
    return CrackedCells(
        area=nothing, volume=nothing, along=along, across=across, walls=np.zeros(rows)
    )


def crossed(grid: Grid, spacing: float, opening: float) -> CrackedCells:
    """Cracks along x, of one opening, at a distance of each other."""
    y, areas = grid.centers[:, 1], grid.sizes[:, 0] * grid.sizes[:, 2]
    lines = np.arange(spacing / 2, grid.edges[1][-1], spacing)
    counts = np.histogram(lines, grid.edges[1])[0]
    row = np.searchsorted(grid.edges[1], y) - 1
    area = counts[row] * areas
    normal = np.array([0.0, 1.0])
    return CrackedCells(
        area=area,
        volume=opening * area,
        along=area[:, None] * along_axes(normal[None]),
        across=area[:, None, None] * np.outer(normal, normal),
        walls=np.zeros(0),
    )


def test_without_cracks_the_permeability_is_that_of_the_model_to_the_bit() -> None:
    model = fracture_wall(cells=10)
    found = CrackPermeability(model, RULE)(empty(model), np.zeros(10))
    assert np.array_equal(found.k, np.repeat(model.permeability[:, None], 3, axis=1))
    assert found.account.area == found.account.volume == 0 and found.account.spacing is None
    side = found.account.sides["bottom"]
    assert side.narrowest == side.widest == model.fractures[0].opening


@pytest.mark.parametrize("opening", [5e-4, 1e-6, 4e-3])
def test_a_layered_network_carries_the_cubic_law_within_the_bounds(opening: float) -> None:
    model = reservoir(grid_around((0.0, 0.0), (40.0, 40.0), 1.0, thickness=3.0), [])
    cracks = crossed(model.grid, 2.0, opening)
    found = CrackPermeability(model, RULE)(cracks, np.zeros(0))
    # Spread over two cells, cracks every two cells are a uniform layer away from its ends.
    inside = np.all(np.abs(model.grid.centers[:, :2] - 20) < 14, axis=1)
    w = np.clip(opening, RULE.smallest, RULE.largest)
    assert found.k[inside][:, 0] == pytest.approx(1e-20 + w**3 / 12 / 2.0, rel=0.1, abs=0)
    assert np.all(found.k[:, 1] == 1e-20), "nothing flows across"
    whole = (found.k[:, 0] - 1e-20) @ model.grid.volumes
    assert whole == pytest.approx(cracks.area.sum() * w**3 / 12, rel=1e-6)
    account = found.account
    assert account.area == pytest.approx(20 * 40.0 * 3.0)
    assert account.volume == pytest.approx(opening * account.area)
    assert account.widest == pytest.approx(opening)
    assert (account.at_smallest, account.at_largest) == (opening < 1e-5, opening > 2e-3)
    assert account.spacing == pytest.approx(2.0, abs=0.5)


@pytest.mark.parametrize(("spacing", "seen"), [(3.0, 3.0), (6.0, 6.0), (8.0, 8.0), (40.0, 10.0)])
def test_the_distance_of_cracks_is_seen_up_to_five_spreads(spacing: float, seen: float) -> None:
    grid = grid_around((0.0, 0.0), (20.0, 80.0), 0.5)
    model = reservoir(grid, [])
    account = CrackPermeability(model, RULE)(crossed(grid, spacing, 1e-4), np.zeros(0)).account
    assert account.spacing == pytest.approx(seen, abs=0.5)


def test_a_fracture_opens_as_its_wall_moves_from_where_it_was_at_rest() -> None:
    model = fracture_wall(length=10.0, cells=5, opening=2e-4)
    permeability = CrackPermeability(model, RULE)
    rest = np.full(5, 3e-5)
    into_body = np.array([0.0, 1e-4, -1e-4, 2e-3, -5e-4])
    found = permeability(replace(empty(model), walls=rest + into_body), rest)
    w = np.clip(2e-4 + 2 * into_body, RULE.smallest, RULE.largest)
    row = model.grid.row(BOTTOM)
    for along in found.k[row].T:
        assert along == pytest.approx(w**3 / (12 * 0.1), rel=1e-9, abs=0)
    side = found.account.sides["bottom"]
    assert (side.narrowest, side.widest) == pytest.approx((-8e-4, 4.2e-3))
    assert (side.at_smallest, side.at_largest) == (0.4, 0.2)
    # Half of the fracture is in the cells: 2 m of it a cell, 1 m thick.
    assert found.account.opened == pytest.approx(2.0 * into_body.sum())
    assert found.account.volume == 0


class Tried:
    """A simulator whose temperature is the mean permeability, and that counts its steps."""

    name = "tried"

    def __init__(self, model: ReservoirModel) -> None:
        self.model, self.steps = model, 0

    def start(self) -> Flow:
        return Flow(hidden=np.zeros(3), T=self.model.T, p=self.model.p)

    def advance(
        self, flow: Flow, permeability: np.ndarray | None, duration: float
    ) -> tuple[Flow, Circulation, int]:
        assert permeability is not None
        self.steps += 1
        T = flow.T + duration * permeability.mean()
        well = WellAccount(mass=1.0, heat=float(T.mean()), T=float(T[0]), pressure=1.0)
        account = Circulation(duration=duration, wells={"in": well})
        return Flow(hidden=flow.hidden + duration, T=T, p=flow.p), account, 1

    def close(self) -> None:
        pass


def test_the_shadow_keeps_the_permeability_before_the_first_step_and_steps_once() -> None:
    model = fracture_wall(length=10.0, cells=5)
    simulator, still = Tried(model), empty(model)
    flow = FlowInCracks(simulator, CrackPermeability(model, RULE), shadow=True)
    start = flow.at_rest(flow.start(), still)
    moved = replace(still, walls=np.full(5, 1e-4))
    one, first, without, _ = flow.advance(start, still, 10.0)
    assert without == replace(first, cracks=None) and one.shadow is not None
    # A second pass of the same step, with the cracks that the first one led to.
    again, wider, same, _ = flow.advance(start, moved, 10.0)
    assert same == without and simulator.steps == 3
    assert wider.wells["in"].heat > first.wells["in"].heat
    # The openings count from the cracks at rest.
    assert again.walls == pytest.approx(np.zeros(5)) and np.array_equal(again.k_first, one.k_first)
    # What is packed is all that a step needs, in a new process too.
    other = FlowInCracks(Tried(model), CrackPermeability(model, RULE), shadow=True)
    here, there = (f.advance(f.unpacked(again.packed()), moved, 5.0) for f in (flow, other))
    assert np.array_equal(here[0].packed(), there[0].packed())
    assert here[1:3] == there[1:3]


def test_without_a_shadow_there_is_one_flow() -> None:
    model = fracture_wall(length=10.0, cells=5)
    simulator = Tried(model)
    flow = FlowInCracks(simulator, CrackPermeability(model, RULE), shadow=False)
    start = flow.at_rest(flow.start(), empty(model))
    after, _, without, _ = flow.advance(start, empty(model), 1.0)
    assert without is None and after.shadow is None and simulator.steps == 1
    assert np.array_equal(flow.unpacked(after.packed()).flow.T, after.flow.T)
