"""Readings of every step as tables for a spreadsheet: reactions, probes, own quantities."""

import csv
import io
from collections.abc import Iterable, Sequence

import numpy as np

from staffa.io.run_directory import Run
from staffa.records.manifest import Manifest
from staffa.records.step import Step

# With these a cell begins that a spreadsheet takes for a formula.
COMPUTED = ("=", "+", "-", "@", "\t", "\r")


def reactions_table(run: Run) -> str | None:
    """One row for each step and held side: the force on the body there; None without any."""
    axes, unit = "xyz"[: len(run.manifest.size)], run.manifest.shown.force
    rows = [
        [*clock(run.manifest, step), side, *map(unit.of, force)]
        for step in run.steps
        for side, force in step.reactions.items()
    ]
    header = [*clock_header(run.manifest), "side", *(unit.column(f"f{axis}") for axis in axes)]
    return csv_text(header, rows)


def probes_table(run: Run) -> str | None:
    """One row for each step, probe and point; s: distance from the probe's first point.

    T: the change of temperature, as in the fields; temperature: itself, where the case tells it.
    """
    m, shown = run.manifest, run.manifest.shown
    axes, probes, known = "xyz"[: len(m.size)], m.probes, m.reference is not None
    places = []
    for probe in probes:
        points = np.array(probe.points)
        along = np.linalg.norm(points - points[0], axis=1)
        places += [
            [probe.name, *map(shown.length.of, (float(s), *p))]
            for s, p in zip(along, probe.points, strict=True)
        ]

    def read(T: float, *others: float) -> list[float]:
        itself = [shown.temperature.of((m.reference or 0.0) + T)] if known else []
        return [shown.difference.of(T), *itself, *map(shown.length.of, others[:-1]), others[-1]]

    rows = [
        [*clock(m, step), *place, *read(*values)]
        for step in run.steps
        for place, values in zip(places, step.probed, strict=False)  # a failed step has none
    ]
    fields = [
        shown.difference.column("T"),
        *([shown.temperature.column("temperature")] if known else []),
        *(shown.length.column(f"u{axis}") for axis in axes),
        "alpha",
    ]
    where = [shown.length.column(name) for name in ("s", *axes)]
    return csv_text([*clock_header(m), "name", *where, *fields], rows)


def quantities_table(run: Run) -> str | None:
    """One row for each step: the numbers of the script's own quantities; None without any."""
    m, known = run.manifest, run.manifest.quantities
    columns = [q.shown.column(name) for q in known for name in q.columns]
    rows = [
        [*clock(m, step), *(number for q in known for number in step.quantities[q.name])]
        for step in run.steps
        if step.quantities
    ]
    return csv_text([*clock_header(m), *columns], rows)


def clock_header(manifest: Manifest) -> list[str]:
    """Names of the columns that tell when."""
    return ["step", manifest.shown.time.column("time"), "tau"]


def clock(manifest: Manifest, step: Step) -> list[object]:
    """The columns that tell when: tau is empty where nothing diffuses."""
    time = manifest.shown.time.of(step.time)
    return [step.index, time, "" if step.tau is None else step.tau]


def csv_text(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str | None:
    """Rows below a header; None without any."""
    rows = list(rows)
    if not rows:
        return None
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([_as_text(cell) for cell in row] for row in rows)
    return text.getvalue()


def _as_text(cell: object) -> object:
    """A cell; of a text that a spreadsheet would compute, with a quote before it."""
    return f"'{cell}" if isinstance(cell, str) and cell.startswith(COMPUTED) else cell
