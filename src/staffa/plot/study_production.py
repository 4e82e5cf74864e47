"""Production of a study against time: a curve for each point."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from staffa.display_units import prefixed
from staffa.io.production_rows import production
from staffa.io.run_directory import Run
from staffa.measure.averages import Spread
from staffa.plot.ensemble_curves import BAND
from staffa.plot.ensemble_production import ALONE, production_spreads
from staffa.plot.style import new_figure
from staffa.records.manifest import Manifest

MOST_NAMED = 18  # curves with a name each; of more the color shows the first parameter
PANELS_OF_POINTS = {"T": "temperature", "power": "power", "heat": "energy"}


@dataclass(frozen=True, kw_only=True)
class PointProduction:
    """Production of the runs of a point.

    Attributes
    ----------
    label : its parameters in words.
    place : value of the first parameter, or the number of the point.
    spreads : temperature (K), power (W) and heat (J) over time (s), means over its runs.
    """

    label: str
    place: float
    spreads: Mapping[str, Spread]


def point_production(label: str, place: float, runs: Sequence[Run]) -> PointProduction | None:
    """Return the production of the finished runs of a point; None without water.

    Parameters
    ----------
    label : its parameters in words.
    place : value of the first parameter, or the number of the point.
    runs : its finished runs.
    """
    if len(runs) > 1:
        spreads = production_spreads(runs)
        return PointProduction(label=label, place=place, spreads=spreads) if spreads else None
    found = [one for run in runs for one in production(run.manifest.reservoir, run.steps)]
    if not found:
        return None
    at = np.array([one.time for one in found])
    single = {name: np.array([value(one) for one in found]) for name, value in ALONE.items()}
    return PointProduction(
        label=label,
        place=place,
        spreads={
            name: Spread(at=at, values=values[None], mean=values, error=np.zeros_like(values))
            for name, values in single.items()
        },
    )


def study_production_figure(
    manifest: Manifest, title: str, points: Sequence[PointProduction]
) -> Figure:
    """Draw production temperature, power and energy of each point against time.

    Parameters
    ----------
    manifest : description of the first run.
    title : names of the parameters, the first with its unit.
    points : production of each point.
    """
    few = len(points) <= MOST_NAMED
    scale = Normalize(0, (len(points) - 1) / 0.88) if few else _scale(points)
    color_of = ScalarMappable(scale, "viridis")
    colors = color_of.to_rgba(np.array([k if few else p.place for k, p in enumerate(points)]))
    figure = new_figure(1.0 + 1.6 * len(PANELS_OF_POINTS) + 0.06 * few * len(points))
    rows = figure.subplots(len(PANELS_OF_POINTS), 1, sharex=True)
    for axes, (name, label) in zip(rows, PANELS_OF_POINTS.items(), strict=True):
        largest = max(float(np.abs(one.spreads[name].values).max(initial=0.0)) for one in points)
        unit = prefixed("W" if name == "power" else "J", largest)
        unit = manifest.shown.temperature if name == "T" else unit
        for color, one in zip(colors, points, strict=True):
            seen = one.spreads[name]
            at = manifest.shown.time.of(seen.at)
            if seen.error.any():
                low, high = unit.of(seen.mean - seen.error), unit.of(seen.mean + seen.error)
                axes.fill_between(at, low, high, color=color, **BAND)
            marker = "." if len(at) < 12 else None
            axes.plot(at, unit.of(seen.mean), color=color, label=one.label, marker=marker)
        axes.set_ylabel(unit.label(label))
        if name != "T":
            axes.set_ylim(bottom=min(0.0, axes.dataLim.ymin))
    rows[-1].set_xlabel(manifest.shown.time.label("time"))
    if few:
        handles, labels = rows[0].get_legend_handles_labels()
        figure.legend(
            handles, labels, loc="outside upper left", ncols=3, title=title, alignment="left"
        )
    else:
        figure.colorbar(color_of, ax=list(rows), label=title.split(", ")[0])
    return figure


def _scale(points: Sequence[PointProduction]) -> Normalize:
    places = [point.place for point in points]
    return Normalize(min(places), max(places))
