"""Tables of the polygonal cells by depth, of one run or several, also as CSV."""

from collections.abc import Iterable, Iterator, Mapping, Sequence

from staffa.display_units import NONE, Unit
from staffa.io.run_directory import Run
from staffa.measure.borders import Junction
from staffa.measure.patterns import Estimate, Pattern, pattern
from staffa.records.step import CellSection, Step
from staffa.results.series import clock_columns, time_columns
from staffa.results.tables import Cell, Column, Table, columns_of, number

ESTIMATES = (
    *("area", "whole_area", "diameter", "spacing", "area_cv"),
    *("sides", "sides_variance", "hexagonality", "disorder", "t_share"),
)
# Powers of a length that they are; others have no unit.
POWERS = {"area": 2, "whole_area": 2, "diameter": 1, "spacing": 1}
SHOWN = {
    "spacing": "spacing",
    "diameter": "diameter",
    "area_cv": "area CV",
    "sides": "sides",
    "hexagonality": "hexagons",
    "t_share": "T",
}
NOTES = (
    "Inside: cells that touch no end of the body; diameters, area CV, sides and hexagons are of "
    "these. Spacing: area over the length of cracks in it, of all cells. T: the part of the "
    "junctions of three cracks at which one ends at another. Errors: standard errors, by the "
    "bootstrap over cells.",
    "Beside: cells of points that lie anywhere (Poisson-Voronoi) have 6 sides, an area CV of 0.529 "
    "and 0.295 hexagons; the columns of the Giant's Causeway about 5.65 sides.",
)


def columns(runs: Sequence[Run]) -> Table | None:
    """Return the table of the cells at the last step by depth, runs pooled; None without any."""
    return cells_by_depth(by_depth(runs), runs[0].manifest.shown.length) if runs else None


def cells_by_depth(patterns: Mapping[float, Pattern], unit: Unit) -> Table | None:
    """Return the table of these statistics by depth; None without any.

    Parameters
    ----------
    patterns : statistics of the cells by depth (m).
    unit : unit of lengths.
    """
    rows: tuple[tuple[Cell, ...], ...] = tuple(
        (depth, found.number, found.interior, *_shown(found, unit))
        for depth, found in patterns.items()
    )
    if not rows:
        return None
    sizes = (Column(name=name, unit=_power(unit, key)) for key, name in SHOWN.items())
    columns = (Column(name="depth", unit=unit), *columns_of("cells", "inside"), *sizes)
    return Table(columns=columns, rows=rows, notes=NOTES)


def by_depth(runs: Iterable[Run]) -> dict[float, Pattern]:
    """Return the statistics of the cells at each depth at the last step of each run, pooled."""
    found: dict[float, list[CellSection]] = {}
    for run in runs:
        for section in _sections(run.steps[-1]) if run.steps else ():
            found.setdefault(section.depth, []).append(section)
    return {depth: pattern(sections) for depth, sections in sorted(found.items())}


def cells_table(run: Run) -> Table:
    """Return a row for each step and depth."""
    m, unit = run.manifest, run.manifest.shown.length
    rows = tuple(
        (*time_columns(step), section.depth, *_numbers(pattern([section])))
        for step in run.steps
        for section in _sections(step)
    )
    depth = Column(name="depth", unit=unit)
    return Table(columns=(*clock_columns(m), depth, *_columns(unit)), rows=rows)


def pooled_table(runs: Iterable[Run]) -> Table:
    """Return a row for each depth, of the last steps of all runs."""
    runs = list(runs)
    unit = runs[0].manifest.shown.length if runs else NONE
    rows = tuple(
        (depth, found.sections, *_numbers(found)) for depth, found in by_depth(runs).items()
    )
    columns = (Column(name="depth", unit=unit), Column(name="sections"), *_columns(unit))
    return Table(columns=columns, rows=rows)


def _columns(unit: Unit) -> tuple[Column, ...]:
    """Return the columns of both tables, each estimate with its standard error."""
    estimates = (
        column
        for name in ESTIMATES
        for column in columns_of(name, f"{name}_error", unit=_power(unit, name))
    )
    return (*columns_of("cells", "interior", *Junction), *estimates)


def _power(unit: Unit, name: str) -> Unit:
    """Return the unit of an estimate, from that of a length."""
    return unit.power(POWERS[name]) if name in POWERS else NONE


def _numbers(found: Pattern) -> tuple[Cell, ...]:
    """Return a row of these columns."""
    estimates: list[Estimate] = [getattr(found, name) for name in ESTIMATES]
    counts = (found.number, found.interior, *(found.junctions[kind] for kind in Junction))
    return (*counts, *(cell for e in estimates for cell in (e.value, e.error)))


def _sections(step: Step) -> tuple[CellSection, ...]:
    return step.measures.cells if step.measures else ()


def _shown(found: Pattern, unit: Unit) -> Iterator[str]:
    for name in SHOWN:
        estimate: Estimate = getattr(found, name)
        of = _power(unit, name).of
        error = "" if estimate.error is None else f" ± {number(of(estimate.error), 2)}"
        yield number(None if estimate.value is None else of(estimate.value)) + error
