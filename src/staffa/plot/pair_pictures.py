"""Two runs in one picture: their curves on one time axis, their cracks and the difference."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator

from staffa.plot.cracks import (
    add_legend,
    draw_panel,
    entitle,
    extent,
    temperature_drop,
    triangulation,
)
from staffa.plot.frames import Frame
from staffa.plot.labels import moment
from staffa.plot.rendering import CRACKS
from staffa.plot.style import BLACK, BLUE, ORANGE, WIDTH, count_axis, legend_above, new_figure
from staffa.plot.volume import add_depths, deepest, rendered
from staffa.records.manifest import Manifest

COLORS = (BLUE, ORANGE)
WIDTHS = (3.0, 1.2)  # so that equal curves show one in the other
DIFFERENCE = "RdBu_r"
FAINT = 1e-3  # smallest end of the difference's color scale, so that round-off stays pale
FEW = 3  # times shown of bodies that are long or 3-D
PIXELS = 700  # edge of a view of a 3-D body
LONG = 4.0  # width over height from which the panels are in one column
LONGEST = 18  # characters of a name above a panel
Curve = tuple[Sequence[float], Sequence[float]]


@dataclass(frozen=True, kw_only=True)
class Panel:
    """Curves of one quantity.

    Attributes
    ----------
    label : label of the axis.
    curves : times and values of each run, or of both together.
    counts : True for whole numbers, each of which lasts until the next step.
    """

    label: str
    curves: tuple[Curve, ...]
    counts: bool = False


def curves_figure(
    names: Sequence[str],
    panels: Sequence[Panel],
    named: Callable[[Axes], None],
) -> Figure:
    """Draw one panel a quantity, a color for each run; a curve of both is black.

    Parameters
    ----------
    names : names of the two runs.
    panels : the curves.
    named : labels the time axis of the last panel.
    """
    figure = new_figure(0.9 + 1.7 * len(panels))
    rows = figure.subplots(len(panels), 1, squeeze=False, sharex=True)[:, 0]
    for axes, panel in zip(rows, panels, strict=True):
        _draw_curves(axes, panel)
    named(rows[-1])
    handles = [
        Line2D([], [], color=color, linewidth=width, label=name)
        for name, color, width in zip(names, COLORS, WIDTHS, strict=True)
    ]
    legend_above(rows[0], 2, handles)
    return figure


def _draw_curves(axes: Axes, panel: Panel) -> None:
    alone = len(panel.curves) == 1
    for curve, color, width in zip(panel.curves, COLORS, WIDTHS, strict=False):
        axes.plot(
            *curve, color=BLACK if alone else color, linewidth=WIDTHS[-1] if alone else width,
            drawstyle="steps-post" if panel.counts else "default",
            marker="o" if len(curve[0]) == 1 else "",
        )  # fmt: skip
    axes.set_ylabel(panel.label)
    if all(value >= 0 for _, values in panel.curves for value in values):
        axes.set_ylim(bottom=0)
    if panel.counts:
        count_axis(axes, ticks=4)
    else:
        axes.yaxis.set_major_locator(MaxNLocator(4))


def fields_figure(
    names: Sequence[str],
    manifests: Sequence[Manifest],
    frames: Sequence[tuple[Frame, Frame]],
    ratio: float = 1.0,
) -> Figure:
    """Draw the damage of both 2-D bodies at each time, and the difference if the points agree.

    Parameters
    ----------
    names : names of the two runs.
    manifests : descriptions of the two runs.
    frames : fields of both runs at each time.
    ratio : unit of length of the first over that of the second.
    """
    apart = [damage_difference(*both, ratio) for both in frames]
    across = 3 if any(d is not None for d in apart) else 2
    largest = max([FAINT, *(float(abs(d).max()) for d in apart if d is not None)])
    width, height = manifests[0].size
    columns = 1 if width > LONG * height else across
    panel = (WIDTH - 0.7) / columns * height / width + 0.36
    rows = across * len(frames) // columns
    figure = new_figure(rows * panel + 1.4, gap=0.05)
    grid = figure.subplots(rows, columns, squeeze=False).reshape(len(frames), across)
    for line, both, gap in zip(grid, frames, apart, strict=True):
        for axes, name, manifest, frame in zip(line, names, manifests, both, strict=False):
            dT = temperature_drop(manifest, [frame])
            draw_panel(axes, manifest, frame, triangulation(frame.grid, manifest), dT)
            entitle(axes, f"{_short(name)}, {moment(manifest, frame.step)}", manifest)
        if across == 3:
            _draw_difference(line[2], manifests[0], both[0], gap, largest)
    for axes in grid[:, 0]:
        axes.set_ylabel(manifests[0].shown.length.label("z" if manifests[0].axial else "y"))
    for axes, manifest in zip(grid[-1], (*manifests, manifests[0]), strict=False):
        axes.set_xlabel(manifest.shown.length.label("r" if manifest.axial else "x"))
    first = [both[0] for both in frames]
    add_legend(figure, manifests[0], first, temperature_drop(manifests[0], first))
    if across == 3:
        figure.colorbar(
            ScalarMappable(Normalize(-largest, largest), DIFFERENCE), ax=grid, location="bottom",
            shrink=0.5, aspect=40,
            label=f"damage of {_short(names[1])} minus that of {_short(names[0])}",
        )  # fmt: skip
    return figure


def damage_difference(one: Frame, other: Frame, ratio: float = 1.0) -> np.ndarray | None:
    """Return the damage of the second less that of the first at the first's points, shape (n,).

    None if the two meshes have different points. The order of the points may differ, since it
    depends on the number of ranks.

    Parameters
    ----------
    one : fields of the first run.
    other : fields of the second run.
    ratio : unit of length of the first over that of the second.
    """
    a, b = one.grid.points, ratio * other.grid.points
    if a.shape != b.shape:
        return None
    near = 1e-6 * float(np.ptp(a, axis=0).max())  # far below any edge, far above rounding
    order, there = (np.lexsort(np.round(points / near).T) for points in (a, b))
    if not np.allclose(a[order], b[there], rtol=0.0, atol=2 * near):
        return None
    found = np.empty_like(one.alpha)
    found[order] = other.alpha[there] - one.alpha[order]
    return found


def _draw_difference(
    axes: Axes, manifest: Manifest, frame: Frame, gap: np.ndarray | None, largest: float
) -> None:
    """Draw a difference of damage; `largest` is the end of the color scale."""
    if gap is None:
        axes.set_axis_off()
        return
    axes.grid(False)
    axes.set_aspect("equal")
    triangles = triangulation(frame.grid, manifest)
    axes.tripcolor(triangles, gap, cmap=DIFFERENCE, vmin=-largest, vmax=largest, shading="gouraud")
    x, y = extent(manifest)
    axes.set(xlim=x, ylim=y)
    axes.locator_params(axis="x", nbins=5)
    for side in axes.spines.values():
        side.set_visible(True)
    axes.set_title(f"difference, at most {abs(gap).max():.2g}", loc="left", pad=3)


def volumes_figure(
    names: Sequence[str],
    manifests: Sequence[Manifest],
    frames: Sequence[tuple[Frame, Frame]],
) -> Figure:
    """Draw the last three times of both 3-D bodies in perspective, cracks colored by depth.

    Parameters
    ----------
    names : names of the two runs.
    manifests : descriptions of the two runs.
    frames : fields of both runs at each time.

    Raises
    ------
    StaffaError
        Rendering is not possible here.
    """
    shown = frames[-FEW:]
    runs = [
        (name, m, [both[k] for both in shown])
        for k, (name, m) in enumerate(zip(names, manifests, strict=True))
    ]
    bottom = max(deepest(m, [f.step for f in mine]) / m.L for _, m, mine in runs)
    figure = new_figure(2 * WIDTH / FEW + 1.4)
    panels = figure.subplots(2, len(shown), squeeze=False)
    for row, (name, manifest, mine) in zip(panels, runs, strict=True):
        files = [frame.path for frame in mine]
        (views,) = rendered(manifest, files, bottom * manifest.L, (CRACKS,), pixels=PIXELS)
        for axes, view, frame in zip(row, views, mine, strict=True):
            axes.imshow(view.image)
            axes.set_axis_off()
            axes.set_title(f"{_short(name)}, {moment(manifest, frame.step)}", loc="left")
    add_depths(figure, panels, bottom, "depth over L")
    return figure


def _short(name: str) -> str:
    return name if len(name) <= LONGEST else f"…{name[1 - LONGEST :]}"
