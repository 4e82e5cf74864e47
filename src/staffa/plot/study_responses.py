"""Response curves of a study: results over a parameter, means and errors of the seeds."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from staffa.measure.averages import average
from staffa.plot.style import BLACK, GENERATIONS, new_figure

COLUMNS = 2
FEWEST_APART = 6.5  # extent of an axis over the smallest distance of its ticks
POINTS: Any = {"marker": ".", "linestyle": "none", "markersize": 4, "alpha": 0.45}
MEANS: Any = {"marker": "o", "markersize": 4, "linewidth": 1.2, "capsize": 2.5, "elinewidth": 1.0}


@dataclass(frozen=True, kw_only=True)
class Response:
    """One result of all points.

    Attributes
    ----------
    label : its name, with its unit.
    values : values of the finished runs of each point.
    """

    label: str
    values: Sequence[Sequence[float]]


@dataclass(frozen=True, kw_only=True)
class Abscissa:
    """Parameter over which results are drawn.

    Attributes
    ----------
    label : its name, with its unit.
    values : its value at each point, numbers or texts.
    curves : name of each curve, and the points on it; one without a name for points that are no
        curve.
    others : names of the parameters that differ from curve to curve; empty without any.
    """

    label: str
    values: Sequence[float | str]
    curves: Sequence[tuple[str, Sequence[int]]]
    others: str = ""

    @property
    def places(self) -> np.ndarray:
        """Place of each point on the axis, shape (points,): its number, or the rank of its text."""
        numbers = [value for value in self.values if not isinstance(value, str)]
        if len(numbers) == len(self.values):
            return np.array(numbers)
        return np.array([self.texts.index(str(value)) for value in self.values], dtype=float)

    def spans(self, response: Response) -> bool:
        """Return True if a result is known at two different values of the parameter."""
        known = [bool(values) for values in response.values]
        return len(np.unique(self.places[known])) > 1

    @property
    def texts(self) -> list[str]:
        """Each value once, as text, in order."""
        return list(dict.fromkeys(str(value) for value in self.values))

    @property
    def has_few_places(self) -> bool:
        """True if each value has room for a tick with its number."""
        places = np.unique(self.places)
        return bool(np.ptp(places) < FEWEST_APART * np.diff(places, append=np.inf).min())

    @property
    def is_text(self) -> bool:
        """True if the values are no numbers."""
        return any(isinstance(value, str) for value in self.values)


def response_figure(abscissa: Abscissa, responses: Sequence[Response]) -> Figure:
    """Draw each result over a parameter: means with standard errors, and each run as a small dot.

    Parameters
    ----------
    abscissa : the parameter, and the curves.
    responses : the results, a panel for each.
    """
    columns = min(COLUMNS, len(responses))
    rows = -(-len(responses) // columns)
    figure = new_figure(0.7 + 1.9 * rows + 0.2 * len(abscissa.curves) / 3)
    panels = figure.subplots(rows, columns, squeeze=False, sharex=True)
    for axes, response in zip(panels.flat, responses, strict=False):
        for color, curve in zip(GENERATIONS, abscissa.curves, strict=False):
            _draw(axes, abscissa, response, curve, color)
        axes.set_ylabel(response.label)
        axes.set_xlabel(abscissa.label)
        axes.tick_params(labelbottom=True)
        if abscissa.is_text:
            axes.set_xticks(range(len(abscissa.texts)), abscissa.texts)
            axes.margins(x=0.2)
        elif abscissa.has_few_places:
            axes.set_xticks(np.unique(abscissa.places))
        else:
            axes.xaxis.set_major_locator(MaxNLocator(6))
        axes.yaxis.get_major_formatter().set_useOffset(False)
    for axes in list(panels.flat)[len(responses) :]:
        axes.set_axis_off()
    several = any(len(values) > 1 for response in responses for values in response.values)
    _legend(figure, abscissa, several)
    return figure


def _draw(
    axes: Axes,
    abscissa: Abscissa,
    response: Response,
    curve: tuple[str, Sequence[int]],
    color: str,
) -> None:
    """Draw one curve: runs, then means with errors."""
    name, points = curve
    order = sorted(points, key=lambda point: abscissa.places[point])
    known = [point for point in order if response.values[point]]
    places = abscissa.places
    for point in known:
        values = response.values[point]
        if len(values) > 1:
            axes.plot([places[point]] * len(values), values, color=color, **POINTS)
    found = [average(response.values[point]) for point in known]
    errors = [a.error or 0.0 for a in found]
    means = [np.nan if a.mean is None else a.mean for a in found]
    line = "-" if len(abscissa.curves) > 1 or abscissa.others == "" else "none"
    bars = axes.errorbar(places[known], means, yerr=errors, color=color, linestyle=line, **MEANS)
    bars.lines[0].set_label(name or "_")


def _legend(figure: Figure, abscissa: Abscissa, several: bool) -> None:
    """Name curves above all panels, and means and runs if points have several runs."""
    handles = [
        Line2D([], [], color=color, marker="o", markersize=4, label=name)
        for color, (name, _) in zip(GENERATIONS, abscissa.curves, strict=False)
        if name
    ]
    if several:
        mean: Any = {"marker": "o", "markersize": 4, "linestyle": "none"}
        handles += [
            Line2D([], [], color=BLACK, label="mean, standard error", **mean),
            Line2D([], [], color=BLACK, label="each run", **POINTS),
        ]
    if handles:
        title = abscissa.others if len(abscissa.curves) > 1 else None
        figure.legend(
            handles=handles, loc="outside upper left", ncols=5, title=title, alignment="left"
        )
