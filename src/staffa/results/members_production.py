"""Production of an ensemble in numbers: of each member, and means over time with their errors."""

from collections.abc import Mapping
from math import isfinite

from staffa.display_units import KELVIN, Unit
from staffa.io.ensemble_directory import Ensemble
from staffa.io.production_rows import paired_production
from staffa.io.run_directory import Run
from staffa.plot.ensemble_production import production_spreads
from staffa.results.crack_changes import CrackChanges
from staffa.results.production_table import UNITS, production_numbers
from staffa.results.tables import Cell, Column, Table

# Columns of the numbers of a member, by their names on its page.
NUMBERS = {
    "breakthrough": "thermal breakthrough",
    "drawdown_of_0.1": "drawdown of 10 %",
    "T": "production temperature",
    "power": "power",
    "energy": "energy",
    "peak_pressure": "peak pressure",
    "exchange_area": "exchange area",
}
PERCENT = Unit(name="%", size=0.01)
MEMBERS = (
    "At the end, power as its mean over the last step, as on each page; a time that a "
    "member does not reach is no part of the mean. production_means.csv has the curves.",
    "Change: with cracks less without.",
)


def members_production(ensemble: Ensemble) -> dict[int, dict[Column, float | None]]:
    """Return the numbers of the production of each finished member, by seed; empty without water.

    Parameters
    ----------
    ensemble : the ensemble.
    """
    units: dict[str, Unit] = {}
    for run in ensemble.finished.values():  # the units of the first count for all
        units = {one.name: one.unit for one in production_numbers(run)} | units
    return {seed: water_numbers(run, units) for seed, run in ensemble.finished.items()}


def water_numbers(run: Run, units: Mapping[str, Unit] | None = None) -> dict[Column, float | None]:
    """Return the production of a run, and the changes that cracks make; empty without water.

    Parameters
    ----------
    run : the run.
    units : unit of each number; None for those of the run.
    """
    units = units or {one.name: one.unit for one in production_numbers(run)}
    known = {one.name: one.value for one in production_numbers(run)}
    found: dict[Column, float | None] = {}
    for short, name in NUMBERS.items() if known else ():
        # The error of a mean has no zero, so temperatures are counted from theirs before.
        unit = Unit(name=units[name].name, size=units[name].size)
        value = known[name] - units[name].zero
        label = f"{name} at the end" if short == "T" else name
        found[Column(name=short, unit=unit, label=label)] = value if isfinite(value) else None
    if pairs := paired_production(run.manifest.reservoir, run.steps):
        changes = CrackChanges(pairs=pairs)
        told = {
            ("T_change", "change of T at the end"): (KELVIN, float(changes.T[-1])),
            ("largest_T_change", "largest change of T"): (KELVIN, float(max(changes.T, key=abs))),
            ("energy_change", "change of energy"): (PERCENT, changes.energy),
        }
        for (short, label), (unit, value) in told.items():
            column = Column(name=short, unit=unit, label=label)
            found[column] = value if isfinite(value) else None
    return found


def production_means(ensemble: Ensemble) -> Table:
    """Return production_means.csv: at each time the means and their standard errors, in SI units.

    Parameters
    ----------
    ensemble : the ensemble; without two finished members with water there are no rows.
    """
    found = production_spreads(list(ensemble.finished.values()))
    if not found:
        return Table()
    columns = [Column(name="time", unit=Unit(name="s")), Column(name="members")]
    times = found["T"].at.tolist()
    rows: list[list[Cell]] = [[time, len(ensemble.finished)] for time in times]
    for name, seen in found.items():
        unit = Unit(name=UNITS[name.removesuffix("_without").removesuffix("_change")])
        columns += [Column(name=name, unit=unit), Column(name=f"{name}_error", unit=unit)]
        at = dict(zip(seen.at.tolist(), zip(seen.mean, seen.error, strict=True), strict=True))
        for row in rows:
            row += [_cell(value) for value in at.get(row[0], (None, None))]
    return Table(columns=tuple(columns), rows=tuple(map(tuple, rows)))


def _cell(value: float | None) -> Cell:
    """Return a number, or None for one that is none."""
    return float(value) if value is not None and isfinite(value) else None
