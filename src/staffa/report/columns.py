"""The cells on planes below the cooled face: a table by depth, of a run or of many, and as CSV."""

from collections.abc import Iterable, Iterator, Sequence

from staffa.io.run_directory import Run
from staffa.measure.borders import Junction
from staffa.measure.patterns import Estimate, Pattern, pattern
from staffa.records import CellSection, Step
from staffa.report.comparison import Table
from staffa.report.ensemble import number
from staffa.report.series import clock, csv_text

ESTIMATES = (
    *("area", "whole_area", "diameter", "spacing", "area_cv"),
    *("sides", "sides_variance", "hexagonality", "disorder", "t_share"),
)
# The columns of both tables, each estimate with its standard error.
NUMBERS = (
    *("cells", "interior", *Junction),
    *(column for name in ESTIMATES for column in (name, f"{name}_error")),
)
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
    """The cells at the last step by depth, those of all runs of one case together; None without
    any."""
    rows = [
        (f"{depth:.4g}", str(found.number), str(found.interior), *_shown(found))
        for depth, found in by_depth(runs).items()
    ]
    if not rows:
        return None
    unit = "" if runs[0].manifest.scaled else " (m)"
    lengths = ("spacing", "diameter")
    names = (name + unit * (key in lengths) for key, name in SHOWN.items())
    return Table(header=(f"depth{unit}", "cells", "inside", *names), rows=tuple(rows), notes=NOTES)


def by_depth(runs: Iterable[Run]) -> dict[float, Pattern]:
    """The pattern at each depth at the last step of each run."""
    found: dict[float, list[CellSection]] = {}
    for run in runs:
        for section in _sections(run.steps[-1]) if run.steps else ():
            found.setdefault(section.depth, []).append(section)
    return {depth: pattern(sections) for depth, sections in sorted(found.items())}


def cells_table(run: Run) -> str | None:
    """One row for each step and depth; None without any."""
    rows = (
        [step.index, *clock(step.time, step.tau), section.depth, *_numbers(pattern([section]))]
        for step in run.steps
        for section in _sections(step)
    )
    return csv_text(["step", "time", "tau", "depth", *NUMBERS], rows)


def pooled_table(runs: Iterable[Run]) -> str | None:
    """One row for each depth, of the last steps of all runs; None without any."""
    rows = ([depth, found.sections, *_numbers(found)] for depth, found in by_depth(runs).items())
    return csv_text(["depth", "sections", *NUMBERS], rows)


def _numbers(found: Pattern) -> list[object]:
    """A row of NUMBERS; what is not known is empty."""
    estimates: list[Estimate] = [getattr(found, name) for name in ESTIMATES]
    pairs = (number for estimate in estimates for number in (estimate.value, estimate.error))
    counts = (found.number, found.interior, *(found.junctions[kind] for kind in Junction))
    return [*counts, *("" if number is None else number for number in pairs)]


def _sections(step: Step) -> tuple[CellSection, ...]:
    return step.measures.cells if step.measures else ()


def _shown(found: Pattern) -> Iterator[str]:
    for name in SHOWN:
        estimate: Estimate = getattr(found, name)
        error = "" if estimate.error is None else f" ± {number(estimate.error, 2)}"
        yield number(estimate.value) + error
