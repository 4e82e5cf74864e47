"""Rules on the wells of [reservoir]: what each is told, and where it lies."""

import re

from staffa.case.schema.case import Case
from staffa.case.schema.reservoir_keys import WellKeys
from staffa.case.schema.toml_text import inline
from staffa.case.values.reservoir_model import reservoir_grid
from staffa.case.values.reservoir_places import is_in_reservoir, reservoir_extent, well_place
from staffa.errors import InputError

# Names of columns, and of parts of pictures' names.
USABLE = re.compile(r"\w[\w .-]*")


def wells_are_complete(case: Case) -> None:
    """Require of each well a rate or a pressure, and a temperature of injectors alone."""
    keys = case.reservoir
    if keys is None:
        return
    for number, well in enumerate(keys.wells, start=1):
        _well_is_complete(f"reservoir.wells, entry {number} ('{well.name}')", well)


def _well_is_complete(where: str, well: WellKeys) -> None:
    if (well.rate is None) == (well.pressure is None):
        how = "neither is given" if well.rate is None else "both are given"
        raise InputError(f"{where}: rate and pressure: {how}; give exactly one of them")
    if well.rate is None:
        return
    if not well.rate:
        raise InputError(
            f"{where}, rate = {inline(well.rate)}: nothing flows; give a rate above zero (an "
            f"injector), below zero (a producer), or leave the well out"
        )
    if well.rate > 0 and well.T is None:
        raise InputError(
            f"{where}, rate = {inline(well.rate)}: it injects, and the temperature of its water is "
            f'missing; write it like T = "60 °C"; a producer has a negative rate'
        )
    if well.rate < 0 and well.T is not None:
        raise InputError(
            f"{where}, T = {inline(well.T)}: it produces, with rate = {inline(well.rate)}, and its "
            f"temperature follows; leave T out; an injector has a positive rate"
        )


def wells_are_apart(case: Case) -> None:
    """Require an injector and a producer, and of each well a unique name that columns can have."""
    keys = case.reservoir
    if keys is None or keys.simulator == "fields":
        return
    names: set[str] = set()
    for number, well in enumerate(keys.wells, start=1):
        where = f"reservoir.wells, entry {number}, name = {inline(well.name)}"
        if not USABLE.fullmatch(well.name):
            raise InputError(
                f"{where}: it names columns and pictures; begin with a letter or a digit, and take "
                f"letters, digits, spaces, '.', '-' and '_' alone"
            )
        if well.name.casefold() in names:
            raise InputError(
                f"{where}: an entry before it has this name; choose another, since "
                f"production.csv tells wells apart by it"
            )
        names.add(well.name.casefold())
    if not any(well.injects for well in keys.wells):
        raise InputError(
            "reservoir.wells: there is no injector, so that nothing cools the rock; add one with a "
            'rate or a pressure, and T, the temperature of its water, like T = "60 °C"'
        )
    if all(well.injects for well in keys.wells):
        raise InputError(
            "reservoir.wells: there is no producer, so that the water has no way out; add one with "
            'a negative rate, or with a pressure and without T, like pressure = "20 MPa"'
        )


def wells_are_inside(case: Case) -> None:
    """Require places in the reservoir, no two wells in one cell."""
    keys = case.reservoir
    if keys is None or keys.simulator == "fields":
        return
    grid = reservoir_grid(case)
    found: dict[int, str] = {}
    for number, well in enumerate(keys.wells, start=1):
        where = f"reservoir.wells, entry {number} ('{well.name}'), at = {inline(well.at)}"
        if len(well.at) != case.dim:
            raise InputError(f"{where}: it needs {case.dim} numbers, as the body is {case.dim}-D")
        if not is_in_reservoir(case, well.at):
            raise InputError(
                f"{where} lies outside of the reservoir, {reservoir_extent(case)}; move it in, or "
                f"let reservoir.beyond reach it"
            )
        other = found.setdefault(grid.cell_at(well_place(case, well)), well.name)
        if other != well.name:
            raise InputError(
                f"{where}: '{other}' is in the same cell of the reservoir, and the water of one "
                f"would come out of the other; move one of them, or take a smaller reservoir.h"
            )
