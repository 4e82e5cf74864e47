"""Reactions of the supports against time."""

from collections.abc import Sequence
from itertools import cycle

from matplotlib.figure import Figure

from staffa.plot.labels import show_clock, time_axis_values
from staffa.plot.style import GENERATIONS, legend_above, new_figure
from staffa.records.manifest import Manifest
from staffa.records.step import Step

LINES = ("-", "--", ":")


def reactions_figure(manifest: Manifest, steps: Sequence[Step]) -> Figure:
    """Draw a color for each support, and a line style for each component of its force."""
    figure = new_figure(3.4)
    axes = figure.subplots()
    seen = [step for step in steps if step.reactions]
    at, unit = time_axis_values(manifest, seen), manifest.shown.force
    for side, color in zip(seen[-1].reactions, cycle(GENERATIONS), strict=False):
        for k, line in enumerate(LINES[: len(manifest.size)]):
            force = [unit.of(step.reactions[side][k]) for step in seen]
            if any(force):
                label = f"{side}, along {'xyz'[k]}"
                axes.plot(at, force, color=color, linestyle=line, label=label)
    show_clock(axes, manifest, seen)
    axes.set_ylabel(unit.label("force on the body"))
    axes.yaxis.set_major_formatter("{x:.4g}")  # a common exponent would lie under the legend
    legend_above(axes, 4)
    return figure
