"""Openings of cracks in the cells of a reservoir, drawn over their temperature."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, ListedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from scipy.ndimage import maximum_filter

from staffa.io.reservoir_fields import ReservoirFields
from staffa.records.reservoir_facts import ReservoirFacts

COLORS = "RdYlBu_r"
WHITE = 0.45  # share of white in the colors of the temperature below cracks
PALE = ListedColormap(colormaps[COLORS](np.linspace(0, 1, 256)) * (1 - WHITE) + WHITE, "pale")
OPENINGS = LinearSegmentedColormap.from_list("openings", ["#8fd18a", "#1f7a3a", "#04140a"])
MIDDLE = 0.7  # of the largest area nearby, from which a cell counts as on the middle of a crack
BENT = 0.4  # second difference of the area over itself, from which it does
MM = 1e3
DECADES = 2.0  # the scale of openings is at least so long that equal ones are not told apart


def crack_openings(facts: ReservoirFacts, found: Sequence[ReservoirFields]) -> LogNorm | None:
    """Return the scale of the openings of cracks (mm); None where no cell has any.

    Parameters
    ----------
    facts : the reservoir.
    found : fields of its cells at some times.
    """
    known = [of.w[of.A > 0] for of in found if of.w is not None and of.A is not None]
    widest = max((float(w.max()) for w in known if w.size), default=0.0)
    if not widest > 0:
        return None
    least = facts.cracks.smallest if facts.cracks else 0.0
    return LogNorm(MM * max(least, widest / 10**DECADES) * (1 - 1e-9), MM * widest)


def middles_of_cracks(A: np.ndarray) -> np.ndarray:
    """Return True in the cells along the middle of cracks, which are spread over more, (n, m).

    There the area is near the largest of the neighbors, or bent down across the crack: beside a
    junction, where areas of two cracks add up, only the latter tells.

    Parameters
    ----------
    A : area of cracks in a unit of volume (1/m) in the cells of a section, shape (n, m).
    """
    near = np.pad(A, 1, mode="edge")
    pairs = [(near[1 + i : near.shape[0] - 1 + i, 1 + j : near.shape[1] - 1 + j],
              near[1 - i : near.shape[0] - 1 - i, 1 - j : near.shape[1] - 1 - j])
             for i, j in ((0, 1), (1, 0), (1, 1), (1, -1))]  # fmt: skip
    bend = np.max([2 * A - one - other for one, other in pairs], axis=0)
    highest = MIDDLE * maximum_filter(A, size=3) <= A
    return np.asarray((A > 0) & (highest | (bend >= BENT * A)))


def draw_openings(
    axes: Axes,
    edges: tuple[np.ndarray, np.ndarray],
    w: np.ndarray,
    A: np.ndarray,
    scale: LogNorm,
) -> None:
    """Draw the openings of cracks as colors of the cells along their middle.

    Parameters
    ----------
    axes : the panel.
    edges : faces of the cells along both axes, in the displayed unit, shapes (n + 1,), (m + 1,).
    w : opening of cracks (m), shape (n, m).
    A : area of cracks in a unit of volume (1/m), shape (n, m).
    scale : scale of openings (mm).
    """
    shown = np.ma.masked_where(~middles_of_cracks(A), np.maximum(MM * w, scale.vmin or 0.0))
    axes.pcolormesh(*edges, shown.T, cmap=OPENINGS, norm=scale, rasterized=True)


def openings_bar(figure: Figure, panels: np.ndarray, scale: LogNorm, place: Any) -> None:
    """Draw the bar of these colors, with plain numbers.

    Parameters
    ----------
    figure : the figure.
    panels : its panels.
    scale : scale of openings (mm).
    place : keys of the place and size of the bar.
    """
    found = figure.colorbar(
        ScalarMappable(scale, OPENINGS), ax=panels, label="opening of cracks (mm)", **place
    )
    found.ax.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    found.ax.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    found.ax.xaxis.set_minor_formatter(NullFormatter())
