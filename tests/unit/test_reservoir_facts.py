"""Record of a reservoir made from its model: means over the body, wells, closed form."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from staffa.io.production_rows import production
from staffa.plot.production_curves import closed_form_temperature
from staffa.records.reservoir_facts import ReservoirFacts
from staffa.reservoir.describe_model import reservoir_facts, volumes_within
from staffa.reservoir.grid import Grid, grid_around
from staffa.reservoir.simulator import ReservoirModel, Well
from staffa.reservoir.single import SingleFracture
from support.circulating import step
from support.reservoirs import COLD, DAY, ROCK, WATER, fracture_wall, reservoir

LOWER, UPPER = (0.0, 0.0), (60.0, 5.0)
CAPACITY = 0.999 * 2.3e6 + 0.001 * 4.2e6


def facts(model: ReservoirModel) -> ReservoirFacts:
    return reservoir_facts(model, "tried 1.0", LOWER, UPPER)


def test_a_fracture_along_a_side_has_its_numbers_by_hand() -> None:
    found = facts(fracture_wall())
    assert found.thickness == 1.0 and found.halved and found.T_injected == COLD
    assert (found.T, found.pressure, found.conductivity) == pytest.approx((ROCK, 20e6, 2.5))
    assert found.rho_c == pytest.approx(CAPACITY)
    assert found.heat_in_place == pytest.approx(60 * 5 * CAPACITY * 140)
    assert found.flow is not None
    assert found.flow.q == pytest.approx(2e-5) and found.flow.length == pytest.approx(60.0)
    assert found.flow.half_spacing == pytest.approx(5.0)
    assert found.flow.stored == pytest.approx(1e-4 * 4.2e6)  # water of half the opening
    assert found.wells["in"].at == pytest.approx((0.5, -0.025, 0.5))
    assert found.wells["in"].rate == 0.01 and found.wells["out"].pressure == 20e6
    assert found.wells["out"].T is None and found.wells["out"].T_rock == ROCK


def test_the_closed_form_is_the_temperature_of_the_engine_single_and_its_area_the_wall() -> None:
    """As long as the walls do not feel each other the area is 60 m2, then it gets smaller."""
    model = fracture_wall()
    simulator, found = SingleFracture(model), facts(model)
    flow, steps = simulator.start(), []
    for index in range(12):
        flow, account, _ = simulator.advance(flow, None, 10 * DAY)
        steps.append(step(index, 10 * DAY * (index + 1), account))
    rows = production(found, steps)
    T = closed_form_temperature(found, np.array([row.elapsed for row in rows]))
    assert np.array([row.T for row in rows]) == pytest.approx(T, abs=1e-9)
    areas = [row.area for row in rows if row.drawdown > 0.05]
    assert areas[0] == pytest.approx(60, rel=0.01) and areas[-1] < 58


def ways(**changes: Any) -> ReservoirModel:
    return replace(fracture_wall(), **changes)


def rate_less(model: ReservoirModel) -> ReservoirModel:
    wells = [replace(model.wells[0], rate=None, pressure=21e6), model.wells[1]]
    return replace(model, wells=wells)


def with_a_third_well(model: ReservoirModel) -> ReservoirModel:
    third = Well(name="b", cells=(model.wells[1].cells[0] - 30,), pressure=20e6)
    return replace(model, wells=[*model.wells, third])


def with_a_well_in_rock(model: ReservoirModel) -> ReservoirModel:
    above = model.wells[1].cells[0] + 5 * model.grid.shape[0]
    return replace(model, wells=[model.wells[0], replace(model.wells[1], cells=(above,))])


def permeable(model: ReservoirModel) -> ReservoirModel:
    return replace(model, permeability=np.maximum(model.permeability, 1e-12))


def warmer_to_the_right(model: ReservoirModel) -> ReservoirModel:
    return replace(model, T=model.T + 0.1 * model.grid.centers[:, 0])


def of_two_rocks(model: ReservoirModel) -> ReservoirModel:
    return replace(model, conductivity=np.where(model.grid.centers[:, 1] > 2, 3.0, 2.5))


def without_a_fracture(model: ReservoirModel) -> ReservoirModel:
    return replace(model, fractures=())


@pytest.mark.parametrize(
    "change",
    [
        rate_less, with_a_third_well, with_a_well_in_rock, permeable, warmer_to_the_right,
        of_two_rocks, without_a_fracture,
    ],
)  # fmt: skip
def test_what_is_no_fracture_in_uniform_tight_rock_has_no_closed_form(change) -> None:
    found = facts(change(fracture_wall()))
    assert found.flow is None and closed_form_temperature(found, np.ones(3)) is None
    assert found.heat_in_place is not None


def test_only_the_body_counts_not_what_the_reservoir_has_beyond() -> None:
    grid = grid_around(LOWER, UPPER, 0.7, beyond={(0, 1): 40.0, (1, 1): 20.0}, thickness=2.0)
    wells = [Well(name="a", cells=(3, 5), rate=1.0, T=COLD), Well(name="b", cells=(9,), rate=-1.0)]
    far = grid.centers[:, 0] > 61
    model = reservoir(grid, wells, porosity=0.0, conductivity=np.where(far, 9.0, 2.5))
    found = facts(model)
    assert volumes_within(grid, LOWER, UPPER).sum() == pytest.approx(600)
    assert found.heat_in_place == pytest.approx(600 * 2.3e6 * 140)
    assert found.conductivity == pytest.approx(2.5, rel=1e-3) and found.thickness == 2.0
    assert not found.halved and found.flow is None
    assert found.wells["a"].at == pytest.approx(grid.centers[[3, 5]].mean(axis=0))


def test_three_dimensions_have_no_thickness_and_water_of_iapws_nominal_numbers() -> None:
    edges = np.linspace(0.0, 4.0, 5)
    grid = Grid(edges=(edges, edges, edges), dim=3)
    model = reservoir(grid, [Well(name="a", cells=(0,), rate=-1.0)], water=None)
    found = reservoir_facts(model, "tried", (1.0, 1.0, 1.0), (3.0, 3.0, 3.0))
    assert found.thickness is None and found.flow is None
    assert (found.water_rho, found.water_c) == (1000.0, 4200.0)
    assert found.T_injected is None and found.heat_in_place is None
    assert [len(axis) for axis in found.edges] == [5, 5, 5]


def test_injected_water_is_mixed_by_rate() -> None:
    wells = [
        Well(name="a", cells=(0,), rate=3.0, T=COLD),
        Well(name="b", cells=(1,), rate=1.0, T=COLD + 40),
    ]
    assert facts(ways(wells=wells)).T_injected == pytest.approx(COLD + 10)
    unknown = [wells[0], replace(wells[1], rate=None, pressure=21e6)]
    assert facts(ways(wells=unknown)).T_injected == pytest.approx(COLD + 20)
    assert facts(ways()).water_c == WATER.c
