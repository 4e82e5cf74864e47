"""Rules on the table [heat], and on the numbers of the rock that it needs."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from staffa.case.rules.time_rules import table_agrees, times_given
from staffa.case.schema.case import Case
from staffa.case.schema.field_types import Formula
from staffa.case.schema.heat_keys import Geotherm, HeatCracks, HeatKeys, HeatSide, InTime
from staffa.case.schema.material_keys import RockKeys
from staffa.case.schema.quantity_text import is_scaled
from staffa.case.schema.toml_text import as_toml, inline
from staffa.case.values.diffusion_time import times_in
from staffa.errors import InputError
from staffa.properties.formula import formula, formula_variables, trial
from staffa.units import Quantity

START = ("initial", "stress_free")
ROUND_OFF = 1e-9  # part of a temperature: "20 °C" and "68 degF" may differ in a digit
TRIED = 21  # times at which a formula is tried


def heat_has_its_profile(case: Case) -> None:
    """Require the table exactly with temperature.profile = "heat", and the rock's numbers that go
    with the profile."""
    profile = f'temperature.profile = "{case.temperature.profile}"'
    if case.temperature.profile != "heat" and case.heat is not None:
        raise InputError(
            f"[heat] has no meaning with {profile}; leave it out or take temperature.profile = "
            f'"heat"'
        )
    if not case.conducts:
        _conducts_nothing(case, profile)
        return
    if case.temperature.profile == "heat" and case.heat is None:
        raise InputError(
            f"[heat] is missing: {profile} needs the temperature at the start and what enters or "
            f'leaves; write it like [heat] with initial = "20 °C" and bottom = {{ T = "5 °C" }} '
            f"below it"
        )
    if case.material.kappa is not None:
        raise InputError(
            f"material.kappa = {inline(case.material.kappa)} has no meaning with {profile}, where "
            f"it is k/(rho c); leave it out and give k, rho and c"
        )


def _conducts_nothing(case: Case, profile: str) -> None:
    """Refuse numbers of conduction where the temperature is known without them."""
    weighs = case.forces is not None and case.forces.gravity is not None
    for where, table in _rocks(case):
        for name in ("k", "c") if weighs else ("k", "rho", "c"):
            given = getattr(table, name)
            if given is not None:
                own = ", which is k/(rho c)" if where == "material" else " in [material]"
                instead = f" and give kappa{own}" if case.temperature.cools_a_face else ""
                raise InputError(
                    f"{where}.{name} = {as_toml(given)} has no meaning with {profile}; leave "
                    f"it out{instead}"
                )


def _rocks(case: Case) -> list[tuple[str, RockKeys]]:
    regions = [(f"regions.{name}", region) for name, region in case.regions.items()]
    return [("material", case.material), *regions]


def heat_fits_the_body(case: Case) -> None:
    """Require gradients and sides of the body's dimension."""
    keys = case.heat
    if keys is None:
        return
    for name in START:
        if isinstance(given := getattr(keys, name), Geotherm):
            _has_a_number_an_axis(case, f"heat.{name}.gradient", given.gradient)


def _has_a_number_an_axis(case: Case, where: str, given: tuple[float, ...]) -> None:
    if len(given) != case.dim:
        raise InputError(
            f"{where} = {inline(given)}: it needs {case.dim} numbers, as the body is {case.dim}-D"
        )


def heat_is_complete(case: Case) -> None:
    """Require that the keys of sides, cracks, bands and tables of [heat] fit together."""
    keys = case.heat
    if keys is None:
        return
    for side in case.outline.faces:
        given = keys.on(side)
        if given is not None:
            _side_is_complete(f"heat.{side}", given)
    if keys.cracks is not None:
        _cracks_are_complete("heat.cracks", keys.cracks)
    for number, band in enumerate(keys.bands, start=1):
        if not {"k", "capacity"} & band.model_fields_set:
            raise InputError(
                f"heat.bands, entry {number} changes nothing; give k, a factor on material.k, or "
                f"capacity, one on material.rho times material.c"
            )
    for where, value, _ in _values(case, keys):
        if isinstance(value, InTime):
            table_agrees(where, value.t, value.value, "value")


def _given(table: HeatSide | HeatCracks | None) -> list[str]:
    fields = type(table).model_fields if table is not None else {}
    return [name for name in fields if getattr(table, name) is not None]


def _side_is_complete(where: str, side: HeatSide) -> None:
    given, says = _given(side), f"{where} = {as_toml(side)}"
    if not given:
        raise InputError(
            f"{says} says nothing; give T (prescribed), flux (heat that enters), or h and T (a "
            f"film and the bath beyond it), or leave it out to insulate the side"
        )
    if given == ["h"]:
        raise InputError(
            f'{says} is a film without a bath; add the bath\'s temperature, like T = "5 °C"'
        )
    if "flux" in given and len(given) > 1:
        raise InputError(
            f"{says}: a side cannot have a given flux and a given temperature; leave out flux, or "
            f"leave out {' and '.join(name for name in given if name != 'flux')}"
        )


def _cracks_are_complete(where: str, cracks: HeatCracks) -> None:
    given, says = _given(cracks), f"{where} = {as_toml(cracks)}"
    if not given:
        raise InputError(
            f"{says} says nothing; give conductivity (the fraction left across a crack), or h and "
            f"T (of a fluid in them), or leave it out"
        )
    if "conductivity" in given and len(given) > 1:
        raise InputError(
            f"{says}: cracks hinder heat (conductivity) or are full of a fluid (h and T); leave "
            f"one of them out"
        )
    if given == ["h"]:
        raise InputError(f'{says} has no temperature of the fluid; add it, like T = "5 °C"')
    if given == ["T"]:
        raise InputError(
            f"{says} has no film between fluid and rock; add its coefficient, like "
            f'h = "500 W/(m^2 K)"'
        )


def heat_enters_or_leaves(case: Case) -> None:
    """Require a change of temperature, or a strain by it.

    It comes from a side, a source, a fluid in the cracks, an initial temperature that is not
    uniform, or one that differs from `stress_free`.
    """
    keys = case.heat
    if keys is None:
        return
    sides = any(keys.on(side) is not None for side in case.outline.faces)
    bath = keys.cracks is not None and keys.cracks.h is not None
    if not (sides or bath or keys.source is not None or _evens_out(keys) or _is_strained(keys)):
        raise InputError(
            "[heat] heats and cools nothing: no side is named, no source, no fluid in the cracks, "
            "and the body starts even and free of stress; give one of them, like "
            'bottom = { T = "5 °C" }, or stress_free, the temperature at which it was joined'
        )


def _evens_out(keys: HeatKeys) -> bool:
    """Return True if the initial temperature is not the same everywhere."""
    start = keys.initial
    return isinstance(start, Formula) or (
        isinstance(start, Geotherm) and any(float(slope) != 0 for slope in start.gradient)
    )


def _is_strained(keys: HeatKeys) -> bool:
    """Return True if the body starts at another temperature than the one without thermal strain."""
    free, start = keys.stress_free, keys.initial
    if isinstance(free, Quantity) and isinstance(start, Quantity):
        return abs(free - start) > ROUND_OFF * abs(start)
    return free is not None and free != start


def _values(case: Case, keys: HeatKeys) -> Iterator[tuple[str, Any, str | None]]:
    """Yield each value that may be a table or a formula: its key, itself, and its side if any."""
    for name in (*START, "source"):
        yield f"heat.{name}", getattr(keys, name), None
    for side in case.outline.faces:
        for name in _given(keys.on(side)):
            yield f"heat.{side}.{name}", getattr(keys.on(side), name), side
    for name in _given(keys.cracks):
        yield f"heat.cracks.{name}", getattr(keys.cracks, name), None


def formulas_give_numbers(case: Case) -> None:
    """Require that every formula gives finite numbers at sampled places and times.

    Samples leave no gap larger than a twentieth of the body or of the run. No film coefficient may
    be negative, and no temperature below absolute zero.
    """
    if case.heat is None:
        return
    visited = times_in(case, times_given(case)[[0, -1]])
    times = {*np.linspace(0.0, visited[-1], TRIED).tolist(), *visited}
    for where, value, side in _values(case, case.heat):
        if not isinstance(value, Formula) or getattr(value, "of_temperature", False):
            continue
        at_start = where.removeprefix("heat.") in START
        known = formula_variables(case.dim, time=not at_start)
        try:
            function = formula(value.formula, known)
            there = case.outline.places.on(side)
            found = [trial(function, known, there, t) for t in sorted(times)]
            coldest = float(np.min(found))
            if (where.endswith(".T") or at_start) and coldest < 0 and not is_scaled(case):
                raise InputError(
                    f"it gives K, and {coldest:g} lies below absolute zero; write 293.15 for 20 °C"
                )
            if where.endswith(".h") and np.min(found) < 0:
                raise InputError(
                    f"a film coefficient must not be negative, and there it is {np.min(found):g}"
                )
        except InputError as error:
            raise InputError(f"{where}.formula = {as_toml(value.formula)}: {error}") from None
