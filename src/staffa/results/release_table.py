"""Energy release rate at each tip, step by step: as a table, and as a sentence."""

from math import dist

from staffa.io.run_directory import Run
from staffa.records.step import Step
from staffa.records.tip_release import Release
from staffa.results.series import clock_header, csv_text, time_columns

# Largest distance (in ell) between a recorded tip and its sharp tip in the network.
SAME_TIP = 3.0


def release_table(run: Run) -> str | None:
    """Return CSV with one row for each step with fields and each tip; None without any.

    The column `reason` says why G is not known.
    """
    m = run.manifest
    axes, length = "xyz"[: len(m.size)], m.shown.length
    rate = m.shown.release
    header = [
        *clock_header(m), "tip", *(length.column(axis) for axis in axes), *(f"d{a}" for a in axes),
        rate.column("G"), rate.column("uncertainty"), length.column("radius"), "reason",
    ]  # fmt: skip
    rows: list[list[object]] = []
    for step in run.steps:
        for number, tip in enumerate(step.released):
            values = [*rates(run, tip), "" if tip.radius is None else length.of(tip.radius)]
            place = [*map(length.of, tip.position), *tip.direction]
            rows.append([*time_columns(m, step), number, *place, *values, tip.reason or ""])
    return csv_text(header, rows)


def rates(run: Run, tip: Release | None) -> list[object]:
    """Return G and its uncertainty in the run's unit, empty if they are not known."""
    unit = run.manifest.shown.release
    if tip is None or tip.G is None or tip.uncertainty is None:
        return ["", ""]
    return [unit.of(tip.G), unit.of(tip.uncertainty)]


def release_at(step: Step, position: tuple[float, ...], ell: float) -> Release | None:
    """Return the energy release rate of the tip at a position; None if there is none.

    Parameters
    ----------
    step : record of the step.
    position : recorded position of the tip (m).
    ell : regularization length (m).
    """
    near = [tip for tip in step.released if dist(tip.position, position) <= SAME_TIP * ell]
    return min(near, key=lambda tip: dist(tip.position, position), default=None)


def release_text(run: Run) -> str | None:
    """Return G at the tips of the last step that has it, as a sentence; None without any."""
    step = next((step for step in reversed(run.steps) if step.released), None)
    if step is None:
        return None
    unit = run.manifest.shown.release
    known = sorted((tip.G, tip.uncertainty or 0.0) for tip in step.released if tip.G is not None)
    count = f"at {len(known)} of {len(step.released)} tips of step {step.index}"
    if not known:
        return f"{count}: {step.released[0].reason}"
    most = max(uncertainty for _, uncertainty in known)
    least, largest = (f"{unit.of(known[k][0]):.4g}" for k in (0, -1))
    span = largest if len(known) == 1 else f"{least} to {largest}"
    return f"{span}{unit.behind} {count}, uncertain by up to {unit.text(most, 2)}"
