"""Crack network at selected times, colored by its opening."""

from collections.abc import Sequence
from math import ceil

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Colormap, ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from staffa.measure.network import Network
from staffa.plot.cracks import extent, layout
from staffa.plot.labels import moment
from staffa.plot.style import WIDTH, new_figure
from staffa.records.manifest import Manifest
from staffa.records.step import Step

# Closed cracks are pale, but not so pale that a thin line is lost on white.
COLORS = ListedColormap(colormaps["viridis_r"](np.linspace(0.25, 1, 256)), "openings")
UNKNOWN = "0.5"  # gray: the opening is not known
# Height (inches) of the titles and labels of a row, in addition to that of `layout`.
TITLE = 0.2
NARROW, WIDE = 0.8, 3.0  # points: the width of a line, closed and widest open
Moment = tuple[Step, Network]


def network_figure(
    manifest: Manifest, moments: Sequence[Moment], outline: np.ndarray | None = None
) -> Figure:
    """Draw one panel a time, at most a few; in 3-D only the last; all with one color scale.

    Cracks are gray if the opening is not known, as in runs of an earlier version. The scale is left
    out if no opening is known.

    Parameters
    ----------
    manifest : description of the run.
    moments : steps and their networks.
    outline : sides of a 2-D body and its holes (m), shape (k, 2, 2).
    """
    unit = manifest.shown.opening
    widest = max(float(np.nanmax(cracks.opening, initial=0.0)) for _, cracks in moments)
    norm = Normalize(0.0, unit.of(widest or unit.size))
    if len(manifest.size) == 3:
        figure, axes = _solid(manifest, moments[-1], norm)
    else:
        figure, axes = _plane(manifest, moments, norm, outline)
    if all(np.isnan(cracks.opening).all() for _, cracks in moments):
        return figure
    figure.colorbar(
        ScalarMappable(norm, _colors()), ax=axes, location="bottom", shrink=0.5, aspect=40,
        label=unit.label("opening"), ticks=MaxNLocator(4),
    )  # fmt: skip
    return figure


def _plane(
    manifest: Manifest, moments: Sequence[Moment], norm: Normalize, outline: np.ndarray | None
) -> tuple[Figure, list[Axes]]:
    columns, height = layout(manifest.size, len(moments))
    rows = ceil(len(moments) / columns)
    figure = new_figure(height + rows * TITLE)
    grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    x, y = extent(manifest)
    for number, axes in enumerate(grid.flat):
        if number >= len(moments):
            axes.set_axis_off()
            continue
        step, cracks = moments[number]
        opening = mean_opening(manifest, cracks)
        widths = NARROW + (WIDE - NARROW) * np.clip(norm(np.nan_to_num(opening)), 0, 1)
        lines = manifest.shown.length.of(cracks.points[cracks.elements][..., :2])
        axes.add_collection(
            LineCollection(
                lines,
                array=np.ma.masked_invalid(opening),
                norm=norm,
                cmap=_colors(),
                linewidths=widths,
                capstyle="round",
            )
        )
        if outline is not None:
            axes.add_collection(
                LineCollection(
                    list(manifest.shown.length.of(outline)), colors="0.6", linewidths=0.6
                )
            )
        axes.grid(False)
        axes.set(xlim=x, ylim=y, aspect="equal")
        for side in axes.spines.values():
            side.set_visible(True)
        axes.set_title(moment(manifest, step), loc="left", pad=3)
        if number + columns >= len(moments):
            axes.set_xlabel(manifest.shown.length.label("r" if manifest.axial else "x"))
            axes.tick_params(labelbottom=True)
        if number % columns == 0:
            axes.set_ylabel(manifest.shown.length.label("z" if manifest.axial else "y"))
    return figure, list(grid.flat)


def _solid(manifest: Manifest, last: Moment, norm: Normalize) -> tuple[Figure, list[Axes]]:
    (step, cracks), length = last, manifest.shown.length
    figure = new_figure(WIDTH * 0.8)
    axes = figure.add_subplot(projection="3d")
    opening = np.ma.masked_invalid(mean_opening(manifest, cracks))
    colors = ScalarMappable(norm, _colors()).to_rgba(opening)
    axes.add_collection3d(
        Poly3DCollection(
            length.of(cracks.points[cracks.elements]),
            facecolors=colors,
            edgecolors="#0003",
            linewidths=0.2,
        )
    )
    x, y, z = extent(manifest)
    axes.set(xlim=x, ylim=y, zlim=z, aspect="equal")
    axes.set_xlabel(manifest.shown.length.label("x"))
    axes.set_ylabel(manifest.shown.length.label("y"))
    axes.set_zlabel(manifest.shown.length.label("z"))
    axes.set_title(moment(manifest, step), loc="left")
    return figure, [axes]


def _colors() -> Colormap:
    return COLORS.with_extremes(bad=UNKNOWN)


def mean_opening(manifest: Manifest, cracks: Network) -> np.ndarray:
    """Return the mean opening of each element in the displayed unit, shape (n,)."""
    return manifest.shown.opening.of(cracks.opening[cracks.elements].mean(axis=1))
