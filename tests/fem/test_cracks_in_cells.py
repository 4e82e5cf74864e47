"""Cracks of a state, sorted into the cells of a reservoir: area, volume, walls, and flow."""

from staffa.backend.stack import MPI

import numpy as np
import pytest

from staffa.evolution.coupling import Cracks
from staffa.evolution.cracks_in_cells import CracksInCells
from staffa.model.domain import Domain, block
from staffa.model.fields import Spaces, spaces_on, vertices
from staffa.records.reservoir_facts import CrackRule
from staffa.reservoir.crack_permeability import CrackPermeability
from staffa.reservoir.grid import grid_around
from staffa.reservoir.permeability import CELLS
from staffa.reservoir.simulator import Fracture
from support.reservoirs import reservoir
from unit.test_reservoir_permeability import flow

OPENING, ELL, H = 1e-3, 1.0, 0.25


def opened(domain: Domain, spaces: Spaces, degrees: float, middle: tuple[float, float]) -> Cracks:
    """A straight crack through a point, with the profile of AT1 and an opening of OPENING."""
    angle = np.radians(degrees)
    normal = np.array([-np.sin(angle), np.cos(angle)])

    def off(x: np.ndarray) -> np.ndarray:
        return np.abs((x[:, :2] - middle) @ normal)

    x = vertices(spaces.alpha)
    alpha = np.clip(1 - off(x) / (2 * ELL), 0, 1) ** 2
    broken = 0.71 * H  # one row of elements at least
    alpha[off(x) < broken] = 1.0
    near = off(spaces.cell.tabulate_dof_coordinates()) < broken
    volume = OPENING * domain.size[0] / np.cos(angle)
    return Cracks(
        alpha=alpha, u=np.zeros(2 * len(x)), volumes=lambda: near * volume / np.count_nonzero(near)
    )


def moved(spaces: Spaces, u: np.ndarray) -> Cracks:
    """Rock that has moved, and has no cracks."""
    n = len(spaces.cell.tabulate_dof_coordinates())
    return Cracks(alpha=np.zeros(len(u)), u=u.ravel(), volumes=lambda: np.zeros(n))


@pytest.mark.parametrize("degrees", [0.0, 26.6, 45.0])
def test_an_oblique_crack_has_its_area_its_volume_and_its_flow(degrees: float) -> None:
    domain = block(MPI.COMM_SELF, size=(41.0, 41.0), h=H, cells="quadrilateral")
    spaces = spaces_on(domain)
    grid = grid_around((0.0, 0.0), (41.0, 41.0), 1.0, thickness=2.0)
    middle = (20.5, 20.5 + H / 2)  # in a row of elements
    cracks = opened(domain, spaces, degrees, middle)
    found = CracksInCells(domain, spaces, grid, ())(cracks)
    length = 41.0 / np.cos(np.radians(degrees))
    assert found.area.sum() == pytest.approx(2.0 * length, rel=0.06)
    assert found.volume.sum() == pytest.approx(2.0 * length * OPENING)
    rule = CrackRule(smallest=1e-6, largest=5e-3, spread=CELLS)
    open_now = CrackPermeability(reservoir(grid, []), rule)(found, np.zeros(0))
    # Between the middles of the first and the last cells. An area that is counted 5 % too large
    # makes the opening as much too small, and the flow of w^3 A by 10 %.
    exact = 2.0 * OPENING**3 / 12 / (length * 40 / 41)
    assert 0.75 * exact < flow(grid, open_now.k) < 1.05 * exact


@pytest.mark.parametrize(("size", "cells"), [((8.0, 4.0), "triangle"), ((4.0, 4.0, 2.0), "box")])
def test_a_wall_is_where_its_rock_is(size: tuple[float, ...], cells: str) -> None:
    shape = "hexahedron" if cells == "box" else cells
    domain = block(MPI.COMM_SELF, size=size, h=0.5, cells=shape)
    spaces, dim = spaces_on(domain), len(size)
    side = (dim - 1, -1)
    # The reservoir goes on to the left, where the wall is not, and stays.
    grid = grid_around(
        (0.0,) * dim, size, 1.0, beyond={(0, -1): 3.0}, fractures={side: 0.1}, thickness=2.0
    )
    x = vertices(spaces.alpha)
    u = np.zeros((len(x), dim))
    u[:, dim - 1] = 1e-3 * x[:, 0]
    fracture = Fracture(side=side, opening=1e-4, height=0.1)
    found = CracksInCells(domain, spaces, grid, [fracture])(moved(spaces, u))
    centers = grid.centers[grid.row(side), 0]
    assert np.any(centers < 0)
    assert found.walls == pytest.approx(1e-3 * np.maximum(centers, 0.0), abs=1e-15)
    assert not found.area.any() and not found.volume.any()


def test_an_upper_wall_moves_into_the_body_as_its_height_falls() -> None:
    domain = block(MPI.COMM_SELF, size=(4.0, 4.0), h=0.5, cells="quadrilateral")
    spaces = spaces_on(domain)
    grid = grid_around((0.0, 0.0), (4.0, 4.0), 1.0, fractures={(1, 1): 0.1})
    x = vertices(spaces.alpha)
    u = np.column_stack([np.zeros(len(x)), -2e-3 * np.ones(len(x))])
    fracture = Fracture(side=(1, 1), opening=1e-4, height=0.1)
    found = CracksInCells(domain, spaces, grid, [fracture])(moved(spaces, u))
    assert found.walls == pytest.approx(np.full(4, 2e-3))
