"""Permeability of fractures, fluxes between cells, and wells."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.linalg import spsolve

from staffa.reservoir.grid import Grid, grid_around
from staffa.reservoir.permeability import CELLS, Plane, along_axes, of_opening, with_planes
from staffa.reservoir.simulator import Well
from staffa.reservoir.two_point import connections, well_indices
from support.reservoirs import BOTTOM, fracture_wall, reservoir

OPENING = 1e-3


def flow(grid: Grid, k: np.ndarray) -> float:
    """Return the flow (m^3) from a drop of 1 between the left and right ends of a grid."""
    faces = connections(grid)
    through = faces.conductance(k)
    left, right = (np.flatnonzero(grid.centers[:, 0] == f(grid.centers[:, 0])) for f in (min, max))
    rows = np.concatenate([faces.lower, faces.upper, faces.lower, faces.upper])
    columns = np.concatenate([faces.lower, faces.upper, faces.upper, faces.lower])
    values = np.concatenate([through, through, -through, -through])
    matrix = coo_array((values, (rows, columns)), shape=(grid.size, grid.size)).tocsr()
    known, p = np.concatenate([left, right]), np.zeros(grid.size)
    p[left] = 1.0
    free = np.setdiff1d(np.arange(grid.size), known)
    p[free] = spsolve(matrix[free][:, free].tocsc(), -(matrix[free][:, known] @ p[known]))
    return float((matrix[left] @ p).sum())


def kept(degrees: float, cells: float, n: int = 41) -> float:
    """Return the flow through an oblique fracture across a square, over that of w^3/12.

    Parameters
    ----------
    degrees : angle to the drop of pressure.
    cells : radius over which it is spread, in cells.
    n : number of cells along the square.
    """
    grid = grid_around((0.0, 0.0), (float(n), float(n)), 1.0)
    angle = np.radians(degrees)
    half, middle = n / 2 * np.array([1.0, np.tan(angle)]), np.array([n / 2, n / 2])
    plane = Plane(opening=OPENING, start=tuple(middle - half), end=tuple(middle + half))
    k = with_planes(grid, np.full(grid.size, 1e-20), [plane], None if cells == CELLS else cells)
    length = (n - 1) / np.cos(angle)  # between the middles of the first and the last cells
    return flow(grid, k) / (OPENING**3 / 12 / length)


@pytest.mark.parametrize(("cells", "tolerance"), [(CELLS, 0.08), (CELLS + 1, 0.04)])
@pytest.mark.parametrize("degrees", [0.0, 10.0, 26.6, 45.0])
def test_an_oblique_fracture_keeps_its_flow(degrees: float, cells: float, tolerance: float) -> None:
    assert kept(degrees, cells) == pytest.approx(1.0, abs=tolerance)


@pytest.mark.parametrize(("cells", "least"), [(CELLS, 0.87), (CELLS + 1, 0.9)])
def test_a_long_oblique_fracture_loses_more_of_its_flow(cells: float, least: float) -> None:
    """Near the ends, where the pressure is given, some water finds a shorter way."""
    short, long = 41, 81
    resistances = {n: (n - 1) / kept(45.0, cells, n) for n in (short, long)}
    of_the_middle = (long - short) / (resistances[long] - resistances[short])
    assert least < of_the_middle < kept(45.0, cells, short)


def test_a_plane_keeps_its_area_and_adds_up() -> None:
    grid = grid_around((0.0, 0.0), (20.0, 20.0), 1.0, fractures={BOTTOM: 0.1}, thickness=2.0)
    plane = Plane(opening=OPENING, start=(5.2, 5.1), end=(12.0, 9.3))
    k0 = np.full(grid.size, 1e-18)
    added = with_planes(grid, k0, [plane]) - k0[:, None]
    length = np.hypot(6.8, 4.2)
    shares = np.array([6.8, 4.2]) * (6.8 + 4.2) / length**2  # |t_i| (|t_x| + |t_y|)
    areas = grid.volumes @ added / (OPENING**3 / 12)
    assert areas == pytest.approx(2.0 * length * np.array([*shares, 1.0]), rel=1e-9)
    assert np.all(added[grid.row(BOTTOM)] == 0)
    twice = with_planes(grid, k0, [plane, replace(plane, opening=2 * OPENING)]) - k0[:, None]
    assert twice == pytest.approx(9 * added)


def test_a_disc_keeps_its_area_within_the_reservoir() -> None:
    grid = grid_around((-5.0, -5.0, -5.0), (5.0, 5.0, 5.0), 1.0)
    k0 = np.zeros(grid.size)
    disc = Plane(opening=OPENING, center=(0.1, 0.2, 0.0), normal=(1.0, 2.0, 3.0), radius=3.0)
    added = with_planes(grid, k0, [disc])
    areas = grid.volumes @ added / (OPENING**3 / 12)
    # 1 - n_i^2 + |n_i| max |n_j|, the normal being (1, 2, 3)/sqrt(14).
    shares = np.array([13 + 3, 10 + 6, 5 + 6]) / 14
    assert areas == pytest.approx(np.pi * 9.0 * shares, rel=1e-9)
    half = with_planes(grid, k0, [replace(disc, center=(5.0, 0.0, 0.0), normal=(0.0, 0.0, 1.0))])
    areas = grid.volumes @ half / (OPENING**3 / 12)
    assert areas == pytest.approx(np.pi * 9.0 / 2 * np.array([1.0, 1.0, 0.0]), rel=0.02)


def power_in_space(normal: Sequence[float], along: Sequence[float], *, isotropic: bool) -> float:
    """Return the power of a flow along an oblique plane in the middle of a cube.

    The pressure at the faces of a cube is that of an even flow along the plane.
    """
    n = np.array(normal) / np.linalg.norm(normal)
    t = np.array(along) - np.dot(along, n) * n
    t /= np.linalg.norm(t)
    size = 13
    grid = grid_around((0.0,) * 3, (float(size),) * 3, 1.0)
    plane = Plane(opening=OPENING, center=(size / 2,) * 3, normal=tuple(n), radius=2.0 * size)
    area = grid.volumes * with_planes(grid, np.zeros(grid.size), [plane]).max(axis=1)
    area /= along_axes(n[None]).max() * OPENING**3 / 12
    shares = np.ones(3) if isotropic else along_axes(n[None])[0]
    k = 1e-9 + area[:, None] / grid.volumes[:, None] * shares
    faces, p = connections(grid), grid.centers @ t
    through = faces.conductance(k)
    known = np.any(np.abs(grid.centers - size / 2) > size / 2 - 1, axis=1)
    rows = np.concatenate([faces.lower, faces.upper, faces.lower, faces.upper])
    columns = np.concatenate([faces.lower, faces.upper, faces.upper, faces.lower])
    values = np.concatenate([through, through, -through, -through])
    matrix = coo_array((values, (rows, columns)), shape=(grid.size, grid.size)).tocsr()
    free = np.flatnonzero(~known)
    p[free] = spsolve(matrix[free][:, free].tocsc(), -(matrix[free][:, known] @ p[known]))
    power = through * (p[faces.upper] - p[faces.lower]) ** 2
    middle = np.abs((grid.centers[faces.lower] + grid.centers[faces.upper] - size) / 2)
    return float(power[np.all(middle < 3, axis=1)].sum())


@pytest.mark.parametrize("normal", [(0, 0, 1), (0, 1, 1), (1, 1, 1), (1, 2, 3), (0, 1, 2)])
def test_by_direction_an_oblique_plane_keeps_as_much_as_alike_in_all(normal) -> None:
    for along in ((1.0, 0.3, 0.0), (0.2, 1.0, -1.0)):
        powers = [power_in_space(normal, along, isotropic=alike) for alike in (False, True)]
        assert 0.99 < powers[0] / powers[1] < 1.15


def test_a_dead_end_is_no_detour() -> None:
    """A crack along an axis carries nothing across."""
    assert along_axes(np.array([[1.0, 0.0]])).tolist() == [[0.0, 1.0, 1.0]]
    assert along_axes(np.array([[0.0, 0.0, 1.0]])).tolist() == [[1.0, 1.0, 0.0]]
    half = np.sqrt(0.5)
    assert along_axes(np.array([[half, half]]))[0] == pytest.approx([1.0, 1.0, 1.0])


def test_the_row_of_a_fracture_carries_half_of_its_flow_and_holds_half_of_its_water() -> None:
    model = fracture_wall(opening=OPENING, height=0.1)
    row = model.grid.row(BOTTOM)
    assert model.permeability[row] == pytest.approx(of_opening(OPENING, 0.1))
    assert model.permeability[row] * 0.05 == pytest.approx(OPENING**3 / 24)
    water = (model.porosity * model.grid.volumes)[row].sum()
    assert water == pytest.approx(60.0 * OPENING / 2)


def test_a_wide_fracture_is_as_permeable_as_one_of_5_mm_and_holds_its_water() -> None:
    wide, less = fracture_wall(opening=0.02), fracture_wall(opening=5e-3)
    assert wide.permeability.tobytes() == less.permeability.tobytes()
    row = wide.grid.row(BOTTOM)
    assert wide.porosity[row] == pytest.approx(4 * less.porosity[row])


def test_there_is_no_resistance_across_the_row_of_a_fracture() -> None:
    model = fracture_wall()
    faces = connections(model.grid)
    through = faces.conductance(model.conductivity)
    at_wall = np.flatnonzero((faces.lower == 0) & (faces.upper == 60))
    first = np.diff(model.grid.edges[1])[1]
    assert through[at_wall] == pytest.approx(2.5 * 1.0 / (first / 2))


def test_conductance_is_that_of_two_cells_in_series_and_zero_through_a_tight_one() -> None:
    grid = grid_around((0.0, 0.0), (3.0, 1.0), 1.0, thickness=2.0)
    through = connections(grid).conductance(np.array([1.0, 3.0, 0.0]))
    assert through == pytest.approx([2.0 / (0.5 / 1 + 0.5 / 3), 0.0])


def test_well_index_is_that_of_peaceman_and_positive_in_thin_cells() -> None:
    grid = grid_around((0.0, 0.0), (10.0, 10.0), 2.0, thickness=5.0)
    model = reservoir(grid, [])
    well = Well(name="a", cells=(12,), pressure=1e7, radius=0.1)
    k = np.full(grid.size, 1e-13)
    equivalent = 0.14 * np.hypot(2.0, 2.0)
    assert well_indices(model, well, k) == pytest.approx(
        2 * np.pi * 1e-13 * 5.0 / np.log(equivalent / 0.1)
    )
    thin = replace(well, radius=5.0)
    assert well_indices(model, thin, k)[0] > 0


def test_a_well_at_the_end_of_a_fracture_meets_half_a_cell() -> None:
    model = fracture_wall(opening=OPENING)
    index = well_indices(model, model.wells[0], model.permeability)
    assert index == pytest.approx(OPENING**3 / 24 / 0.5)


def test_a_well_of_a_body_in_space_is_parallel_to_gravity() -> None:
    grid = grid_around((0.0, 0.0, 0.0), (4.0, 2.0, 8.0), 1.0)
    k = np.ones(grid.size)
    well = Well(name="a", cells=(5,), pressure=1e7)
    grid = replace(grid, edges=(grid.edges[0], 2 * grid.edges[1], 4 * grid.edges[2]))
    down = reservoir(grid, [well], gravity=(0.0, 0.0, -9.81))
    along_y = reservoir(grid, [well], gravity=(0.0, -9.81, 0.0))
    assert well_indices(down, well, k) == pytest.approx(
        8 * np.pi / np.log(1.4 * np.hypot(1.0, 2.0))
    )
    assert well_indices(along_y, well, k) == pytest.approx(
        4 * np.pi / np.log(1.4 * np.hypot(1.0, 4.0))
    )


def test_a_well_on_a_crack_opens_to_the_crack() -> None:
    """Whatever the crack's direction, and however tight the rock is across it."""
    grid = grid_around((0.0, 0.0), (20.0, 20.0), 1.0)
    well = Well(name="in", cells=(grid.cell_at((10.5, 10.5)),), rate=1.0, T=333.15)
    model = reservoir(grid, [well])
    tight, wide = 1e-17, 1e-11
    alike = well_indices(model, well, np.full(grid.size, wide))
    for along in ([wide, tight, wide], [tight, wide, wide], [wide, wide, wide]):
        found = well_indices(model, well, np.tile(along, (grid.size, 1)))
        assert found == pytest.approx(alike, rel=1e-12, abs=0)
