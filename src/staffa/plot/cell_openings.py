"""Cracks in the colors of their openings in the cells of a reservoir, over its temperature."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LinearSegmentedColormap, ListedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from matplotlib.tri import Triangulation

from staffa.io.reservoir_fields import ReservoirFields
from staffa.records.reservoir_facts import ReservoirFacts

COLORS = "plasma"
WHITE = 0.45  # share of white in the colors of the temperature below cracks
PALE = ListedColormap(colormaps[COLORS](np.linspace(0, 1, 256)) * (1 - WHITE) + WHITE, "pale")
OPENINGS = LinearSegmentedColormap.from_list("openings", ["#57a5d8", "#174f8f", "#04101f"])
LINE = 0.6  # points around a triangle, so that narrow bands of damage show
MM = 1e3
DECADES = 2.0  # of the scale at most: the flow in narrower cracks is a millionth


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


@dataclass(frozen=True, kw_only=True)
class CellOpenings:
    """Openings of cracks in the cells of a plane.

    Attributes
    ----------
    edges : faces of the cells along both axes, in the displayed unit, shapes (n + 1,), (m + 1,).
    w : opening of cracks (m), shape (n, m).
    scale : scale of openings (mm).
    """

    edges: tuple[np.ndarray, np.ndarray]
    w: np.ndarray
    scale: LogNorm

    def at(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the opening in the cell around each point (mm), at least the end of the scale.

        Parameters
        ----------
        x, y : coordinates in the displayed unit, of one shape.
        """
        place = tuple(
            np.searchsorted(edges[1:-1], at) for edges, at in zip(self.edges, (x, y), strict=True)
        )
        return np.maximum(MM * self.w[place], self.scale.vmin or 0.0)

    def draw_triangles(self, axes: Axes, triangles: Triangulation, cracked: np.ndarray) -> None:
        """Draw cracked triangles in the colors of the openings.

        Parameters
        ----------
        axes : the panel.
        triangles : the triangles, in the displayed unit.
        cracked : True at cracked vertices, shape (n,).
        """
        kept = triangles.triangles[cracked[triangles.triangles].any(axis=1)]
        if not len(kept):
            return
        x, y = triangles.x, triangles.y
        colors = self.at(x[kept].mean(axis=1), y[kept].mean(axis=1))
        axes.tripcolor(
            Triangulation(x, y, kept), facecolors=colors, cmap=OPENINGS, norm=self.scale,
            edgecolors="face", linewidth=LINE,
        )  # fmt: skip

    def draw_points(self, axes: Axes, x: np.ndarray, y: np.ndarray, cracked: np.ndarray) -> None:
        """Draw cracked points of a raster in the colors of the openings.

        Parameters
        ----------
        axes : the panel.
        x, y : coordinates of the raster, in the displayed unit, shapes (n,) and (m,).
        cracked : True at cracked points, shape (n, m).
        """
        colors = self.at(*np.meshgrid(x, y, indexing="ij"))
        shown = np.ma.masked_where(~cracked, colors)
        axes.pcolormesh(x, y, shown.T, cmap=OPENINGS, norm=self.scale, shading="nearest")


def cell_openings(
    edges: tuple[np.ndarray, np.ndarray],
    section: Callable[[np.ndarray], np.ndarray],
    w: np.ndarray | None,
    scale: LogNorm | None,
) -> CellOpenings | None:
    """Return the openings in the cells of a section; None where these are not known.

    Parameters
    ----------
    edges : faces of its cells along both axes, in the displayed unit.
    section : function from values of all cells to those of the section.
    w : opening of cracks in all cells (m), shape (n_cells,).
    scale : scale of openings (mm).
    """
    if w is None or scale is None:
        return None
    return CellOpenings(edges=edges, w=section(w), scale=scale)


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
