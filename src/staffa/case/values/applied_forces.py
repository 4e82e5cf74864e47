"""Case -> what acts on the body besides cold."""

from typing import Any

import numpy as np

from staffa.case.schema.case import Case
from staffa.case.schema.field_types import Formula
from staffa.case.schema.force_keys import ForceKeys, Prestress, SideForce
from staffa.case.values.heat_equation import in_time
from staffa.case.values.property_functions import in_space
from staffa.case.values.reservoir_places import fractured_sides
from staffa.loads.forces import Forces, InSpace, InSpaceAndTime, InTime, Traction
from staffa.properties.formula import formula, formula_variables, uses

# In the order of `loads.forces.Forces.prestress`.
COMPONENTS = ("xx", "yy", "zz", "yz", "xz", "xy")


def forces(case: Case) -> Forces:
    """Return the forces of the table [forces]."""
    keys, dim = case.forces, case.dim
    if keys is None:
        return Forces(**_of_water(case))
    return Forces(
        gravity=None if keys.gravity is None else tuple(float(g) for g in keys.gravity),
        sides=tuple(_traction(name, side, dim) for name, side in keys.by_side().items()),
        prestress=None if keys.prestress is None else _prestress(keys.prestress, dim),
        pore_pressure=_in_pores(keys, dim),
        crack_pressure=(
            None if _varies_in_place(keys.crack_pressure) else _of_time(keys, "crack_pressure")
        ),
        crack_field=_in_cracks(keys, dim),
        crack_volume=_of_time(keys, "crack_volume"),
        **_of_water(case),
    )


def _in_pores(keys: ForceKeys, dim: int) -> InSpaceAndTime | None:
    if keys.pore_pressure is None:
        return None
    if isinstance(keys.pore_pressure, Formula):
        return _of_place_and_time(keys.pore_pressure, dim)
    value = in_space(keys.pore_pressure, dim)
    return lambda x, t: value(x)


def _in_cracks(keys: ForceKeys, dim: int) -> InSpaceAndTime | None:
    """Return the pressure in cracks where a formula makes it depend on the place."""
    value = keys.crack_pressure
    if not isinstance(value, Formula) or not _varies_in_place(value):
        return None
    return _of_place_and_time(value, dim)


def _varies_in_place(value: Any) -> bool:
    """Return True if a value of [forces] is a formula of x, y or z."""
    return isinstance(value, Formula) and any(uses(value.formula, name) for name in "xyz")


def _of_place_and_time(value: Formula, dim: int) -> InSpaceAndTime:
    function = formula(value.formula, formula_variables(dim))
    return lambda x, t: np.zeros(x.shape[1]) + function(x, t)


def _of_water(case: Case) -> dict[str, Any]:
    """Return what Biot's coefficient acts on, and where the water of a reservoir presses."""
    water, forces = case.reservoir, case.forces
    if water is None:
        given = None if forces is None else forces.biot
        return {"biot": 1.0 if given is None else given}
    by_default = 0.0 if case.plane_stress else 1.0  # in plane stress pores press the plate apart
    return {
        "biot": by_default if water.biot is None else water.biot,
        "fluid": water.fields is None or water.fields.p is not None,
        "fluid_sides": tuple(fractured_sides(case)),
        "balanced": forces is None or forces.prestress is None,
    }


def pore_pressure_at_rest(case: Case) -> InSpace:
    """Return the pressure in the pores before the first step that counts beside a prestress."""
    acting, water = forces(case), case.reservoir
    if not acting.fluid or acting.balanced or water is None:
        in_pores = acting.pore_pressure
        return lambda x: np.zeros(x.shape[1]) if in_pores is None else in_pores(x, 0.0)
    if water.fields is not None:
        pressure = water.fields.series.reaching(case.outline.h).pressure
        assert pressure is not None
        return lambda x: pressure(x, 0.0)
    return in_space(water.pressure, case.dim)


def _prestress(keys: Prestress, dim: int) -> InSpace:
    given = [getattr(keys, name) for name in COMPONENTS]
    parts = [None if value is None else in_space(value, dim) for value in given]

    def stress(x: np.ndarray) -> np.ndarray:
        return np.array([np.zeros(x.shape[1]) if part is None else part(x) for part in parts])

    return stress


def _traction(name: str, side: SideForce, dim: int) -> Traction:
    components = [getattr(side, axis) for axis in "xyz"[:dim]]
    parts = [None if value is None else in_time(value, dim) for value in components]

    def force(x: np.ndarray, t: float) -> np.ndarray:
        zero = np.zeros(x.shape[1])
        return np.array([zero if part is None else zero + part(x, t) for part in parts])

    pressed = None if side.pressure is None else in_time(side.pressure, dim)

    def pressure(x: np.ndarray, t: float) -> np.ndarray:
        assert pressed is not None
        return np.zeros(x.shape[1]) + pressed(x, t)

    return Traction(
        side=name,
        force=force if any(part is not None for part in parts) else None,
        pressure=None if pressed is None else pressure,
    )


def _in_time(value: Any) -> InSpaceAndTime:
    function = formula(value.formula, ("t",)) if isinstance(value, Formula) else in_time(value, 0)
    return lambda x, t: np.full(x.shape[1], function(x, t))


def _of_time(keys: ForceKeys, name: str) -> InTime | None:
    value = getattr(keys, name)
    if value is None:
        return None
    function, nowhere = _in_time(value), np.zeros((3, 1))
    return lambda t: float(np.ravel(function(nowhere, t))[0])
