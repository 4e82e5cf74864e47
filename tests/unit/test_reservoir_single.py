"""Closed-form engine, against values of other code and against itself.

tests/data/reservoir/references.csv has values that another program made with mpmath: Talbot's
contour and Gaver-Stehfest, whose difference is in the last column.
"""

import csv
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from staffa.errors import InputError
from staffa.reservoir.fracture_heat import FractureHeat, inverse_laplace
from staffa.reservoir.grid import grid_around
from staffa.reservoir.simulator import Fracture, Well
from staffa.reservoir.single import SingleFracture
from support.paths import ROOT
from support.reservoirs import (
    BOTTOM,
    COLD,
    DAY,
    RHO_C,
    ROCK,
    WATER,
    YEAR,
    K,
    fracture_wall,
    reservoir,
)

with (ROOT / "tests/data/reservoir/references.csv").open(newline="") as file:
    REFERENCES = list(csv.DictReader(file))


def rows(what: str) -> list[Any]:
    """Return the references of a kind, with the numbers of `at` by name."""
    found = [
        (
            {name: float(n) for name, n in re.findall(r"(\w+)=([-+.\deinf]+)", row["at"])},
            float(row["value"]),
            row["at"],
        )
        for row in REFERENCES
        if row["what"].startswith(what)
    ]
    return [pytest.param(numbers, value, id=name) for numbers, value, name in found]


@pytest.mark.parametrize(("at", "value"), rows("parallel fractures, theta"))
def test_drop_at_the_outlet_of_parallel_fractures(at: dict[str, float], value: float) -> None:
    # In units of z = k = rho c = 1: water q = 2 W, tD = t W^2, xE = W D.
    carried = 3.0
    heat = FractureHeat(carried=carried, stored=0.0, k=1.0, rho_c=1.0, depth=at["xE"] / carried)
    drop = heat.drop(np.ones(1), np.zeros(1), at["tD"] / carried**2)
    assert drop[0] == pytest.approx(value, abs=2e-8)


@pytest.mark.parametrize(("at", "value"), rows("parallel fractures, T"))
def test_production_of_parallel_fractures(at: dict[str, float], value: float) -> None:
    model = fracture_wall(at["z"], at["spacing"] / 2, q=at["q"], opening=1e-7, h=1.0, porosity=0.0)
    simulator = SingleFracture(model)
    _, account, _ = simulator.advance(simulator.start(), None, at["t"] * DAY)
    assert abs(account.wells["out"].T - 273.15 - value) < 2e-4


@pytest.mark.parametrize(("at", "value"), rows("single fracture, T"))
def test_production_of_a_single_fracture(at: dict[str, float], value: float) -> None:
    model = fracture_wall(at["z"], 2000.0, q=at["q"], opening=1e-7, h=100.0, porosity=0.0)
    simulator = SingleFracture(model)
    _, account, _ = simulator.advance(simulator.start(), None, at["t"] * YEAR)
    assert abs(account.wells["out"].T - 273.15 - value) < 2e-4


@pytest.mark.parametrize(("at", "value"), rows("Lauwerier"))
def test_water_in_a_layer_that_stores_heat(at: dict[str, float], value: float) -> None:
    stored = at["b"] * (at["phi"] * WATER.rho * WATER.c + (1 - at["phi"]) * RHO_C)
    carried = at["u"] * at["b"] * WATER.rho * WATER.c
    heat = FractureHeat(carried=carried, stored=stored, k=K, rho_c=RHO_C)
    drop = heat.drop(np.array([at["x"]]), np.zeros(1), at["t"] * YEAR)
    assert drop[0] == pytest.approx(value, rel=1e-7)


def test_a_row_of_a_layer_stores_its_rock_and_water() -> None:
    b, u, porosity = 0.5, 1e-5, 0.3
    grid = grid_around((0.0, 0.0), (400.0, 2000.0), 50.0, fractures={BOTTOM: 2 * b})
    row = np.isin(np.arange(grid.size), grid.row(BOTTOM))
    wells = [
        Well(name="in", cells=(grid.cell_at((0, 0)),), rate=1000 * u * b, T=COLD),
        Well(name="out", cells=(grid.cell_at((400, 0)),), pressure=20e6),
    ]
    model = reservoir(
        grid, wells, porosity=np.where(row, porosity, 0.0),
        fractures=[Fracture(side=BOTTOM, opening=1e-3, height=2 * b)],
    )  # fmt: skip
    simulator = SingleFracture(model)
    _, account, _ = simulator.advance(simulator.start(), None, 10 * YEAR)
    (value,) = [p.values[1] for p in rows("Lauwerier") if "x=400 t=10" in str(p.id)]
    drop = (ROCK - account.wells["out"].T) / (ROCK - COLD)
    assert drop == pytest.approx(value, rel=1e-6)


def test_the_two_closed_forms_agree_where_the_boundary_has_no_effect() -> None:
    numbers = {"carried": 40.0, "stored": 400.0, "k": K, "rho_c": RHO_C}
    x, y = np.linspace(0, 60, 7), np.linspace(0, 20, 7)
    t = 100 * DAY
    near, far = FractureHeat(**numbers, depth=29.0), FractureHeat(**numbers)
    assert near.depth < 10 * np.sqrt(K / RHO_C * t)
    assert near.drop(x, y, t) == pytest.approx(far.drop(x, y, t), abs=1e-9)
    assert near.integral(60.0, t) == pytest.approx(far.integral(60.0, t), rel=1e-9)


@pytest.mark.parametrize("depth", [2.0, np.inf])
def test_the_integral_is_that_of_the_drop(depth: float) -> None:
    heat = FractureHeat(carried=40.0, stored=400.0, k=K, rho_c=RHO_C, depth=depth)
    times = np.linspace(0, 50 * DAY, 4001)
    drops = np.array([heat.drop(np.array([20.0]), np.zeros(1), t)[0] for t in times])
    mean = np.trapezoid(drops, times)
    assert heat.integral(20.0, times[-1]) == pytest.approx(mean, rel=1e-6)


def test_the_inversion_returns_known_functions() -> None:
    t = np.array([0.1, 1.0, 10.0])
    assert inverse_laplace(lambda s: 1 / (s + 1), t) == pytest.approx(np.exp(-t), abs=1e-10)
    assert inverse_laplace(lambda s: s**-2.0, t) == pytest.approx(t, rel=1e-10)


def test_the_heat_of_the_wells_is_the_heat_of_the_cells_as_these_get_finer() -> None:
    imbalances = []
    for cells, h, height in ((15, 1.6, 0.4), (60, 0.4, 0.1)):
        simulator = SingleFracture(fracture_wall(cells=cells, h=h, height=height))
        flow, account, _ = simulator.advance(simulator.start(), None, 30 * DAY)
        _, later, _ = simulator.advance(flow, None, 30 * DAY)
        imbalances.append(account.then(later).imbalance)
    assert imbalances[1] < 7e-4 and imbalances[1] < imbalances[0] / 3


def test_a_step_is_the_same_in_two_parts_and_by_another_one() -> None:
    model = fracture_wall()
    one, other = SingleFracture(model), SingleFracture(model)
    whole, account, _ = one.advance(one.start(), None, 50 * DAY)
    half, first, _ = one.advance(one.start(), None, 20 * DAY)
    rest, second, inner = other.advance(half, np.zeros(model.grid.size), 30 * DAY)
    assert rest.T.tobytes() == whole.T.tobytes() and inner == 1
    both = first.then(second).wells["out"]
    assert both.heat == pytest.approx(account.wells["out"].heat, rel=1e-9)


def test_pressure_falls_straight_along_the_fracture_and_rests_in_the_rock() -> None:
    model = fracture_wall()
    simulator = SingleFracture(model)
    flow, account, _ = simulator.advance(simulator.start(), None, DAY)
    # 12 mu L q/w^3
    assert account.wells["in"].pressure - 20e6 == pytest.approx(0.54e6)
    row = model.grid.row(BOTTOM)
    x = model.grid.centers[row, 0]
    assert flow.p[row] - 20e6 == pytest.approx(0.54e6 * (1 - x / 60))
    assert np.all(np.delete(flow.p, row) == 20e6)


def test_before_the_first_step_the_pressure_is_that_of_the_rock() -> None:
    """Changes by water count from there: else the pressure of circulation acts nowhere."""
    model = fracture_wall()
    assert np.array_equal(SingleFracture(model).start().p, model.p)


def test_injection_at_the_other_end_mirrors_the_solution() -> None:
    model = fracture_wall()
    first, last = model.wells
    turned = replace(
        model, wells=[replace(first, cells=last.cells), replace(last, cells=first.cells)]
    )
    pair = [SingleFracture(m) for m in (model, turned)]
    T = [s.advance(s.start(), None, 50 * DAY)[0].T.reshape(60, -1, order="F") for s in pair]
    assert T[1][::-1] == pytest.approx(T[0], abs=1e-9)


@pytest.mark.parametrize(
    ("changes", "needed"),
    [
        ({"water": None}, "water of constant properties"),
        ({"fractures": ()}, "one fracture along a side"),
        ({"wells": ()}, "two wells"),
        ({"T": np.linspace(300, 400, 1320)}, "one temperature"),
        ({"conductivity": np.linspace(2, 3, 1320)}, "one conductivity"),
        ({"rho_c": np.linspace(2e6, 3e6, 1320)}, "one heat capacity"),
    ],
)
def test_what_it_does_not_describe_is_refused(changes: dict[str, Any], needed: str) -> None:
    model = fracture_wall()
    assert model.grid.size == 1320
    with pytest.raises(InputError, match=f"needs {needed}"):
        SingleFracture(replace(model, **changes))


def test_wells_inside_the_fracture_are_refused() -> None:
    model = fracture_wall()
    wells = [replace(model.wells[0], cells=(3,)), model.wells[1]]
    with pytest.raises(InputError, match="wells at both ends"):
        SingleFracture(replace(model, wells=wells))
