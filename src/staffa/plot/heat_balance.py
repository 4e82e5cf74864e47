"""Heat that entered and left a body, by boundary and source."""

from collections.abc import Sequence
from itertools import accumulate

from matplotlib.figure import Figure

from staffa.plot.labels import show_clock, time_axis_values
from staffa.plot.style import BLACK, GENERATIONS, legend_above, new_figure
from staffa.records.manifest import Manifest
from staffa.records.step import Heat, Step


def heat_figure(manifest: Manifest, steps: Sequence[Step]) -> Figure:
    """Draw the heat stored since the start, and the heat that entered by each way."""
    figure = new_figure(3.4)
    axes = figure.subplots()
    at, unit = time_axis_values(manifest, steps), manifest.shown.heat
    spent = list(accumulate((step.heat or Heat() for step in steps), Heat.then))
    axes.axhline(0.0, color=BLACK, linewidth=0.5)
    axes.plot(at, [unit.of(h.stored) for h in spent], color=BLACK, label="stored in the body")
    names = [name for name, amount in spent[-1].entered.items() if amount]
    for number, name in enumerate(names):
        color = GENERATIONS[number % len(GENERATIONS)]
        entered = [unit.of(h.entered.get(name, 0.0)) for h in spent]
        axes.plot(at, entered, color=color, linestyle="--", label=f"entered: {name}")
    show_clock(axes, manifest, steps)
    axes.set_ylabel(unit.label("heat since the start"))
    legend_above(axes, min(4, 1 + len(names)))
    return figure
