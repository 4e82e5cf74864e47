"""Curves of a picture as data for a page, where a reader can hover and zoom."""

import re
from collections.abc import Sequence
from html import escape
from typing import Any, TypeGuard

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import FillBetweenPolyCollection, LineCollection
from matplotlib.colors import to_hex
from matplotlib.container import ErrorbarContainer
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Annotation, Text
from matplotlib.ticker import FixedFormatter, FuncFormatter

from staffa.plot.labels import without_math

Chart = dict[str, Any]  # data and layout, as Plotly reads them
UNIT = re.compile(r"\(([^()]+)\)$")  # of a label: "energy (kJ)"
DIGITS = 6  # of the numbers of a chart
FEW = 6  # lines of a panel whose values are shown together; of more, that of the nearest
WHOLE = 8  # largest count on an axis with a tick at each whole number
DASHES = {"-": "solid", "--": "dash", ":": "dot", "-.": "dashdot", "None": "solid"}
SYMBOLS = {"o": "circle", "s": "square", "D": "diamond", ".": "circle"}
PIXEL = 96 / 72  # of a screen, in points
REFERENCES = {"data": "", "axes fraction": " domain"}


def charts(figure: Figure) -> tuple[Chart, ...]:
    """Return a chart for each panel of a figure of curves; none if it shows anything else.

    Parameters
    ----------
    figure : a picture, drawn or not.
    """
    panels = [axes for axes in figure.axes if axes.axison]
    return tuple(map(_chart, panels)) if all(map(_has_curves, panels)) else ()


def rounded(values: Any) -> list[float | None]:
    """Return numbers of few digits, None where there is none.

    Parameters
    ----------
    values : the numbers, shape (n,).
    """
    found = np.asarray(values, float).tolist()
    return [float(f"{v:.{DIGITS}g}") if np.isfinite(v) else None for v in found]


def _has_curves(axes: Axes) -> bool:
    known = (FillBetweenPolyCollection, LineCollection)
    return bool(
        axes.name == "rectilinear"
        and axes.get_aspect() == "auto"
        and axes.lines
        and not axes.images
        and all(isinstance(found, known) for found in axes.collections)
    )


def _chart(axes: Axes) -> Chart:
    """Return the lines, bands, errors and marks of a panel, and its axes with their labels."""
    label, below = axes.get_ylabel(), _label_below(axes)
    bars = [one for one in axes.containers if isinstance(one, ErrorbarContainer)]
    errors = {one.lines[0]: one for one in bars}
    caps = {cap for one in bars for cap in one.lines[1]}
    curves = [
        line for line in axes.lines if line.get_transform() == axes.transData and line not in caps
    ]
    bands = [band for band in axes.collections if isinstance(band, FillBetweenPolyCollection)]
    unit = _unit(label)
    title = _legend_title(axes)
    return {
        "data": [
            *(trace for band in bands for trace in _band(band)),
            *(_trace(line, unit, errors.get(line)) for line in curves),
        ],
        "layout": {
            "xaxis": _axis(axes.get_xlim(), axes.get_xscale(), below) | _texts(axes),
            "yaxis": _axis(axes.get_ylim(), axes.get_yscale(), label) | _ticks(axes, curves),
            "legend": {"title": {"text": escape(title, quote=False)}},
            "shapes": [
                _straight(line) for line in axes.lines if line.get_transform() != axes.transData
            ],
            "annotations": [_note(text) for text in axes.texts if _is_known(text)],
            "hovermode": "x unified" if len(curves) <= FEW else "closest",
            "unit": _unit(below),
        },
    }


def _legend_title(axes: Axes) -> str:
    """Return the title of the legend of a panel, or of its figure; empty for none."""
    figure = axes.get_figure(root=True)
    legends = [axes.get_legend(), *(figure.legends if figure else ())]
    return next((legend.get_title().get_text() for legend in legends if legend), "")


def _label_below(axes: Axes) -> str:
    """Return the label of the axis below, which may be that of another panel."""
    panels = [axes, *axes.get_shared_x_axes().get_siblings(axes)]
    return next((text for one in panels if (text := without_math(one.get_xlabel()))), "")


def _unit(label: str) -> str:
    """Return the unit of a label with a space before it, or nothing."""
    found = UNIT.search(label)
    return f" {found[1]}" if found else ""


def _axis(limits: tuple[float, float], scale: str, label: str) -> dict[str, Any]:
    ends = np.log10(limits) if scale == "log" else limits
    return {
        "title": {"text": escape(label, quote=False)},
        "range": rounded(ends),
        "type": scale,
    }


def _ticks(axes: Axes, curves: Sequence[Line2D]) -> dict[str, Any]:
    """Return a tick at each whole number for an axis of a few counts."""
    numbers = [np.asarray(line.get_ydata(), float) for line in curves]
    whole = all(np.array_equal(y, np.round(y), equal_nan=True) for y in numbers)
    return {"dtick": 1} if whole and axes.get_ylim()[1] <= WHOLE else {}


def _texts(axes: Axes) -> dict[str, Any]:
    """Return the ticks of an axis of texts, and nothing for one of numbers."""
    shown = axes.xaxis.get_major_formatter()
    if not isinstance(shown, FixedFormatter | FuncFormatter):
        return {}
    ticks = axes.get_xticks()
    texts = [escape(str(shown(tick, at)), quote=False) for at, tick in enumerate(ticks)]
    return {"tickmode": "array", "tickvals": rounded(ticks), "ticktext": texts}


def _trace(line: Line2D, unit: str, bars: ErrorbarContainer | None) -> dict[str, Any]:
    """Return a line with its name and its error bars.

    Parameters
    ----------
    line : the line.
    unit : unit of its values, with a space before it, or nothing.
    bars : its error bars; None for none.
    """
    labels = [str(one.get_label() or "_") for one in (line, bars) if one is not None]
    label = next((one for one in labels if not one.startswith("_")), "")
    named = bool(label)
    marker, dash = SYMBOLS.get(str(line.get_marker())), line.get_linestyle()
    drawn = dash not in ("None", "")
    color = to_hex(line.get_color())
    value = f"%{{y:.4~g}}{escape(unit, quote=False)}"
    trace: dict[str, Any] = {
        "type": "scatter",
        "x": rounded(line.get_xdata()),
        "y": rounded(line.get_ydata()),
        "name": escape(label, quote=False) if named else "",
        "showlegend": named,
        "mode": "+".join(["lines"] * drawn + ["markers"] * (marker is not None)) or "lines",
        "line": {
            "color": color,
            "width": PIXEL * line.get_linewidth(),
            "dash": DASHES.get(str(dash), "dash"),
            "shape": "hv" if line.get_drawstyle() == "steps-post" else "linear",
        },
        "marker": {
            "color": color, "symbol": marker or "circle", "size": PIXEL * line.get_markersize(),
        },
        "opacity": line.get_alpha() or 1.0,
        "hovertemplate": value + ("" if named else "<extra></extra>"),
    }  # fmt: skip
    if bars is not None:
        errors = _errors(bars)
        trace["error_y"] = {"type": "data", "array": rounded(errors), "thickness": 1.2, "width": 4}
        trace["customdata"] = rounded(errors)
        trace["hovertemplate"] = f"{value} ± %{{customdata:.2~g}}"
    return trace


def _errors(bars: ErrorbarContainer) -> np.ndarray:
    """Return half the height of each error bar, shape (n,)."""
    found = [np.ptp(ends[:, 1]) / 2 for ends in bars.lines[2][0].get_segments() if len(ends)]
    return np.array(found)


def _band(band: FillBetweenPolyCollection) -> list[dict[str, Any]]:
    """Return a band as filled polygons."""
    label, color = str(band.get_label()), to_hex(tuple(np.ravel(band.get_facecolor())[:3]))
    named = not label.startswith("_")
    return [
        {
            "type": "scatter",
            "x": rounded(np.asarray(path.vertices)[:, 0]),
            "y": rounded(np.asarray(path.vertices)[:, 1]),
            "name": escape(label, quote=False) if named else "",
            "showlegend": named and number == 0,
            "mode": "lines",
            "fill": "toself",
            "fillcolor": color,
            "line": {"color": color, "width": 0},
            "opacity": band.get_alpha() or 1.0,
            "hoverinfo": "skip",
        }
        for number, path in enumerate(band.get_paths())
    ]


def _straight(line: Line2D) -> dict[str, Any]:
    """Return a line across all of a panel as a shape."""
    x, y = (np.asarray(ends, float) for ends in (line.get_xdata(), line.get_ydata()))
    upright = x[0] == x[-1]
    across = {"xref": "x", "yref": "y domain"} if upright else {"xref": "x domain", "yref": "y"}
    return {
        "type": "line", **across,
        "x0": float(x[0]), "x1": float(x[-1]), "y0": float(y[0]), "y1": float(y[-1]),
        "line": {
            "color": to_hex(line.get_color()), "width": line.get_linewidth(),
            "dash": DASHES.get(str(line.get_linestyle()), "dot"),
        },
    }  # fmt: skip


def _is_known(text: Text) -> TypeGuard[Annotation]:
    """Return True for a text beside a point that a chart can have too."""
    if not isinstance(text, Annotation):
        return False
    found = text.xycoords if isinstance(text.xycoords, tuple) else (text.xycoords,)
    return all(isinstance(one, str) and one in REFERENCES for one in found)


def _note(text: Annotation) -> dict[str, Any]:
    """Return a text beside a point."""
    coordinates = text.xycoords
    across, up = coordinates if isinstance(coordinates, tuple) else (coordinates, coordinates)
    beside = text.get_position() if text.anncoords == "offset points" else (0.0, 0.0)
    return {
        "text": escape(text.get_text(), quote=False), "showarrow": False,
        "x": float(text.xy[0]), "y": float(text.xy[1]),
        "xref": f"x{REFERENCES[str(across)]}", "yref": f"y{REFERENCES[str(up)]}",
        "xanchor": text.get_horizontalalignment(), "yanchor": "bottom",
        "xshift": beside[0], "yshift": beside[1],
        "font": {"color": to_hex(text.get_color()), "size": 11},
    }  # fmt: skip
