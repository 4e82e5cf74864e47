"""Reservoirs that several tests share."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from staffa.reservoir.grid import Grid, grid_around
from staffa.reservoir.permeability import with_rows
from staffa.reservoir.simulator import ConstantWater, Fracture, ReservoirModel, Well

DAY = 86400.0
YEAR = 365.25 * DAY
BOTTOM = (1, -1)
ROCK, COLD = 473.15, 333.15  # K: 200 °C and 60 °C
WATER = ConstantWater(rho=1000.0, c=4200.0, mu=3e-4)
K, RHO_C = 2.5, 2.3e6  # W/(m K), J/(m^3 K)


def reservoir(grid: Grid, wells: Sequence[Well], **changes: Any) -> ReservoirModel:
    """Return a tight rock of 200 °C at 20 MPa with wells.

    Parameters
    ----------
    grid : the cells.
    wells : the wells.
    changes : other members of the model; one value of a property is that of all cells.
    """
    given: dict[str, Any] = {
        "permeability": 1e-20, "porosity": 1e-3, "conductivity": K, "rho_c": RHO_C, "T": ROCK,
        "p": 20e6, "water": WATER, **changes,
    }  # fmt: skip
    for name in ("permeability", "porosity", "conductivity", "rho_c", "T", "p"):
        given[name] = np.full(grid.size, given[name], dtype=float)
    return ReservoirModel(grid=grid, wells=wells, **given)


def fracture_wall(
    length: float = 60.0,
    depth: float = 5.0,
    *,
    q: float = 2e-5,
    cells: int = 60,
    height: float = 0.1,
    opening: float = 2e-4,
    h: float = 0.4,
    **changes: Any,
) -> ReservoirModel:
    """Return half of a fracture along the bottom of a rock, with wells at its ends.

    Parameters
    ----------
    length, depth : of the rock (m).
    q : flow through the whole fracture per thickness (m^2/s).
    cells : number of cells along the fracture.
    height : height of the whole fracture's cells (m).
    opening : its opening (m).
    h : largest height of the cells (m).
    changes : other members of the model.
    """
    made = grid_around((0.0, 0.0), (length, depth), h, fractures={BOTTOM: height})
    x = np.linspace(0.0, length, cells + 1)
    grid = replace(made, edges=(x, *made.edges[1:]))
    wells = [
        Well(name="in", cells=(grid.cell_at((0.0, 0.0)),), rate=1000.0 * q / 2, T=COLD),
        Well(name="out", cells=(grid.cell_at((length, 0.0)),), pressure=20e6),
    ]
    fractures = [Fracture(side=BOTTOM, opening=opening, height=height)]
    return with_rows(reservoir(grid, wells, fractures=fractures, **changes))
