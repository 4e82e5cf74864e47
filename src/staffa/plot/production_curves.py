"""Production against time, with cracks and without: temperature, power and pressure."""

from collections.abc import Mapping, Sequence
from math import inf, isfinite
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from staffa.display_units import Unit, prefixed
from staffa.io.production_rows import BREAKTHROUGH, LATE, Production, first_time
from staffa.plot.style import BLACK, GENERATIONS, legend_above, new_figure
from staffa.records.manifest import Manifest
from staffa.records.reservoir_facts import ReservoirFacts
from staffa.reservoir.fracture_heat import FractureHeat

Style = Mapping[str, Any]
SOLID: Style = {"linestyle": "-"}
DASHED: Style = {"linestyle": (0, (4, 2)), "linewidth": 1.2, "alpha": 0.8}
POINTS = 120  # of the closed form's line


def water_units(manifest: Manifest, found: Sequence[Production]) -> dict[str, Unit]:
    """Return the units in which temperature, pressure, power and heat of the water are shown."""
    power, heat = ([abs(getattr(one, name)) for one in found] for name in ("power", "heat"))
    return {
        "T": manifest.shown.temperature,
        "pressure": manifest.shown.stress,
        "power": prefixed("W", max(power, default=0.0)),
        "heat": prefixed("J", max(heat, default=0.0)),
    }


def production_figure(
    manifest: Manifest, found: Sequence[Production], without: Sequence[Production] = ()
) -> Figure:
    """Draw temperatures of the producers, power, and pressures of all wells against time.

    Parameters
    ----------
    manifest : description of the run, which has a reservoir.
    found : the production of its steps, one or more.
    without : the same without cracks, drawn dashed; none where that is not known.
    """
    figure = new_figure(6.4)
    rows = figure.subplots(3, 1, sharex=True)
    units = water_units(manifest, found)
    if without:
        _draw(rows, manifest, without, units, DASHED)
    _draw(rows, manifest, found, units, SOLID)
    if without:
        rows[0].plot([], [], color=BLACK, label="without cracks", **DASHED)
    _draw_closed_form(rows[0], manifest, found, units["T"])
    _mark_drawdown(rows[0], manifest, found)
    labels = ("production temperature", "power", "pressure in wells")
    for axes, label, key in zip(rows, labels, ("T", "power", "pressure"), strict=True):
        axes.set_ylabel(units[key].label(label))
        axes.ticklabel_format(axis="y", useOffset=False)  # a small rise of a large pressure
    rows[1].set_ylim(bottom=min(0.0, rows[1].dataLim.ymin))
    rows[2].set_xlabel(manifest.shown.time.label("time"))
    for axes in (rows[0], rows[2]):
        if named := axes.get_legend_handles_labels()[0]:
            legend_above(axes, min(4, len(named)))
    return figure


def _draw(
    rows: np.ndarray,
    manifest: Manifest,
    found: Sequence[Production],
    units: Mapping[str, Unit],
    style: Style,
) -> None:
    """Draw temperatures, power and pressures; the wells are named where the lines are solid.

    Parameters
    ----------
    rows : the panels of temperature, power and pressure.
    manifest : description of the run.
    found : the production of its steps.
    units : units of the panels.
    style : SOLID with cracks, DASHED without.
    """
    at = np.array([manifest.shown.time.of(one.time) for one in found])
    for number, name in enumerate(found[0].now.wells):
        label = f"well '{name}'" if style is SOLID else ""
        color = GENERATIONS[number % len(GENERATIONS)]
        T = _series(name, "T", found, producers=True)
        p = _series(name, "pressure", found)
        for axes, values, key in ((rows[0], T, "T"), (rows[2], p, "pressure")):
            if np.isfinite(values).any():
                draw_line(axes, at, units[key].of(values), style, color=color, label=label)
    power = np.array([one.power for one in found])
    draw_line(rows[1], at, units["power"].of(power), style, color=BLACK)


def _series(
    name: str, key: str, found: Sequence[Production], *, producers: bool = False
) -> np.ndarray:
    """Return a number of a well at each step, NaN where there is none, shape (n,).

    Parameters
    ----------
    name : name of the well.
    key : name of the number in its account.
    found : the production of the steps.
    producers : True for the steps alone in which the well produces.
    """
    wells = [(one.producers if producers else one.now.wells).get(name) for one in found]
    return np.array([getattr(well, key, np.nan) for well in wells], float)


def draw_line(
    axes: Axes, at: np.ndarray, values: np.ndarray, style: Style, *, color: str, label: str = ""
) -> None:
    """Draw a line, as a dot where it has one point.

    Parameters
    ----------
    axes : the panel.
    at, values : its points, shape (n,); NaN where there is none.
    style : SOLID with cracks, DASHED without.
    color : its color.
    label : its name in the legend, empty for none.
    """
    alone = np.isfinite(values).sum() == 1
    marker = "o" if alone else ""
    axes.plot(at, values, color=color, label=label or None, marker=marker, **style)


def _draw_closed_form(
    axes: Axes, manifest: Manifest, found: Sequence[Production], unit: Unit
) -> None:
    """Draw the closed form dotted, if one applies."""
    facts, last = found[-1].facts, found[-1]
    start = last.time - last.elapsed
    elapsed = np.linspace(0.0, last.elapsed, POINTS + 1)[1:]
    T = closed_form_temperature(facts, elapsed)
    if T is None:
        return
    axes.plot(
        manifest.shown.time.of(start + elapsed), unit.of(T), color=BLACK, linestyle=":",
        linewidth=1.2, label="closed form",
    )  # fmt: skip


def closed_form_temperature(facts: ReservoirFacts, elapsed: np.ndarray) -> np.ndarray | None:
    """Return the production temperature in closed form (K), shape (n,); None where none applies.

    A single fracture: Lauwerier (1955). Parallel ones: Gringarten, Witherspoon and Ohnishi (1975).

    Parameters
    ----------
    facts : the reservoir.
    elapsed : times since the water flows (s), above 0, shape (n,).
    """
    flow, T_in = facts.flow, facts.T_injected
    if flow is None or T_in is None:
        return None
    law = FractureHeat(
        carried=facts.water_rho * facts.water_c * flow.q / 2,
        stored=flow.stored,
        k=facts.conductivity,
        rho_c=facts.rho_c,
        depth=inf if flow.half_spacing is None else flow.half_spacing,
    )
    x, y = np.array([flow.length]), np.zeros(1)
    theta = np.array([law.drop(x, y, float(t))[0] for t in elapsed])
    return facts.T - theta * (facts.T - T_in)


def _mark_drawdown(axes: Axes, manifest: Manifest, found: Sequence[Production]) -> None:
    """Mark the times at which the drawdown of the produced water passes 1 and 10 %."""
    drawdown = [one.drawdown for one in found]
    for level in (BREAKTHROUGH, LATE):
        when = first_time(found, drawdown, level)
        if isfinite(when):
            x = manifest.shown.time.of(when)
            axes.axvline(x, color=BLACK, linewidth=0.6, linestyle=(0, (1, 3)))
            axes.annotate(
                f" {100 * level:.0f} %", (x, 0.02), xycoords=("data", "axes fraction"),
                fontsize=7.5, va="bottom",
            )  # fmt: skip
