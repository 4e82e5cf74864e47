"""Injectivity, exchange area and cracks of a run against time, with cracks and without."""

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter

from staffa.display_units import Unit
from staffa.io.production_rows import Production
from staffa.plot.production_curves import DASHED, SOLID, draw_line
from staffa.plot.style import BLACK, BLUE, GREEN, ORANGE, PURPLE, legend_above, new_figure
from staffa.records.manifest import Manifest

WIDE = 30.0  # largest over smallest value from which an axis is logarithmic
ABOVE = 0.08  # space above the lines, over their largest value
Value = Callable[[Production], float]


def exchange_figure(
    manifest: Manifest, found: Sequence[Production], without: Sequence[Production] = ()
) -> Figure:
    """Draw injectivity and exchange area against time, and area and volume of cracks if any.

    Parameters
    ----------
    manifest : description of the run, which has a reservoir.
    found : the production of its steps, two or more.
    without : the same without cracks, drawn dashed; none where that is not known.
    """
    panels: list[tuple[str, str, str, Value]] = [
        ("injectivity", "kg/s/Pa", BLUE, lambda one: one.injectivity),
        ("exchange area", "m²", ORANGE, lambda one: one.area),
    ]
    if any(one.cracks for one in found):
        panels += [
            ("crack area", "m²", GREEN, lambda one: one.cracks.area if one.cracks else np.nan),
            ("crack volume", "m³", PURPLE, lambda one: one.cracks.volume if one.cracks else np.nan),
        ]
    figure = new_figure(2.3 * len(panels) / 2 + 0.5, gap=0.06)
    rows = figure.subplots(len(panels) // 2, 2, squeeze=False, sharex=True)
    for axes, (name, unit, color, value) in zip(rows.flat, panels, strict=True):
        series = [np.array([value(one) for one in seen]) for seen in (found, without)]
        known = np.concatenate([values[np.isfinite(values)] for values in series])
        scale = _unit(unit, known)
        for seen, values, style in zip((found, without), series, (SOLID, DASHED), strict=True):
            if not len(values):
                continue
            at = np.array([manifest.shown.time.of(one.time) for one in seen])
            draw_line(axes, at, scale.of(values), style, color=color)
        axes.set_ylabel(scale.label(name))
        _limit(axes, known, wide=name == "injectivity")
    for axes in rows[-1]:
        axes.set_xlabel(manifest.shown.time.label("time"))
    if without:
        for style, label in ((SOLID, "with cracks"), (DASHED, "without cracks")):
            rows[0, 0].plot([], [], color=BLACK, label=label, **style)
        legend_above(rows[0, 0], 2)
    return figure


def _unit(name: str, known: np.ndarray) -> Unit:
    """Return the unit of a panel: injectivity per MPa, small volumes in liters.

    Parameters
    ----------
    name : the SI unit.
    known : the values (SI), shape (n,).
    """
    largest = float(np.abs(known).max(initial=0.0))
    if name == "kg/s/Pa":
        return Unit(name="kg/s/MPa", size=1e-6)
    if name == "m³" and 0 < largest < 1:
        return Unit(name="L", size=1e-3)
    return Unit(name=name)


def _limit(axes: Axes, known: np.ndarray, *, wide: bool) -> None:
    """Let an axis begin at 0, or be logarithmic where its values differ widely and may.

    Parameters
    ----------
    axes : the panel.
    known : its values, shape (n,).
    wide : True for an axis that may be logarithmic: growth from nothing is seen on a linear one.
    """
    plain = FuncFormatter(lambda value, _: f"{value:,g}")
    if not len(known):
        axes.annotate("not known", (0.5, 0.5), xycoords="axes fraction", ha="center", va="center")
    elif wide and known.min() > 0 and known.max() > WIDE * known.min():
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter(plain)
        axes.yaxis.set_minor_formatter(NullFormatter())
    else:
        low, high = axes.dataLim.intervaly
        axes.set_ylim(min(0.0, low), (1 + ABOVE) * high if high > 0 else 1.0)
        axes.yaxis.set_major_formatter(plain)
