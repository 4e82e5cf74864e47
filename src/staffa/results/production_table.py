"""Production of a run: production.csv, and the numbers that an engineer asks for."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import isfinite, prod
from typing import Any

from staffa.display_units import NONE, Unit
from staffa.io.production_rows import (
    BREAKTHROUGH,
    COOLER,
    LATE,
    WellRow,
    first_time,
    production,
    well_rows,
)
from staffa.io.run_directory import Run
from staffa.plot.production_curves import water_units
from staffa.results.tables import Cell, Column, Table, columns_of, number

# Units of production.csv, SI and without a prefix, by column.
UNITS = {
    "time": "s",
    "rate": "kg/s",
    "T": "K",
    "pressure": "Pa",
    "power": "W",
    "heat": "J",
    "impedance": "Pa·s/kg",
    "injectivity": "kg/s/Pa",
    "area": "m²",
    "lost": "kg",
}
MEANINGS = {
    "thermal breakthrough": "first time at which the drawdown is above 1 %",
    "drawdown of 10 %": "first time at which it is above 10 %",
    "10 K less": "first time at which the water is 10 K colder than the rock was",
    "production temperature": "of the water at the end, all producers mixed",
    "power": "heat per time that the surface gets at the end",
    "energy": "heat that the surface got by the end",
    "recovered": "that heat over what the body gives as it cools to the injected water",
    "peak pressure": "highest pressure in a well at the end of a step",
    "exchange area": "one wall of a single fracture that would cool the water as at the end",
    "lost water": "injected and not produced by the end",
    "balance": "heat through the wells minus heat stored, over the latter",
}
TIMES = ("thermal breakthrough", "drawdown of 10 %", "10 K less")
NEVER = "not by the end"


@dataclass(frozen=True, kw_only=True)
class ProductionNumber:
    """Number of the whole production.

    Attributes
    ----------
    name : its name.
    value : the number (SI), NaN where there is none, infinite for a time that is not reached.
    unit : unit in which it is shown.
    meaning : what it is, in words.
    """

    name: str
    value: float
    unit: Unit
    meaning: str

    @property
    def text(self) -> str:
        """The number in words."""
        if isfinite(self.value):
            return self.unit.text(self.value)
        return NEVER if self.value > 0 else number(None)


def production_table(run: Run) -> Table:
    """Return production.csv: a row for each step and well, in SI units; no rows without water."""
    rows = well_rows(run.manifest.reservoir, run.steps)
    return Table(
        columns=tuple(Column(name=n, unit=Unit(name=UNITS.get(n, ""))) for n in WellRow._fields),
        rows=tuple(tuple(map(_cell, row)) for row in rows),
    )


def _cell(value: Any) -> Cell:
    cell: Cell = value
    return None if isinstance(value, float) and not isfinite(value) else cell


def production_numbers(run: Run) -> list[ProductionNumber]:
    """Return the numbers of the whole production, none without water."""
    found = production(run.manifest.reservoir, run.steps)
    if not found:
        return []
    shown, units, last = run.manifest.shown, water_units(run.manifest, found), found[-1]
    drawdown, fall = ([getattr(one, name) for one in found] for name in ("drawdown", "fall"))
    values = {
        "thermal breakthrough": (first_time(found, drawdown, BREAKTHROUGH), shown.time),
        "drawdown of 10 %": (first_time(found, drawdown, LATE), shown.time),
        "10 K less": (first_time(found, fall, COOLER), shown.time),
        "production temperature": (last.T, shown.temperature),
        "power": (last.power, units["power"]),
        "energy": (last.heat, units["heat"]),
        "recovered": (last.recovered, NONE),
        "peak pressure": (max(one.pressure for one in found), units["pressure"]),
        "exchange area": (last.area, Unit(name="m²")),
        "lost water": (last.lost, Unit(name="kg")),
        "balance": (last.balance, NONE),
    }
    return [
        ProductionNumber(name=name, value=value, unit=unit, meaning=MEANINGS[name])
        for name, (value, unit) in values.items()
    ]


def production_numbers_table(run: Run) -> Table:
    """Return these numbers as a table for people."""
    notes = (
        "Heat counts above that of the injected water. production.csv has the numbers of each "
        "step and well, docs/circulation.md their formulas.",
    )
    return Table(
        title="Production",
        columns=columns_of("number", "value"),
        rows=tuple((f"{one.name}: {one.meaning}", one.text) for one in production_numbers(run)),
        notes=(*notes, *_coarse_start(run)),
    )


def _coarse_start(run: Run) -> Iterator[str]:
    """Say that times within the first step are not resolved, if one is shown."""
    found = production(run.manifest.reservoir, run.steps)
    shown = {one.name: one.value for one in production_numbers(run)}
    if found and any(shown[name] < found[0].time for name in TIMES):
        first = run.manifest.shown.time.text(found[0].time)
        yield (
            f"The first step ends at {first}. A time within it is linear interpolation, and mostly "
            "too early: take a shorter first step to resolve it."
        )


def production_lines(run: Run) -> list[tuple[str, str]]:
    """Return names and texts of the lines of a summary, none without water."""
    facts, numbers = run.manifest.reservoir, production_numbers(run)
    if facts is None or not numbers:
        return []
    text = {one.name: one.text for one in numbers}
    cells = prod(len(edges) - 1 for edges in facts.edges)
    wells = ", ".join(f"'{name}'" for name in facts.wells)
    ways = f"{text['production temperature']}, {text['power']}, {text['energy']} since the start"
    times = f"thermal breakthrough {text['thermal breakthrough']}"
    return [
        ("reservoir", f"{facts.simulator}, {cells} cells, wells {wells}"),
        ("production", f"{ways}; {times}; heat balance {text['balance']}"),
    ]
