"""Description of a reservoir before the first step, for those who read its run later."""

from collections.abc import Sequence

import numpy as np

from staffa.records.reservoir_facts import CrackRule, FractureFlow, ReservoirFacts, WellFacts
from staffa.reservoir.grid import Grid
from staffa.reservoir.permeability import largest_along
from staffa.reservoir.simulator import ConstantWater, ReservoirModel, Well

# Water in closed forms where a simulator takes that of IAPWS-95. At 20 MPa its c is 4,126 J/(kg K)
# at 20 °C, 4,400 at 200 °C and 4,209 in the mean. Only rho c enters together with a volume rate.
NOMINAL = ConstantWater(rho=1000.0, c=4200.0, mu=3e-4)
LEAK = 1e-3  # of the flow, beside a fracture whose closed form has tight rock
ALIKE = 1e-6  # relative difference of numbers that are the same


def reservoir_facts(
    model: ReservoirModel,
    simulator: str,
    lower: Sequence[float],
    upper: Sequence[float],
    cracks: CrackRule | None = None,
) -> ReservoirFacts:
    """Return the record of a reservoir before the first step.

    Parameters
    ----------
    model : the reservoir.
    simulator : name and version of its simulator.
    lower, upper : corners of the box around the body (m), shape (2 or 3,).
    cracks : rule by which cracks change the flow; None where they do not.
    """
    grid, water = model.grid, model.water or NOMINAL
    volumes = volumes_within(grid, lower, upper)
    rho_c = model.capacity(water)
    T, T_in = float(np.average(model.T, weights=volumes)), _injected(model.wells)
    hot = None if T_in is None else float((volumes * rho_c) @ (model.T - T_in))
    return ReservoirFacts(
        simulator=simulator,
        thickness=float(np.ptp(grid.edges[2])) if grid.dim == 2 else None,
        T=T,
        T_injected=T_in,
        pressure=float(np.average(model.p, weights=volumes)),
        conductivity=float(np.average(model.conductivity, weights=volumes)),
        rho_c=float(np.average(rho_c, weights=volumes)),
        water_rho=water.rho,
        water_c=water.c,
        heat_in_place=hot,
        halved=bool(model.fractures),
        wells={well.name: _well(model, well) for well in model.wells},
        flow=_flow(model, water, lower, upper),
        edges=tuple(tuple(map(float, edges)) for edges in grid.edges),
        cracks=cracks,
        tolerance=model.tolerance,
    )


def volumes_within(grid: Grid, lower: Sequence[float], upper: Sequence[float]) -> np.ndarray:
    """Return the volume of each cell within a box (m^3), shape (n_cells,).

    Parameters
    ----------
    grid : the cells.
    lower, upper : corners of the box (m); in 2-D it goes through the whole thickness.
    """
    inside = [
        np.diff(np.clip(edges, low, high))
        for edges, low, high in zip(grid.edges, lower, upper, strict=False)
    ]
    inside += [np.diff(edges) for edges in grid.edges[len(inside) :]]
    x, y, z = inside
    return np.asarray((x[:, None, None] * y[:, None] * z).ravel(order="F"))


def _injected(wells: Sequence[Well]) -> float | None:
    """Return the mean temperature of injected water: by rate, where all rates are given."""
    found = [(well.T, well.rate) for well in wells if well.T is not None]
    if not found:
        return None
    given = [rate for _, rate in found if rate]
    return float(
        np.average([T for T, _ in found], weights=given if len(given) == len(found) else None)
    )


def _well(model: ReservoirModel, well: Well) -> WellFacts:
    cells = list(well.cells)
    return WellFacts(
        at=tuple(map(float, model.grid.centers[cells].mean(axis=0))),
        T_rock=float(model.T[cells].mean()),
        p_rock=float(model.p[cells].mean()),
        rate=well.rate,
        pressure=well.pressure,
        T=well.T,
    )


def _flow(
    model: ReservoirModel, water: ConstantWater, lower: Sequence[float], upper: Sequence[float]
) -> FractureFlow | None:
    """Return the flow along the only fracture of a 2-D body, None where no closed form applies.

    That has uniform tight rock beside the fracture, and one well at each end of it. The rate of the
    injector is that of half the fracture.
    """
    grid = model.grid
    if grid.dim != 2 or len(model.fractures) != 1:
        return None
    axis, end = model.fractures[0].side
    edges, half = grid.edges[axis], model.fractures[0].height / 2
    face = upper[axis] + half if end > 0 else lower[axis] - half
    row = np.zeros(grid.size, dtype=bool)
    row[grid.row((axis, end))] = True
    ends = _ends(model, row)
    is_last = np.isclose(edges[-1 if end > 0 else 0], face, rtol=0, atol=ALIKE * np.ptp(edges))
    if ends is None or not (is_last and _is_tight(model, row, axis) and _is_uniform(model, row)):
        return None
    cells = [cell for well in ends for cell in well.cells]
    far = grid.centers[cells, 1 - axis] + np.outer([-0.5, 0.5], grid.sizes[cells, 1 - axis])
    rate, length = ends[0].rate, float(np.ptp(far))
    if not rate or set(ends[0].cells) & set(ends[1].cells):
        return None
    return FractureFlow(
        q=2 * rate / (water.rho * float(np.ptp(grid.edges[2]))),
        length=length,
        half_spacing=float(np.ptp(edges)) - half,
        stored=float(model.capacity(water)[row].mean()) * half,
    )


def _ends(model: ReservoirModel, row: np.ndarray) -> tuple[Well, Well] | None:
    """Return the injector and the producer, if there is one of each, in the fracture's cells."""
    injectors = [well for well in model.wells if well.T is not None]
    producers = [well for well in model.wells if well.T is None]
    inside = all(row[list(well.cells)].all() for well in model.wells)
    if not (inside and len(injectors) == len(producers) == 1):
        return None
    return injectors[0], producers[0]


def _is_tight(model: ReservoirModel, row: np.ndarray, axis: int) -> bool:
    """Return True if hardly any water flows beside the fracture."""
    beside = np.where(row, 0.0, largest_along(model.permeability)) * model.grid.sizes[:, axis]
    layers = beside.reshape(model.grid.shape, order="F").max(axis=1 - axis).sum()
    return bool(layers < LEAK * model.fractures[0].opening ** 3 / 24)


def _is_uniform(model: ReservoirModel, row: np.ndarray) -> bool:
    """Return True if rock beside the fracture, and all temperatures, are the same everywhere."""
    values = (model.conductivity[~row], model.rho_c[~row], model.porosity[~row], model.T)
    return all(np.ptp(v) <= ALIKE * np.abs(v).max() for v in values)
