"""Reservoirs with cracks that are given, and what they produce: shared with a verification."""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from staffa.reservoir.darts import Darts
from staffa.reservoir.grid import grid_around
from staffa.reservoir.permeability import Plane, with_planes, with_rows
from staffa.reservoir.simulator import ConstantWater, Fracture, ReservoirModel, Well
from support.reservoirs import BOTTOM, COLD, reservoir

LENGTH = 60.0  # of the fracture along the wall (m)
DEPTH, SPACING = 8.0, 5.0  # of the cracks beside it (m)
ALONG = 0.5  # length of the wall's cells along the flow (m)
IN_ONE_CELL = 0.5 * ALONG  # a spread that leaves a crack in the cells that it crosses
INJECTOR, PRODUCER = (155.0, 155.0), (455.0, 155.0)  # in the plan view (m)
OPENING = 3e-4  # of its cracks (m)


@dataclass(frozen=True, kw_only=True)
class Produced:
    """Production at some times.

    Attributes
    ----------
    T : temperature of the producer at each time (K), shape (n,).
    drop : difference of the wells' pressures at the last time (Pa).
    """

    T: np.ndarray
    drop: float


def produced(
    model: ReservoirModel,
    cracks: Sequence[Plane],
    times: Sequence[float],
    python: Path,
    spread: float | None = None,
) -> Produced:
    """Return the production of a reservoir with cracks in it from the first step on.

    Parameters
    ----------
    model : the reservoir without them, with the wells "in" and "out".
    cracks : the cracks.
    times : times (s), increasing.
    python : the Python that has open-DARTS.
    spread : radius over which the cracks are spread (m); None for two cells and a quarter.
    """
    k = with_planes(model.grid, model.permeability, cracks, spread)
    T, now = [], 0.0
    with closing(Darts(replace(model, permeability=k), python)) as simulator:
        flow = simulator.start()
        for t in times:
            flow, account, _ = simulator.advance(flow, None, t - now)
            T.append(account.wells["out"].T)
            now = t
    drop = account.wells["in"].pressure - account.wells["out"].pressure
    return Produced(T=np.array(T), drop=drop)


def wall(along: float = ALONG) -> ReservoirModel:
    """Return tight rock beside a fracture of 1 mm, in a section along the flow.

    Parameters
    ----------
    along : length of the cells along the flow (m).
    """
    made = grid_around(
        (0.0, 0.0), (LENGTH, 10.0), ALONG, fractures={BOTTOM: 0.1}, beyond={(1, 1): 15.0}
    )
    x = np.linspace(0.0, LENGTH, round(LENGTH / along) + 1)
    grid = replace(made, edges=(x, *made.edges[1:]))
    wells = [
        Well(name="in", cells=(grid.cell_at((0.0, 0.0)),), rate=0.01, T=COLD),
        Well(name="out", cells=(grid.cell_at((LENGTH, 0.0)),), pressure=20e6),
    ]
    fractures = [Fracture(side=BOTTOM, opening=1e-3, height=0.1)]
    return with_rows(reservoir(grid, wells, fractures=fractures))


def dead_ends(opening: float, lean: float = 0.0) -> list[Plane]:
    """Return cracks from the wall into the rock, across the flow, and not on faces of cells.

    Parameters
    ----------
    opening : their opening (m).
    lean : angle to the normal of the wall, in the direction of the flow (degrees).
    """
    aside = DEPTH * float(np.tan(np.radians(lean)))
    places = np.arange((SPACING + ALONG) / 2, LENGTH - aside, SPACING).tolist()
    return [Plane(opening=opening, start=(x, 0.0), end=(x + aside, DEPTH)) for x in places]


def network(opening: float) -> list[Plane]:
    """Return the same cracks, and others along the flow that connect them.

    Parameters
    ----------
    opening : their opening (m).
    """
    depths = np.arange(SPACING / 2, DEPTH, SPACING).tolist()
    along = [Plane(opening=opening, start=(0.0, y), end=(LENGTH, y)) for y in depths]
    return [*dead_ends(opening), *along]


def plan_view() -> ReservoirModel:
    """Return a layer of 50 mD, 50 m thick, with two wells 300 m apart."""
    grid = grid_around((0.0, 0.0), (600.0, 300.0), 10.0, thickness=50.0)
    wells = [
        Well(name="in", cells=(grid.cell_at(INJECTOR),), rate=5.0, T=COLD),
        Well(name="out", cells=(grid.cell_at(PRODUCER),), pressure=22e6),
    ]
    water = ConstantWater(rho=900.0, c=4300.0, mu=2e-4)
    return reservoir(grid, wells, permeability=5e-14, porosity=0.1, water=water, p=25e6)


def channel() -> list[Plane]:
    """Return a crack from well to well."""
    return [Plane(opening=OPENING, start=INJECTOR, end=PRODUCER)]


def across() -> list[Plane]:
    """Return a crack of 200 m across the way, at the injector."""
    x, y = INJECTOR
    return [Plane(opening=OPENING, start=(x, y - 100.0), end=(x, y + 100.0))]
