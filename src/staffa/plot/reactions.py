"""The forces of the supports against time."""

from collections.abc import Sequence
from itertools import cycle

from matplotlib.figure import Figure

from staffa.manifest import Manifest
from staffa.plot.labels import clock, clock_label, with_unit
from staffa.plot.style import GENERATIONS, legend_above, new_figure
from staffa.records import Step

LINES = ("-", "--", ":")


def reactions_figure(manifest: Manifest, steps: Sequence[Step]) -> Figure:
    """A color for each held side, a kind of line for each component of its force on the body."""
    figure = new_figure(3.4)
    axes = figure.subplots()
    seen = [step for step in steps if step.reactions]
    at = clock(seen)
    for side, color in zip(seen[-1].reactions, cycle(GENERATIONS), strict=False):
        for k, line in enumerate(LINES[: len(manifest.size)]):
            force = [step.reactions[side][k] for step in seen]
            if any(force):
                label = f"{side}, along {'xyz'[k]}"
                axes.plot(at, force, color=color, linestyle=line, label=label)
    axes.set_xlabel(clock_label(manifest, seen))
    unit = "N/m" if len(manifest.size) == 2 else "N"
    axes.set_ylabel(with_unit("force on the body", manifest, unit))
    axes.yaxis.set_major_formatter("{x:.4g}")  # a common exponent would lie under the legend
    legend_above(axes, 4)
    return figure
