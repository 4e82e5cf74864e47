"""What was read off at every step, as tables that a spreadsheet reads: reactions and probes."""

import csv
import io
from collections.abc import Iterable, Sequence

import numpy as np

from staffa.io.run_directory import Run


def reactions_table(run: Run) -> str | None:
    """One row for each step and held side: the force on the body there; None without any."""
    axes = "xyz"[: len(run.manifest.size)]
    rows = [
        [step.index, *clock(step.time, step.tau), side, *force]
        for step in run.steps
        for side, force in step.reactions.items()
    ]
    return csv_text(["step", "time", "tau", "side", *(f"f{axis}" for axis in axes)], rows)


def probes_table(run: Run) -> str | None:
    """One row for each step, probe and point; s: distance from the probe's first point (m)."""
    axes, probes = "xyz"[: len(run.manifest.size)], run.manifest.probes
    places = []
    for probe in probes:
        points = np.array(probe.points)
        along = np.linalg.norm(points - points[0], axis=1)
        places += [[probe.name, s, *p] for s, p in zip(along, probe.points, strict=True)]
    rows = [
        [step.index, *clock(step.time, step.tau), *place, *values]
        for step in run.steps
        for place, values in zip(places, step.probed, strict=False)  # a failed step has none
    ]
    fields = ["T", *(f"u{axis}" for axis in axes), "alpha"]
    return csv_text(["step", "time", "tau", "name", "s", *axes, *fields], rows)


def clock(time: float, tau: float | None) -> list[object]:
    """The columns that tell when: tau is empty where nothing diffuses."""
    return [time, "" if tau is None else tau]


def csv_text(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str | None:
    """Rows below a header; None without any."""
    rows = list(rows)
    if not rows:
        return None
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return text.getvalue()
