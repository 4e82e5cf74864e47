"""Production of a run: production.csv, and the numbers that an engineer asks for."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from math import isfinite, nan, prod
from typing import Any

from staffa.display_units import KELVIN, NONE, Unit, prefixed
from staffa.io.production_rows import (
    BREAKTHROUGH,
    COOLER,
    LATE,
    Production,
    first_time,
    production,
)
from staffa.io.run_directory import Run
from staffa.io.well_rows import WellRow, well_rows
from staffa.plot.production_curves import water_units
from staffa.results.crack_changes import relative
from staffa.results.crack_effect import crack_effect
from staffa.results.tables import ABSENT, Cell, Column, Table, columns_of, grouped, number

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
    "crack_area": "m²",
    "crack_volume": "m³",
}
MEANINGS = {
    "thermal breakthrough": "first time at which the drawdown is above 1 %",
    "drawdown of 10 %": "first time at which it is above 10 %",
    "10 K less": "first time at which the water is 10 K colder than the rock was",
    "production temperature": "of the water at the end, all producers mixed",
    "power": "heat per time that the surface gets, mean over the last step",
    "energy": "heat that the surface got by the end",
    "recovered": "that heat over what the body gives as it cools to the injected water",
    "peak pressure": "highest pressure in a well at the end of a step",
    "pressure difference": "between injectors and producers at the end",
    "impedance": "that difference over the mean rate of the producers in the last step",
    "exchange area": "one wall of a single fracture that would cool the water as at the end",
    "lost water": "injected and not produced by the end",
    "balance": "heat through the wells minus heat stored, over the latter",
    "crack area": "of cracks that water flows in, at the end",
    "crack volume": "of these, and of what fractures along sides opened by",
    "widest crack": "largest opening in a cell at the end",
}
TIMES = ("thermal breakthrough", "drawdown of 10 %", "10 K less")
AMOUNTS = ("power", "energy", "pressure difference", "impedance", "exchange area")
NEVER = "not by the end"
ROUND_OFF = 1e-9  # relative difference of equal numbers


@dataclass(frozen=True, kw_only=True)
class ProductionNumber:
    """Number of the whole production.

    Attributes
    ----------
    name : its name.
    value : the number (SI), NaN where there is none, infinite for a time that is not reached.
    unit : unit in which it is shown.
    meaning : what it is, in words.
    without : the same number without cracks (SI); NaN where that was not computed.
    """

    name: str
    value: float
    unit: Unit
    meaning: str
    without: float = nan

    @property
    def text(self) -> str:
        """The number in words."""
        return self._text(self.value)

    @property
    def text_without(self) -> str:
        """The number without cracks in words."""
        return self._text(self.without)

    @property
    def change(self) -> str:
        """The number less that without cracks in words, of an amount also in percent."""
        one, other = self.value, self.without
        if not (isfinite(one) and isfinite(other)):
            return ABSENT
        if abs(one - other) <= ROUND_OFF * max(abs(one), abs(other)):
            return "0"
        unit = KELVIN if self.name == "production temperature" else self.unit
        sign = "+" if one > other else ""
        text = f"{sign}{grouped((one - other) / unit.size, 3)}{unit.behind}"
        share = f" ({100 * relative(one, other):+.3g} %)"
        return text + share if self.name in AMOUNTS else text

    def _text(self, value: float) -> str:
        if isfinite(value):
            return f"{grouped(self.unit.of(value))}{self.unit.behind}"
        return NEVER if value > 0 else number(None)


def production_table(run: Run) -> Table:
    """Return production.csv: a row for each step and well, in SI units; no rows without water."""
    rows = well_rows(run.manifest.reservoir, run.steps)
    return Table(
        columns=tuple(
            Column(name=name, unit=Unit(name=UNITS.get(name.removesuffix("_without"), "")))
            for name in WellRow._fields
        ),
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
    without = _values(production(run.manifest.reservoir, run.steps, cracks=False))
    values = _values(found)
    units = _units(run, found, [values, without] if without else [values])
    if cracks := found[-1].cracks:
        values |= {"crack area": cracks.area, "crack volume": cracks.volume}
        values["widest crack"] = cracks.widest
        units["widest crack"] = prefixed("m", cracks.widest)
    return [
        ProductionNumber(
            name=name, value=value, unit=units[name], meaning=MEANINGS[name],
            without=without.get(name, nan),
        )
        for name, value in values.items()
    ]  # fmt: skip


def _values(found: Sequence[Production]) -> dict[str, float]:
    """Return the numbers of a production (SI), none of one without steps."""
    if not found:
        return {}
    last = found[-1]
    drawdown, fall = ([getattr(one, name) for one in found] for name in ("drawdown", "fall"))
    return {
        "thermal breakthrough": first_time(found, drawdown, BREAKTHROUGH),
        "drawdown of 10 %": first_time(found, drawdown, LATE),
        "10 K less": first_time(found, fall, COOLER),
        "production temperature": last.T,
        "power": last.power,
        "energy": last.heat,
        "recovered": last.recovered,
        "peak pressure": max(one.pressure for one in found),
        "pressure difference": last.drop,
        "impedance": last.impedance,
        "exchange area": last.area,
        "lost water": last.lost,
        "balance": last.balance,
    }


def _units(
    run: Run, found: Sequence[Production], values: Sequence[Mapping[str, float]]
) -> dict[str, Unit]:
    """Return the units in which these numbers are shown.

    Parameters
    ----------
    run : the run.
    found : its production.
    values : numbers with cracks, and without where these are known.
    """
    shown, units = run.manifest.shown, water_units(run.manifest, found)

    def largest(name: str) -> float:
        return max(abs(of[name]) for of in values)

    return {
        **dict.fromkeys(TIMES, shown.time),
        "production temperature": shown.temperature,
        "power": units["power"],
        "energy": units["heat"],
        "recovered": NONE,
        "peak pressure": units["pressure"],
        "pressure difference": prefixed("Pa", largest("pressure difference")),
        "impedance": prefixed("Pa·s/kg", largest("impedance")),
        "exchange area": Unit(name="m²"),
        "lost water": Unit(name="kg"),
        "balance": NONE,
        "crack area": Unit(name="m²"),
        "crack volume": Unit(name="m³"),
    }


def production_numbers_table(run: Run) -> Table:
    """Return these numbers as a table for people, with cracks and without where both are known."""
    numbers, effect = production_numbers(run), crack_effect(run)
    names: tuple[str, ...] = ("value",)
    cells: list[tuple[str, ...]] = [(one.text,) for one in numbers]
    if production(run.manifest.reservoir, run.steps, cracks=False):
        names = ("with cracks", "without", "difference")
        cells = [(one.text, one.text_without, one.change) for one in numbers]
    notes = (
        "Heat counts above that of the injected water. production.csv has the numbers of each "
        "step and well, docs/how-to/circulation.md their formulas.",
    )
    return Table(
        title="Production",
        lead=effect.text if effect else "",
        columns=columns_of("number", *names),
        rows=tuple(
            (f"{one.name}: {one.meaning}", *told) for one, told in zip(numbers, cells, strict=True)
        ),
        notes=(*notes, *_part(run), *_coarse_start(run)),
    )


def _part(run: Run) -> Iterator[str]:
    """Tell of which part of a reservoir the numbers are, if not of all of it."""
    facts = run.manifest.reservoir
    if facts is None or not (facts.halved or facts.thickness):
        return
    half = "the half of the fracture that is computed, " if facts.halved else ""
    layer = run.manifest.shown.length.text(facts.thickness) if facts.thickness else ""
    of_layer = f"in a layer of {layer}" if layer else "as its other half is a mirror image"
    yield f"Rates, power and heat are those of {half or 'the wells, '}{of_layer}."


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
    ways = f"{text['production temperature']} at the end, {text['power']} over the last step, "
    ways += f"{text['energy']} since the start"
    times = f"thermal breakthrough {text['thermal breakthrough']}"
    return [
        ("reservoir", f"{facts.simulator}, {cells} cells, wells {wells}"),
        ("production", f"{ways}; {times}; heat balance {text['balance']}"),
    ]
