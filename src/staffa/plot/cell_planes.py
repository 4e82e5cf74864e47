"""Pictures of polygonal cells: on depth planes of a 3-D body, and their size against depth."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from staffa.display_units import Unit
from staffa.measure.cells import Cells
from staffa.measure.patterns import Estimate, Pattern
from staffa.plot.labels import moment
from staffa.plot.style import BLACK, BLUE, ORANGE, WIDTH, legend_above, new_figure
from staffa.records.manifest import Manifest
from staffa.records.step import Step

# Colors by number of neighbors; the first and the last include fewer and more; six is the middle.
NEIGHBORS = {
    3: "#2b6cb0", 4: "#6fa8d6", 5: "#b5d6ea", 6: "#f6e3a1", 7: "#f0a35e", 8: "#c9493b",
}  # fmt: skip
AT_THE_END = "#e9e8e4"  # of cells that an end of the body cuts
OUTSIDE = "#ffffff"
CRACK = to_rgb("#14100c")
PANELS_ACROSS = 3
THEORY: Any = {"color": BLACK, "linewidth": 1.2}


@dataclass(frozen=True, kw_only=True)
class ColumnPlane:
    """Depth plane with its damage and cells.

    Attributes
    ----------
    depth : depth below the cooled face (m).
    axes : the two axes in the plane.
    extent : ends of the plane along these axes (m).
    damage : damage of each pixel, NaN outside the body, shape (n_x, n_y).
    threshold : damage above which a pixel is cracked.
    cells : the polygonal cells.
    """

    depth: float
    axes: tuple[int, int]
    extent: tuple[tuple[float, float], tuple[float, float]]
    damage: np.ndarray
    threshold: float
    cells: Cells


@dataclass(frozen=True, kw_only=True)
class ReferenceCurve:
    """Curve for comparison.

    Attributes
    ----------
    name : its label.
    depths : depths (m), shape (n,).
    lengths : lengths at these depths (m), shape (n,).
    """

    name: str
    depths: np.ndarray
    lengths: np.ndarray


def sections_figure(manifest: Manifest, step: Step, planes: Sequence[ColumnPlane]) -> Figure:
    """Draw a panel for each plane: cracks dark, cells colored by their number of neighbors.

    Parameters
    ----------
    manifest : description of the run.
    step : the step that is drawn.
    planes : its depth planes.
    """
    across = min(PANELS_ACROSS, len(planes))
    rows = ceil(len(planes) / across)
    length = manifest.shown.length
    (left, right), (low, high) = planes[0].extent
    tall = (WIDTH - 0.6) / across * (high - low) / (right - left)
    figure = new_figure(min(rows * (tall + 0.1) + 0.85, 2 * WIDTH))
    grid = figure.subplots(rows, across, squeeze=False, sharex=True, sharey=True)
    for number, axes in enumerate(grid.flat):
        if number >= len(planes):
            axes.set_axis_off()
            continue
        _draw_plane(axes, manifest, planes[number])
        if number + across >= len(planes):
            axes.set_xlabel(length.label("xyz"[planes[number].axes[0]]))
            axes.tick_params(labelbottom=True)
        if number % across == 0:
            axes.set_ylabel(length.label("xyz"[planes[number].axes[1]]))
    figure.legend(
        handles=_classes(), loc="outside upper left", ncols=len(NEIGHBORS) + 1, handlelength=1.2,
        columnspacing=1.2, borderaxespad=0.1,
        title=f"{moment(manifest, step)}: number of neighbors of each cell", alignment="left",
    )  # fmt: skip
    return figure


def size_figure(
    manifest: Manifest, patterns: Mapping[float, Pattern], curves: Sequence[ReferenceCurve] = ()
) -> Figure:
    """Draw crack spacing and mean cell diameter against depth, with standard errors.

    Parameters
    ----------
    manifest : description of the run.
    patterns : statistics of the cells by depth (m).
    curves : theoretical curves, one line each.
    """
    figure = new_figure(3.8)
    axes, unit = figure.subplots(), manifest.shown.length
    for curve, line in zip(curves, ("--", ":", "-."), strict=False):
        axes.plot(
            unit.of(curve.depths),
            unit.of(curve.lengths),
            label=curve.name,
            **THEORY,
            linestyle=line,
        )
    diameters = {depth: found.diameter for depth, found in patterns.items()}
    spacings = {depth: found.spacing for depth, found in patterns.items()}
    name = "mean diameter of the cells inside, and their number"
    _draw_estimates(axes, unit, diameters, "o", BLUE, name)
    _draw_estimates(axes, unit, spacings, "s", ORANGE, "spacing: area over length of the cracks")
    for depth, found in patterns.items():
        if found.diameter.value is not None:
            axes.annotate(
                f"{found.interior}", (unit.of(depth), unit.of(found.diameter.value)), xytext=(5, 5),
                textcoords="offset points", fontsize=7, color=BLUE,
            )  # fmt: skip
    deepest = max(patterns)
    axes.set_xlim(left=0, right=1.08 * unit.of(deepest))
    drawn = [e.value + (e.error or 0) for e in (*diameters.values(), *spacings.values()) if e.value]
    among = [curve.lengths[curve.depths <= deepest] for curve in curves]
    largest = float(np.nanmax(np.concatenate([[0.0], drawn, *among])))
    axes.set_ylim(0, 1.08 * unit.of(largest) or 1.0)
    axes.set_xlabel(unit.label(f"depth below the {manifest.surface}"))
    axes.set_ylabel(unit.label("length"))
    legend_above(axes, 2)
    return figure


def _draw_plane(axes: Axes, manifest: Manifest, plane: ColumnPlane) -> None:
    length = manifest.shown.length
    left, right, low, high = (length.of(end) for ends in plane.extent for end in ends)
    axes.imshow(
        painted(plane).swapaxes(0, 1), origin="lower", extent=(left, right, low, high),
        interpolation="bilinear",
    )  # fmt: skip
    axes.grid(False)
    axes.locator_params(nbins=5)
    for side in axes.spines.values():
        side.set_visible(True)
    inside = int((plane.cells.ends == 0).sum())
    depth = f"depth {length.text(plane.depth, 3)}"
    count = "1 cell" if plane.cells.number == 1 else f"{plane.cells.number} cells"
    axes.set_title(f"{depth}: {count}, {inside} inside", loc="left", pad=3, fontsize=8)


def painted(plane: ColumnPlane) -> np.ndarray:
    """Return the colors of a plane's pixels, shape (n_x, n_y, 3): cells by neighbors, cracks dark.

    Damage below the threshold does not change the legend's colors, also in the damaged layer.
    """
    fewest, most = min(NEIGHBORS), max(NEIGHBORS)
    of_cells = [
        to_rgb(AT_THE_END if ends else NEIGHBORS[min(max(int(sides), fewest), most)])
        for sides, ends in zip(plane.cells.sides, plane.cells.ends, strict=True)
    ]
    colors = np.array([CRACK, *of_cells])[plane.cells.tiles]
    there = np.isfinite(plane.damage)[..., None]
    over = (np.nan_to_num(plane.damage)[..., None] - plane.threshold) / (1 - plane.threshold)
    dark = np.sqrt(np.clip(over, 0, 1))
    return np.where(there, (1 - dark) * colors + dark * np.array(CRACK), to_rgb(OUTSIDE))


def _classes() -> list[Patch]:
    names = {n: str(n) for n in NEIGHBORS}
    names[min(NEIGHBORS)] += " or fewer"
    names[max(NEIGHBORS)] += " or more"
    found = [Patch(facecolor=color, label=names[n]) for n, color in NEIGHBORS.items()]
    return [*found, Patch(facecolor=AT_THE_END, label="cut by an end of the body")]


def _draw_estimates(
    axes: Axes, unit: Unit, found: Mapping[float, Estimate], marker: str, color: str, label: str
) -> None:
    """Draw points joined by a line, each with its error if it has one."""
    known = [(depth, e.value, e.error or 0.0) for depth, e in found.items() if e.value is not None]
    if known:
        depth, value, error = unit.of(np.array(known)).T
        axes.errorbar(
            depth, value, error, color=color, marker=marker, markersize=5, capsize=3,
            linewidth=1.2, label=label,
        )  # fmt: skip
