"""Production of an ensemble against time: means over the members, standard errors, and members."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from staffa.display_units import KELVIN, Unit, prefixed
from staffa.io.production_rows import Production, paired_production, production
from staffa.io.run_directory import Run
from staffa.measure.averages import Spread, mean_over_time
from staffa.plot.ensemble_curves import BAND, THIN
from staffa.plot.production_curves import DASHED
from staffa.plot.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, legend_above, new_figure
from staffa.records.manifest import Manifest

Pairs = Sequence[tuple[Production, Production]]
# Numbers of a step with cracks, in the order of production_means.csv.
ALONE: dict[str, Callable[[Production], float]] = {
    "T": lambda one: one.T,
    "power": lambda one: one.power,
    "heat": lambda one: one.heat,
}
# Numbers of a step with cracks and without.
OF_BOTH: dict[str, Callable[[Production, Production], float]] = {
    "T_without": lambda one, other: other.T,
    "power_without": lambda one, other: other.power,
    "heat_without": lambda one, other: other.heat,
    "T_change": lambda one, other: one.T - other.T,
    "heat_change": lambda one, other: one.heat - other.heat,
}
PANELS = {
    "T": ("temperature", ORANGE),
    "power": ("power", BLACK),
    "heat": ("energy", BLUE),
    "T_change": ("change of T", GREEN),
    "heat_change": ("change of energy", PURPLE),
}


def production_spreads(runs: Sequence[Run]) -> dict[str, Spread]:
    """Return means over time of the production of runs (SI), by number; none of fewer than two.

    The values of a member are linear between its steps. Those without cracks, and the changes that
    cracks make, need a shadow in each run.

    Parameters
    ----------
    runs : finished runs.
    """
    alone = [production(run.manifest.reservoir, run.steps) for run in runs]
    both = [paired_production(run.manifest.reservoir, run.steps) for run in runs]
    found: dict[str, Spread] = {}
    if len(runs) < 2 or not all(alone):
        return found
    for name, value in ALONE.items():
        series = [([p.time for p in seen], [value(p) for p in seen]) for seen in alone]
        found[name] = mean_over_time(series, linear=True)
    for name, change in OF_BOTH.items() if all(both) else ():
        series = [([p.time for p, _ in seen], [change(*pair) for pair in seen]) for seen in both]
        found[name] = mean_over_time(series, linear=True)
    return found


def ensemble_production_figure(manifest: Manifest, found: dict[str, Spread]) -> Figure:
    """Draw production temperature, power and energy, and what cracks change of them.

    Parameters
    ----------
    manifest : description of the first member.
    found : the means, see `production_spreads`.
    """
    names = [name for name in PANELS if name in found]
    figure = new_figure(0.9 + 1.5 * len(names))
    rows = figure.subplots(len(names), 1, squeeze=False, sharex=True)[:, 0]
    for axes, name in zip(rows, names, strict=True):
        label, color = PANELS[name]
        seen = found[name]
        unit, at = _unit(name, manifest, seen), manifest.shown.time.of(seen.at)
        _draw_spread(axes, at, seen, unit, color)
        if (without := found.get(f"{name}_without")) is not None:
            times, mean = manifest.shown.time.of(without.at), unit.of(without.mean)
            axes.plot(times, mean, color=color, label="mean without cracks", **DASHED)
        axes.set_ylabel(unit.label(label))
        if name in ("power", "heat"):
            axes.set_ylim(bottom=min(0.0, axes.dataLim.ymin))
        elif name != "T":
            axes.axhline(0.0, color=BLACK, linewidth=0.6)
    rows[-1].set_xlabel(manifest.shown.time.label("time"))
    handles: list[Line2D | Patch] = [
        Line2D([], [], color=BLACK, label=f"mean of {len(found['T'].values)} members"),
        Patch(color=BLACK, label="its standard error", **BAND),
        Line2D([], [], color=BLACK, label="each member", **THIN),
    ]
    if "T_without" in found:
        handles.append(Line2D([], [], color=BLACK, label="mean without cracks", **DASHED))
    legend_above(rows[0], len(handles), handles)
    return figure


def _draw_spread(axes: Axes, at: np.ndarray, seen: Spread, unit: Unit, color: str) -> None:
    """Draw each member, the mean and its standard error.

    Parameters
    ----------
    axes : the panel.
    at : times as shown, shape (n,).
    seen : numbers of the members at these times (SI).
    unit : unit of the panel.
    color : its color.
    """
    for number, values in enumerate(seen.values):
        label = "each member" if number == 0 else None
        axes.plot(at, unit.of(values), color=color, label=label, **THIN)
    low, high = unit.of(seen.mean - seen.error), unit.of(seen.mean + seen.error)
    axes.fill_between(at, low, high, color=color, label="its standard error", **BAND)
    axes.plot(at, unit.of(seen.mean), color=color, label=f"mean of {len(seen.values)} members")


def _unit(name: str, manifest: Manifest, seen: Spread) -> Unit:
    """Return the unit of a panel."""
    if name == "T":
        return manifest.shown.temperature
    if name == "T_change":
        return KELVIN
    return prefixed("W" if name == "power" else "J", float(np.abs(seen.values).max(initial=0.0)))
