"""Case -> the model that a reservoir simulator is given."""

import numpy as np

from staffa.case.schema.case import Case
from staffa.case.schema.field_types import ONE
from staffa.case.schema.fracture_keys import FractureDisc, FractureLine
from staffa.case.schema.reservoir_keys import WaterKeys
from staffa.case.values.property_functions import in_space
from staffa.case.values.reservoir_places import (
    beyond,
    cell_size,
    other_fractures,
    reservoir_keys,
    side_fractures,
    thickness,
    well_place,
)
from staffa.case.values.subdomains import box_of, subdomains_of
from staffa.geometry.places import in_box
from staffa.reservoir.grid import Grid, grid_around
from staffa.reservoir.permeability import Plane, with_planes, with_rows
from staffa.reservoir.simulator import ConstantWater, ReservoirModel, Well
from staffa.units import SMALLEST


def reservoir_model(case: Case) -> ReservoirModel:
    """Return the model of a case with a simulator."""
    keys, grid = reservoir_keys(case), reservoir_grid(case)
    x = places(grid)
    model = ReservoirModel(
        grid=grid,
        permeability=with_planes(grid, _with_boxes(case, grid, "permeability"), _planes(case)),
        porosity=_with_boxes(case, grid, "porosity"),
        conductivity=_of_rock(case, ("k",), x),
        rho_c=_of_rock(case, ("rho", "c"), x),
        T=in_space(keys.temperature, case.dim)(x),
        p=in_space(keys.pressure, case.dim)(x),
        water=constant_water(case),
        wells=wells(case, grid),
        tolerance=keys.tolerance,
        gravity=_gravity(case),
        fractures=side_fractures(case),
    )
    return with_rows(model)


def reservoir_grid(case: Case) -> Grid:
    """Return the cells of the reservoir: even ones in the body, growing ones beyond it."""
    return grid_around(
        case.outline.lower,
        case.outline.upper,
        cell_size(case),
        beyond=beyond(case),
        fractures={fracture.side: fracture.height for fracture in side_fractures(case)},
        thickness=thickness(case),
    )


def places(grid: Grid) -> np.ndarray:
    """Return the centers of cells as points of formulas and files (m), shape (3, n_cells)."""
    x = grid.centers.T.copy()
    x[grid.dim :] = 0.0
    return x


def _planes(case: Case) -> tuple[Plane, ...]:
    """Return the fractures within the reservoir."""
    return tuple(_plane(fracture) for fracture in other_fractures(case))


def _plane(keys: FractureLine | FractureDisc) -> Plane:
    opening = float(keys.opening)
    if isinstance(keys, FractureLine):
        (x, y), (x1, y1) = keys.start, keys.end
        return Plane(opening=opening, start=(float(x), float(y)), end=(float(x1), float(y1)))
    (x, y, z), (a, b, c) = keys.center, keys.normal
    center, normal = (float(x), float(y), float(z)), (a, b, c)
    return Plane(opening=opening, center=center, normal=normal, radius=float(keys.radius))


def _with_boxes(case: Case, grid: Grid, name: str) -> np.ndarray:
    """Return permeability (m^2) or porosity of the rock in each cell, shape (n_cells,).

    Parallel fractures in closed form need neither: it is then as small as a number can be.
    """
    keys, x = reservoir_keys(case), places(grid)
    value = getattr(keys, name)
    found = np.array(in_space(SMALLEST if value is None else value, case.dim)(x), dtype=float)
    for box in keys.boxes:
        own = getattr(box, name)
        if own is not None:
            found[in_box(box.lower, box.upper, x, h=cell_size(case))] = float(own)
    return found


def _of_rock(case: Case, names: tuple[str, ...], x: np.ndarray) -> np.ndarray:
    """Return the product of properties of the rock, shape (n,): beyond the body those of its
    nearest place."""
    x = x.copy()
    lower, upper = np.array([case.outline.lower, case.outline.upper])[:, :, np.newaxis]
    x[: case.dim] = np.clip(x[: case.dim], lower, upper)
    body, *regions = subdomains_of(case)
    pieces = [(body, np.ones(x.shape[1], dtype=bool))]
    for piece, keys in zip(regions, case.regions.values(), strict=True):
        box = box_of(case, keys)
        assert box is not None  # a block's regions are boxes
        pieces.append((piece, in_box(*box, x, h=case.outline.h)))
    found = np.ones(x.shape[1])
    for piece, there in pieces:
        values = [in_space(getattr(piece.keys, n) or ONE, case.dim)(x[:, there]) for n in names]
        found[there] = np.prod(values, axis=0)
    return found


def constant_water(case: Case) -> ConstantWater | None:
    """Return the water's properties; None for those of IAPWS."""
    keys = reservoir_keys(case).water
    if not isinstance(keys, WaterKeys):
        return None
    return ConstantWater(rho=float(keys.rho), c=float(keys.c), mu=float(keys.mu), k=float(keys.k))


def wells(case: Case, grid: Grid) -> tuple[Well, ...]:
    """Return the wells, each open to the cell that it lies in."""
    return tuple(
        Well(
            name=keys.name,
            cells=(grid.cell_at(well_place(case, keys)),),
            rate=None if keys.rate is None else float(keys.rate),
            pressure=None if keys.pressure is None else float(keys.pressure),
            T=None if keys.T is None else float(keys.T),
            radius=float(keys.radius),
        )
        for keys in reservoir_keys(case).wells
    )


def _gravity(case: Case) -> tuple[float, float, float]:
    given = None if case.forces is None else case.forces.gravity
    x, y, z, *_ = (*(float(g) for g in given or ()), 0.0, 0.0, 0.0)
    return x, y, z
