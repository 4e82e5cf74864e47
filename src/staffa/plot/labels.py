"""Labels of axes: quantities with their units, and the time of a run."""

from collections.abc import Sequence
from math import sqrt

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import ScaledTranslation
from numpy.typing import ArrayLike

from staffa.plot.style import ALARM
from staffa.records.manifest import Manifest
from staffa.records.step import Step

TAU = r"$\tau = 2\sqrt{\kappa t}/L$"
IN_A_HALF_SPACE = r", so that $T = -\Delta T\,\mathrm{erfc}(y/(\tau L))$ at depth $y$"
WITHOUT_MATH = {
    TAU: "τ = 2 √(κ t) / L",
    IN_A_HALF_SPACE: ", so that T = −ΔT erfc(y/(τ L)) at depth y",
}
BELOW = 0.42  # inches from the axis of time to that of tau
APART = 0.05  # least part of the axis between two ticks of tau
ROUNDING = 1e-9
MARGIN = 0.03  # of an axis, behind a mark at its end


def has_tau(steps: Sequence[Step]) -> bool:
    """Return True if every step has its tau."""
    return bool(steps) and all(step.tau is not None for step in steps)


def counts_tau(manifest: Manifest, steps: Sequence[Step]) -> bool:
    """Return True if the time axis of a run is tau: of a scaled run that has it."""
    return manifest.scaled and has_tau(steps)


def time_axis_values(manifest: Manifest, steps: Sequence[Step]) -> list[float]:
    """Return values on the time axis: time in the run's unit, or tau if that is the axis."""
    tau = counts_tau(manifest, steps)
    return [at(manifest, step.time, step.tau if tau else None) for step in steps]


def at(manifest: Manifest, time: float, tau: float | None) -> float:
    """Return a position on the time axis: tau if it is given, else the time in the run's unit.

    Parameters
    ----------
    manifest : description of the run.
    time : time (s).
    tau : dimensionless time; None for an axis of time.
    """
    return manifest.shown.time.of(time) if tau is None else tau


def clock_label(manifest: Manifest, steps: Sequence[Step]) -> str:
    """Return the label of the time axis."""
    if counts_tau(manifest, steps):
        return tau_label(manifest)
    return manifest.shown.time.label("time")


def tau_label(manifest: Manifest) -> str:
    """Return the definition of tau, and the temperature of a half-space if the case has that."""
    return TAU + (IN_A_HALF_SPACE if manifest.profile == "half-space" else "")


def without_math(label: str) -> str:
    """Return a label with its formulas as plain text."""
    for formula, text in WITHOUT_MATH.items():
        label = label.replace(formula, text)
    return label


def show_clock(axes: Axes, manifest: Manifest, steps: Sequence[Step]) -> None:
    """Label the time axis; below one in units add an axis of tau if every step has it.

    Parameters
    ----------
    axes : the panel.
    manifest : description of the run.
    steps : the steps that are drawn.
    """
    axes.set_xlabel(clock_label(manifest, steps), parse_math=counts_tau(manifest, steps))
    late = max(steps, key=lambda step: step.time, default=None)
    if late is None or not late.tau or not has_tau(steps) or counts_tau(manifest, steps):
        return
    add_tau(axes, manifest.shown.time.of(late.time), late.tau, tau_label(manifest))


def add_tau(axes: Axes, time: float, tau: float, label: str) -> None:
    """Add an axis of tau below that of time.

    Parameters
    ----------
    axes : the panel.
    time : last time, in the run's unit.
    tau : dimensionless time then.
    label : label of the new axis.
    """
    root = sqrt(time) / tau

    def to_tau(time: ArrayLike) -> np.ndarray:
        return np.sign(time) * np.sqrt(np.abs(time)) / root

    def to_time(tau: ArrayLike) -> np.ndarray:
        return np.sign(tau) * np.square(root * np.asarray(tau))

    figure = axes.get_figure(root=True)
    assert figure is not None
    below = axes.transAxes + ScaledTranslation(0, -BELOW, figure.dpi_scale_trans)
    second = axes.secondary_xaxis(0.0, functions=(to_tau, to_time), transform=below)
    second.set_xlabel(label, parse_math=True)
    axes.set_xlim(left=0)
    ticks = [0.0]
    for tick in MaxNLocator(8, steps=[1, 2, 5, 10]).tick_values(0, tau):
        if 0 < tick <= tau * (1 + ROUNDING) and (tick**2 - ticks[-1] ** 2) / tau**2 > APART:
            ticks.append(float(tick))
    second.set_xticks(ticks)


def mark_unreached(figure: Figure, manifest: Manifest, steps: Sequence[Step], left: Step) -> Figure:
    """Mark in each panel of curves the time of a step that was not reached, and return the figure.

    Parameters
    ----------
    figure : curves against the time of the run.
    manifest : description of the run.
    steps : the steps that are drawn.
    left : the step that was not reached.
    """
    place = at(manifest, left.time, left.tau if counts_tau(manifest, steps) else None)
    for number, axes in enumerate(figure.axes):
        low, high = axes.get_xlim()
        axes.set_xlim(low, max(high, place + MARGIN * (place - low)))
        axes.axvline(place, color=ALARM, linestyle="--", linewidth=1.2)
        if number == 0:
            axes.annotate(
                f"step {left.index} not reached", xy=(place, 0.02),
                xycoords=("data", "axes fraction"), xytext=(-4, 0), textcoords="offset points",
                color=ALARM, ha="right", va="bottom",
            )  # fmt: skip
    return figure


def moment(manifest: Manifest, step: Step) -> str:
    """Return the time of a step as a title, with tau if it has a meaning."""
    when = reading(manifest, step.time)
    if step.tau is None:
        return when
    return f"τ = {step.tau:.3g}" if manifest.scaled else f"{when}   (τ = {step.tau:.3g})"


def reading(manifest: Manifest, time: float) -> str:
    """Return a time (s, or scaled) with its unit, as "t = ..."."""
    return f"t = {manifest.shown.time.text(time)}"


def since_rest(steps: Sequence[Step]) -> bool:
    """Return True if the energies of a run are counted from an initial equilibrium under forces."""
    return any(step.energies.at_rest for step in steps)


def crack_name(manifest: Manifest) -> str:
    """Return the name of the size of cracks."""
    return "crack length" if manifest.plane else "crack area"
