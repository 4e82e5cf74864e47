"""Energy release rate at each tip, step by step: as a table, and as a sentence."""

from math import dist

from staffa.io.run_directory import Run
from staffa.records.step import Step
from staffa.records.tip_release import Release
from staffa.results.series import clock_columns, time_columns
from staffa.results.tables import Column, Table, columns_of

# A tip recorded at the last vertex above the threshold is the one whose sharp end is so near, ell.
SAME_TIP = 3.0


def release_table(run: Run) -> Table:
    """Return a row for each step whose fields were kept, and each tip of its network.

    reason: why G is not known where it is not.
    """
    m = run.manifest
    axes, shown = "xyz"[: len(m.size)], m.shown
    columns = (
        *clock_columns(m),
        Column(name="tip"),
        *columns_of(*axes, unit=shown.length),
        *columns_of(*(f"d{axis}" for axis in axes)),
        *columns_of("G", "uncertainty", unit=shown.release),
        Column(name="radius", unit=shown.length),
        Column(name="reason"),
    )
    rows = tuple(
        (
            *time_columns(step),
            number,
            *tip.position,
            *tip.direction,
            *rates(tip),
            tip.radius,
            tip.reason,
        )
        for step in run.steps
        for number, tip in enumerate(step.released)
    )
    return Table(columns=columns, rows=rows)


def rates(tip: Release | None) -> tuple[float | None, float | None]:
    """Return G and its uncertainty (J/m^2), None where they are not known."""
    if tip is None or tip.G is None or tip.uncertainty is None:
        return None, None
    return tip.G, tip.uncertainty


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
