"""Production against time: temperature with its closed form, power and pressure."""

from collections.abc import Sequence
from math import inf, isfinite

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from staffa.display_units import Unit, prefixed
from staffa.io.production_rows import BREAKTHROUGH, LATE, Production, first_time
from staffa.plot.style import BLACK, GENERATIONS, legend_above, new_figure
from staffa.records.manifest import Manifest
from staffa.records.reservoir_facts import ReservoirFacts
from staffa.reservoir.fracture_heat import FractureHeat

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


def production_figure(manifest: Manifest, found: Sequence[Production]) -> Figure:
    """Draw temperatures of the producers, power, and pressures of all wells against time.

    Parameters
    ----------
    manifest : description of the run, which has a reservoir.
    found : the production of its steps, one or more.
    """
    figure = new_figure(6.4)
    rows = figure.subplots(3, 1, sharex=True)
    at = np.array([manifest.shown.time.of(one.time) for one in found])
    units = water_units(manifest, found)
    names = list(found[0].now.wells)
    colors = {name: GENERATIONS[k % len(GENERATIONS)] for k, name in enumerate(names)}
    lines = 0
    for name in names:
        wells = [(one.producers.get(name), one.now.wells.get(name)) for one in found]
        T, p = (np.array([getattr(pair[k], key, np.nan) for pair in wells], float)
                for k, key in ((0, "T"), (1, "pressure")))  # fmt: skip
        for axes, values, unit in ((rows[0], T, units["T"]), (rows[2], p, units["pressure"])):
            if np.isfinite(values).any():
                _line(axes, at, unit.of(values), color=colors[name], label=f"well '{name}'")
                lines += axes is rows[0]
    _line(rows[1], at, units["power"].of(np.array([one.power for one in found])), color=BLACK)
    lines += _draw_closed_form(rows[0], manifest, found, units["T"])
    _mark_drawdown(rows[0], manifest, found)
    labels = ("production temperature", "power", "pressure in wells")
    for axes, label, key in zip(rows, labels, ("T", "power", "pressure"), strict=True):
        axes.set_ylabel(units[key].label(label))
        axes.ticklabel_format(axis="y", useOffset=False)  # a small rise of a large pressure
    rows[1].set_ylim(bottom=min(0.0, rows[1].dataLim.ymin))
    rows[2].set_xlabel(manifest.shown.time.label("time"))
    if lines:
        legend_above(rows[0], min(4, lines))
    legend_above(rows[2], min(4, len(names)))
    return figure


def _line(axes: Axes, at: np.ndarray, values: np.ndarray, *, color: str, label: str = "") -> None:
    """Draw a line, as a dot where it has one point."""
    alone = np.isfinite(values).sum() == 1
    axes.plot(at, values, color=color, label=label or None, marker="o" if alone else "")


def _draw_closed_form(
    axes: Axes, manifest: Manifest, found: Sequence[Production], unit: Unit
) -> bool:
    """Draw the closed form dotted, if one applies, and return True then."""
    facts, last = found[-1].facts, found[-1]
    start = last.time - last.elapsed
    elapsed = np.linspace(0.0, last.elapsed, POINTS + 1)[1:]
    T = closed_form_temperature(facts, elapsed)
    if T is None:
        return False
    axes.plot(
        manifest.shown.time.of(start + elapsed), unit.of(T), color=BLACK, linestyle=":",
        linewidth=1.2, label="closed form",
    )  # fmt: skip
    return True


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
