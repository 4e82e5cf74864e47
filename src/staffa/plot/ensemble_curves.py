"""Curves of an ensemble against time: mean, standard error, and each member."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from staffa.measure.averages import mean_over_time
from staffa.plot.labels import crack_name, show_clock, time_axis_values
from staffa.plot.style import BLACK, BLUE, ORANGE, count_axis, legend_above, new_figure
from staffa.records.manifest import Manifest
from staffa.records.step import Measures, Step

Members = Sequence[Sequence[Step]]
BAND: Any = {"alpha": 0.3, "linewidth": 0}
THIN: Any = {"alpha": 0.4, "linewidth": 0.5}


def counts_figure(manifest: Manifest, members: Members) -> Figure:
    """Draw the number of cracks on each depth section, a panel for each section."""
    heights = [section.height for section in _measured(manifest, members[0])[1][0].sections]
    colors = colormaps["viridis"](np.linspace(0.0, 0.85, len(heights)))
    figure = new_figure(0.9 + 1.3 * len(heights))
    rows = figure.subplots(len(heights), 1, squeeze=False, sharex=True)[:, 0]
    for number, (axes, height, color) in enumerate(zip(rows, heights, colors, strict=True)):
        _draw_spread(axes, manifest, members, partial(_crossing, number), color)
        axes.set_ylabel(f"cracks at {manifest.shown.length.text(height, 3)}")
        count_axis(axes, ticks=4)
    _finish(rows, manifest, members)
    return figure


def growth_figure(manifest: Manifest, members: Members) -> Figure:
    """Draw the length of all cracks, from the surface energy, and the depth of the deepest."""
    panels: list[tuple[str, str, Callable[[Measures], float]]]
    size, depth = manifest.shown.crack, manifest.shown.length
    label = size.label(crack_name(manifest))
    panels = [(label, ORANGE, lambda measures: size.of(measures.length_surface))]
    if manifest.cooled_side:
        label = depth.label("deepest crack")
        panels.append((label, BLUE, lambda measures: depth.of(manifest.deepest(measures))))
    figure = new_figure(0.9 + 2.1 * len(panels))
    rows = figure.subplots(len(panels), 1, squeeze=False, sharex=True)[:, 0]
    for axes, (label, color, value) in zip(rows, panels, strict=True):
        _draw_spread(axes, manifest, members, value, color)
        axes.set_ylabel(label)
    _finish(rows, manifest, members)
    return figure


def _crossing(number: int, measures: Measures) -> float:
    return measures.sections[number].cracks


def _draw_spread(
    axes: Axes,
    manifest: Manifest,
    members: Members,
    value: Callable[[Measures], float],
    color: Any,
) -> None:
    """Draw step functions of time: the mean, its standard error, and each member."""
    measured = [_measured(manifest, steps) for steps in members]
    found = mean_over_time([(at, [value(m) for m in measures]) for at, measures in measured])
    for number, values in enumerate(found.values):
        label = "each member" if number == 0 else None
        axes.step(found.at, values, where="post", color=color, label=label, **THIN)
    low, high = found.mean - found.error, found.mean + found.error
    axes.fill_between(
        found.at, low, high, step="post", color=color, label="its standard error", **BAND
    )
    mean = f"mean of {len(members)} members"
    axes.step(found.at, found.mean, where="post", color=color, label=mean)
    axes.set_ylim(bottom=0)


def _finish(rows: np.ndarray, manifest: Manifest, members: Members) -> None:
    """Draw the time axis below, and the legend above."""
    show_clock(rows[-1], manifest, [step for steps in members for step in steps])
    handles = [
        Line2D([], [], color=BLACK, label=f"mean of {len(members)} members"),
        Patch(color=BLACK, label="its standard error", **BAND),
        Line2D([], [], color=BLACK, label="each member", **THIN),
    ]
    legend_above(rows[0], len(handles), handles)


def _measured(manifest: Manifest, steps: Sequence[Step]) -> tuple[list[float], list[Measures]]:
    """Return times and measures of the measured steps."""
    seen = [step for step in steps if step.measures is not None]
    return time_axis_values(manifest, seen), [
        step.measures for step in seen if step.measures is not None
    ]
