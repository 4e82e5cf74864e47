"""Quantities of a script's own against time."""

from collections.abc import Sequence
from itertools import cycle

from matplotlib.figure import Figure

from staffa.plot.labels import show_clock, time_axis_values
from staffa.plot.style import GENERATIONS, legend_above, new_figure
from staffa.records.manifest import Manifest
from staffa.records.step import Step

MOST = 6  # panels in one picture


def quantities_figure(manifest: Manifest, steps: Sequence[Step]) -> Figure:
    """Draw a panel for each quantity, a line for each of its numbers; the first six quantities."""
    known = manifest.quantities[:MOST]
    seen = [step for step in steps if step.quantities]
    figure = new_figure(0.9 + 2.0 * len(known))
    panels = figure.subplots(len(known), 1, squeeze=False, sharex=True)[:, 0]
    at = time_axis_values(manifest, seen)
    for axes, quantity in zip(panels, known, strict=True):
        lines = enumerate(zip(quantity.columns, cycle(GENERATIONS), strict=False))
        for k, (label, color) in lines:
            numbers = [step.quantities[quantity.name][k] for step in seen]
            axes.plot(at, numbers, color=color, label=label)
        axes.set_ylabel(quantity.shown.header(quantity.name))
        axes.yaxis.set_major_formatter("{x:.4g}")
        if quantity.numbers > 1:
            legend_above(axes, min(4, quantity.numbers))
    show_clock(panels[-1], manifest, seen)
    return figure
