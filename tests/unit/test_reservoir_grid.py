"""Grid of a reservoir: sizes of cells, cells of points, interpolation."""

import numpy as np
import pytest

from staffa.errors import InputError
from staffa.reservoir.grid import Grid, grid_around

BOTTOM, TOP, LEFT, RIGHT = (1, -1), (1, 1), (0, -1), (0, 1)


def wall() -> Grid:
    return grid_around((0, 0), (60, 30), 1.0, beyond={TOP: 25.0}, fractures={BOTTOM: 0.1})


def test_cells_fill_the_body_and_grow_away_from_a_fracture_and_beyond_the_body() -> None:
    grid = wall()
    y = grid.edges[1]
    assert y[0] == -0.05 and y[1] == 0.0 and 30.0 in y and y[-1] == 55.0
    sizes = np.diff(y)[1:]
    assert 0.05 < sizes[0] <= 0.06
    inside = np.diff(y[(y >= 0) & (y <= 30)])
    assert inside.max() <= 1.0 and inside.max() > 0.97
    growth = sizes[1:] / sizes[:-1]
    assert np.all(growth[: len(inside) - 1] < 1.1501) and np.all(growth > 0.999)
    assert growth[len(inside) :] == pytest.approx(1.25)
    assert grid.edges[0] == pytest.approx(np.linspace(0, 60, 61), abs=1e-12)


@pytest.mark.parametrize("length", [0.3, 1.0, 7.0])
def test_equal_cells_without_fractures_are_as_many_as_needed(length: float) -> None:
    grid = grid_around((0, 0, 0), (length, 1, 1), 0.1)
    assert grid.shape == (round(length / 0.1), 10, 10)
    assert grid.volumes.sum() == pytest.approx(length)


def test_fractures_on_both_sides_have_small_cells_beside_them() -> None:
    grid = grid_around((0, 0), (10, 10), 1.0, fractures={LEFT: 0.1, RIGHT: 0.2})
    sizes = np.diff(grid.edges[0])
    assert sizes[0] == pytest.approx(0.05) and sizes[-1] == pytest.approx(0.1)
    assert 0.04 < sizes[1] <= 0.06 and 0.08 < sizes[-2] <= 0.13
    assert grid.edges[0][1] == 0.0 and grid.edges[0][-2] == 10.0


def test_a_point_on_a_side_with_a_fracture_belongs_to_its_row() -> None:
    grid = wall()
    assert grid.cell_at((0, 0)) == 0
    assert grid.cell_at((60, 0)) == 59
    assert grid.cell_at((0, 0.01)) == 60
    assert grid.cell_at((60, 55)) == grid.size - 1
    assert list(grid.row(BOTTOM)) == list(range(60))
    with pytest.raises(InputError, match="outside the reservoir"):
        grid.cell_at((61, 0))


def test_every_center_lies_in_its_cell() -> None:
    grid = grid_around((0, 0, -1), (2, 3, 1), 0.5, beyond={(2, 1): 3.0}, fractures={LEFT: 0.1})
    assert [grid.cell_at(c) for c in grid.centers] == list(range(grid.size))


@pytest.mark.parametrize("dim", [2, 3])
def test_linear_fields_are_reproduced_within_the_range_and_clamped_outside(dim: int) -> None:
    lower, upper = (0, 0, -1)[:dim], (2, 3, 1)[:dim]
    grid = grid_around(lower, upper, 0.4, beyond={TOP: 2.0}, fractures={LEFT: 0.1})
    slope = np.array([3.0, -2.0, 0.5])[:dim]
    field = 7 + grid.nodes[:, :dim] @ slope
    low, high = grid.nodes[:, :dim].min(axis=0), grid.nodes[:, :dim].max(axis=0)
    points = np.random.default_rng(1).uniform(low, high, (500, dim))
    matrix = grid.weights(points)
    assert matrix.shape == (500, grid.size)
    assert matrix @ field == pytest.approx(7 + points @ slope, abs=1e-12)
    outside = points + 10.0
    assert grid.weights(outside) @ field == pytest.approx(
        7 + np.clip(outside, low, high) @ slope, abs=1e-12
    )


def test_a_wall_has_the_temperature_of_its_fracture() -> None:
    grid = wall()
    field = np.where(np.isin(np.arange(grid.size), grid.row(BOTTOM)), 60.0, 200.0)
    assert grid.weights(np.array([[30.0, 0.0]])) @ field == pytest.approx(60.0)


def test_no_reservoir_goes_on_beyond_a_fracture() -> None:
    with pytest.raises(InputError, match="lower end of y, along which a fracture lies"):
        grid_around((0, 0), (1, 1), 0.1, beyond={BOTTOM: 1.0}, fractures={BOTTOM: 0.1})
