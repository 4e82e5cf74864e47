"""Heat that a body gave and took, by where it went."""

from collections.abc import Sequence
from itertools import accumulate

from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from staffa.manifest import Manifest
from staffa.plot.labels import clock, clock_label, heat_label
from staffa.plot.style import BLACK, GENERATIONS, legend_above, new_figure
from staffa.records import Heat, Step


def heat_figure(manifest: Manifest, steps: Sequence[Step]) -> Figure:
    """Heat stored since the start, and what entered from each side, source and the cracks."""
    figure = new_figure(3.4)
    axes = figure.subplots()
    at = clock(steps)
    spent = list(accumulate((step.heat or Heat() for step in steps), Heat.then))
    axes.axhline(0.0, color=BLACK, linewidth=0.5)
    axes.plot(at, [h.stored for h in spent], color=BLACK, label="stored in the body")
    names = [name for name, amount in spent[-1].entered.items() if amount]
    for number, name in enumerate(names):
        color = GENERATIONS[number % len(GENERATIONS)]
        entered = [h.entered.get(name, 0.0) for h in spent]
        axes.plot(at, entered, color=color, linestyle="--", label=f"entered: {name}")
    axes.set_xlabel(clock_label(manifest, steps))
    axes.set_ylabel(heat_label(manifest))
    if not manifest.scaled:
        axes.yaxis.set_major_formatter(EngFormatter())  # -50 M
    legend_above(axes, min(4, 1 + len(names)))
    return figure
