"""Rules on the numbers of [reservoir]: possible rock, liquid water, fractures within."""

import numpy as np

from staffa.case.rules.time_rules import times_given
from staffa.case.schema.case import Case
from staffa.case.schema.fracture_keys import FractureLine, FractureSide
from staffa.case.schema.quantity_text import amount
from staffa.case.schema.reservoir_keys import IAPWS
from staffa.case.schema.toml_text import as_toml, inline
from staffa.case.values.property_functions import in_space
from staffa.case.values.reservoir_model import reservoir_model
from staffa.case.values.reservoir_places import is_in_reservoir, reservoir_extent, sampled
from staffa.errors import InputError
from staffa.physics.saturation import saturation_pressure
from staffa.reservoir.single import SingleFracture

RANGES = {
    "temperature": (0.0, np.inf, "finite and above absolute zero"),
    "pressure": (0.0, np.inf, "finite and larger than zero"),
    "permeability": (0.0, np.inf, "finite and larger than zero"),
    "porosity": (0.0, 1.0, "larger than 0 and less than 1"),
}
# Below the critical point, where properties of water change too fast to be interpolated.
HOTTEST = 623.15  # K
COLDEST, HIGHEST = 274.15, 2e8  # K, Pa: beyond them the simulator has no properties of water


def reservoir_values_are_possible(case: Case) -> None:
    """Require possible values of all that is given in space, at sampled places."""
    keys = case.reservoir
    if keys is None or keys.simulator == "fields":
        return
    x = sampled(case)
    for name, (least, most, rule) in RANGES.items():
        value = getattr(keys, name)
        if value is None:
            continue
        where = f"reservoir.{name} = {as_toml(value)}"
        try:
            with np.errstate(all="ignore"):
                found = np.asarray(in_space(value, case.dim)(x), dtype=float)
        except InputError as error:
            raise InputError(f"{where}: {error}") from None
        bad = ~((found > least) & (found < most))
        if bad.any():
            at = " ".join(f"{c:.4g}" for c in x[: case.dim, np.argmax(bad)])
            raise InputError(
                f"{where}: it is {found[np.argmax(bad)]:.4g} at ({at}) m, and must be {rule} in "
                f"all of the reservoir; change it, or take a file that covers it"
            )
    for number, box in enumerate(keys.boxes, start=1):
        where = f"reservoir.boxes, entry {number}"
        if box.permeability is None and box.porosity is None:
            raise InputError(f"{where} changes nothing; give permeability or porosity")
        for name in ("lower", "upper"):
            _has_a_number_an_axis(case, f"{where}, {name}", getattr(box, name))
        if any(low >= high for low, high in zip(box.lower, box.upper, strict=True)):
            raise InputError(
                f"{where}: lower = {inline(box.lower)} must lie below upper = {inline(box.upper)} "
                f"along each axis; swap or move them"
            )


def _has_a_number_an_axis(case: Case, where: str, given: tuple[float, ...]) -> None:
    if len(given) != case.dim:
        raise InputError(
            f"{where} = {inline(given)}: it needs {case.dim} numbers, as the body is {case.dim}-D"
        )


def fractures_are_inside(case: Case) -> None:
    """Require lines in 2-D and discs in 3-D, within the reservoir."""
    if case.reservoir is None or case.reservoir.simulator == "fields":
        return
    for number, fracture in enumerate(case.reservoir.fractures, start=1):
        where = f"reservoir.fractures, entry {number}"
        if isinstance(fracture, FractureSide):
            continue
        if isinstance(fracture, FractureLine) != (case.dim == 2):
            needs = "start and end" if case.dim == 2 else "center, radius and normal"
            raise InputError(
                f"{where}: a fracture of a {case.dim}-D body has {needs}, or a side; give these"
            )
        if isinstance(fracture, FractureLine):
            _point_is_inside(case, f"{where}, start", fracture.start)
            _point_is_inside(case, f"{where}, end", fracture.end)
            if fracture.start == fracture.end:
                said = inline(fracture.end)
                raise InputError(f"{where}: start and end are both {said}; move one of them")
        else:
            _point_is_inside(case, f"{where}, center", fracture.center)
            _has_a_number_an_axis(case, f"{where}, normal", fracture.normal)
            if not any(fracture.normal):
                said = inline(fracture.normal)
                raise InputError(f"{where}, normal = {said} has no direction; give one across it")


def _point_is_inside(case: Case, where: str, point: tuple[float, ...]) -> None:
    _has_a_number_an_axis(case, where, point)
    if not is_in_reservoir(case, point):
        raise InputError(
            f"{where} = {inline(point)} lies outside of the reservoir, "
            f"{reservoir_extent(case)}; move it in"
        )


def water_is_liquid(case: Case) -> None:
    """Require pressures above saturation where the water's properties are those of IAPWS."""
    keys = case.reservoir
    if keys is None or keys.simulator == "fields" or keys.water != IAPWS:
        return
    x = sampled(case)
    T, p = (in_space(value, case.dim)(x) for value in (keys.temperature, keys.pressure))
    hottest = float(T.max())
    for worst in (float(T.min()), hottest):
        _is_in_range(f"reservoir.temperature = {as_toml(keys.temperature)}", worst)
    _is_compressed(case, f"reservoir.pressure = {as_toml(keys.pressure)}", float(p.max()))
    margin = p / saturation_pressure(T)
    worst_place = int(np.argmin(margin))
    if margin[worst_place] <= 1:
        where = f"reservoir.pressure = {as_toml(keys.pressure)}"
        _boils(case, where, p[worst_place], T[worst_place])
    for number, well in enumerate(keys.wells, start=1):
        where = f"reservoir.wells, entry {number} ('{well.name}')"
        if well.T is not None:
            _is_in_range(f"{where}, T = {inline(well.T)}", float(well.T))
        if well.pressure is None:
            continue
        said = f"{where}, pressure = {inline(well.pressure)}"
        _is_compressed(case, said, float(well.pressure))
        coldest = float(well.T) if well.T is not None else hottest
        if well.pressure <= saturation_pressure(np.array(coldest)):
            _boils(case, said, float(well.pressure), coldest)


def _is_in_range(where: str, T: float) -> None:
    if not COLDEST <= T <= HOTTEST:
        raise InputError(
            f'{where}: it reaches {T - 273.15:.4g} °C, and water = "{IAPWS}" is liquid water of 1 '
            f"to 350 °C; take a temperature between these, or constant properties"
        )


def _is_compressed(case: Case, where: str, p: float) -> None:
    if p > HIGHEST:
        raise InputError(
            f'{where}: it reaches {amount(case, p, "Pa")}, and water = "{IAPWS}" is known up to '
            f"{amount(case, HIGHEST, 'Pa')}; take a lower pressure, or constant properties"
        )


def _boils(case: Case, where: str, p: float, T: float) -> None:
    bound = float(saturation_pressure(np.array(T)))
    raise InputError(
        f"{where}: water of {T - 273.15:.4g} °C boils below {amount(case, bound, 'Pa')}, and water "
        f'= "{IAPWS}" here is liquid alone, at {amount(case, p, "Pa")} it is not; give a higher '
        f"pressure, or constant properties"
    )


def fields_reach_the_end(case: Case) -> None:
    """Require files from 0 to the end of the run, over all of the body."""
    keys = case.reservoir.fields if case.reservoir is not None else None
    if keys is None:
        return
    if float(keys.t[0]) > 0:
        raise InputError(
            f"reservoir.fields.t begins at {inline(keys.t[0])}, and the state before the first "
            f'step is needed; give a file at t = "0 s" too'
        )
    last = float(times_given(case)[-1])
    if float(keys.t[-1]) < last:
        raise InputError(
            f"reservoir.fields.t ends at {inline(keys.t[-1])}, before the run, which goes to "
            f"{amount(case, last, 's', digits=6)}; give a later file, or end the run earlier"
        )
    places, series = case.outline.places.on(), keys.series.reaching(case.outline.h)
    for field in (*series.T, *(series.p or ())):
        if not np.all(np.isfinite(field(places))):
            low, high = (", ".join(f"{c:.4g}" for c in corner) for corner in field.bounds)
            raise InputError(
                f"reservoir.fields, {field.path.name}: its mesh, from ({low}) to ({high}) m, does "
                f"not cover the body; if its coordinates count in another unit, say so, like "
                f'unit = "1 mm"'
            )


def single_describes_it(case: Case) -> None:
    """Require of a case with the closed form what it describes, as the engine itself tells."""
    if case.reservoir is None or case.reservoir.simulator != "single":
        return
    try:
        SingleFracture(reservoir_model(case))
    except InputError as error:
        raise InputError(f"[reservoir]: {error}") from None
