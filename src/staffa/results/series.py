"""Recorded values at every step as tables for a spreadsheet: reactions and probes."""

import csv
import io
from collections.abc import Iterable, Sequence

import numpy as np

from staffa.io.run_directory import Run
from staffa.records.manifest import Manifest
from staffa.records.step import Step

# First characters of a cell that a spreadsheet takes for a formula.
COMPUTED = ("=", "+", "-", "@", "\t", "\r")


def reactions_table(run: Run) -> str | None:
    """Return CSV with one row for each step and support, its force; None without any."""
    axes, unit = "xyz"[: len(run.manifest.size)], run.manifest.shown.force
    rows = [
        [*time_columns(run.manifest, step), side, *map(unit.of, force)]
        for step in run.steps
        for side, force in step.reactions.items()
    ]
    header = [*clock_header(run.manifest), "side", *(unit.column(f"f{axis}") for axis in axes)]
    return csv_text(header, rows)


def probes_table(run: Run) -> str | None:
    """Return CSV with one row for each step, probe and point; None without any.

    Its column s is the distance from the probe's first point; T the temperature change, as in the
    fields; temperature the absolute one, if the case gives it.
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
        [*time_columns(m, step), *place, *read(*values)]
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


def clock_header(manifest: Manifest) -> list[str]:
    """Return the names of the columns of step and time."""
    return ["step", manifest.shown.time.column("time"), "tau"]


def time_columns(manifest: Manifest, step: Step) -> list[object]:
    """Return step, time and tau; tau is empty if there is none."""
    time = manifest.shown.time.of(step.time)
    return [step.index, time, "" if step.tau is None else step.tau]


def csv_text(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str | None:
    """Return rows below a header as CSV; None without any row."""
    rows = list(rows)
    if not rows:
        return None
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([_as_text(cell) for cell in row] for row in rows)
    return text.getvalue()


def _as_text(cell: object) -> object:
    """Return a cell, with a quote before a text that a spreadsheet would compute."""
    return f"'{cell}" if isinstance(cell, str) and cell.startswith(COMPUTED) else cell
