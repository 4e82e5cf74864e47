"""Temperature of a reservoir's cells with the cracks of the rock over it, and their openings."""

from collections.abc import Sequence
from functools import partial
from math import ceil, prod
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import ListedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.patheffects import withStroke
from scipy.spatial import KDTree

from staffa.io.reservoir_fields import ReservoirFields, read_reservoir
from staffa.io.run_directory import Run, reservoir_name
from staffa.plot.cell_openings import (
    COLORS,
    PALE,
    CellOpenings,
    cell_openings,
    crack_openings,
    openings_bar,
)
from staffa.plot.cracks import layout, rim, triangulation
from staffa.plot.frames import Frame
from staffa.plot.labels import moment
from staffa.plot.style import BLACK, new_figure
from staffa.records.manifest import Manifest
from staffa.records.reservoir_facts import ReservoirFacts

FEW = 4  # panels
NEAR_END = 0.8  # of the axis, from which names of wells stand on their left
AROUND = 0.25  # of the longest side of the body, of the reservoir beyond it
BELOW = 0.5  # inches for the bar of colors
CRACK = "#14100c"
RIM: dict[str, Any] = {"edgecolor": "#555555", "linewidth": 0.6}
RASTER = 400  # points along the longer side of a section of a 3-D body
Moments = Sequence[tuple[Frame, ReservoirFields]]


def reservoir_moments(
    run: Run, frames: Sequence[Frame]
) -> tuple[list[tuple[Frame, ReservoirFields]], list[str]]:
    """Return the last frames with the reservoir's fields then, and a message on unreadable files.

    Parameters
    ----------
    run : the run.
    frames : fields of the rock at some steps.
    """
    found, reasons, facts = [], [], run.manifest.reservoir
    for frame in frames if facts else ():
        name = reservoir_name(str(frame.step.fields))
        try:
            read = read_reservoir(run.path, str(frame.step.fields))
            if facts and len(read.T) != prod(len(edges) - 1 for edges in facts.edges):
                raise ValueError("its cells are not those of manifest.json")
            found.append((frame, read))
        except (OSError, KeyError, ValueError, IndexError) as error:
            there = (run.path / name).exists()
            why = f"it cannot be read: {error}" if there else "it is not there"
            reasons.append(f"{name} is left out: {why}")
    return found[-FEW:], reasons


def reservoir_figure(manifest: Manifest, facts: ReservoirFacts, moments: Moments) -> Figure:
    """Draw the temperature of the cells at each time, cracks over it, and the wells.

    Cracks are black; where they change the flow, they have the color of their opening. Of a 3-D
    reservoir a section through the wells is drawn.

    Parameters
    ----------
    manifest : description of the run.
    facts : its reservoir.
    moments : fields of rock and reservoir at each time.
    """
    edges = [np.array(e) for e in facts.edges]
    normal = section_axis(facts) if len(manifest.size) == 3 else 2
    across = [axis for axis in range(3) if axis != normal]
    x, y = (manifest.shown.length.of(edges[axis]) for axis in across)
    view = [_view(ends, manifest, axis) for ends, axis in zip((x, y), across, strict=True)]
    size = (view[0][1] - view[0][0], view[1][1] - view[1][0])
    columns, height = layout(size, len(moments))
    openings = crack_openings(facts, [found for _, found in moments])
    warm, below = (COLORS, BELOW) if openings is None else (PALE, 2 * BELOW)
    figure = new_figure(max(height, 2.2) + below, gap=0.08)
    panels = figure.subplots(
        ceil(len(moments) / columns), columns, squeeze=False, sharex=True, sharey=True
    )
    unit = manifest.shown.temperature
    values = [unit.of(found.T) for _, found in moments]
    low, high = min(v.min() for v in values), max(v.max() for v in values)
    colors = Normalize(low, high if high > low else low + 1)
    section = partial(_section, edges=edges, normal=normal, facts=facts)
    for number, axes in enumerate(panels.flat):
        if number >= len(moments):
            axes.set_axis_off()
            continue
        frame, found = moments[number]
        T = section(values[number]).T
        axes.pcolormesh(x, y, T, cmap=warm, norm=colors, rasterized=True)
        colored = cell_openings((x, y), section, found.w, openings)
        _draw_cracks(axes, manifest, frame, normal, facts, colored)
        _draw_wells(axes, manifest, facts, across)
        axes.set(aspect="equal", title="", xlim=view[0], ylim=view[1])
        axes.grid(False)
        axes.set_title(moment(manifest, frame.step), loc="left")
    names = [manifest.shown.length.label("xyz"[axis]) for axis in across]
    for axes in panels[-1]:
        axes.set_xlabel(names[0])
    for axes in panels[:, 0]:
        axes.set_ylabel(names[1])
    bar: dict[str, Any] = {"location": "bottom", "shrink": 0.5, "aspect": 40}
    figure.colorbar(ScalarMappable(colors, warm), ax=panels, label=unit.label("T"), **bar)
    if openings is not None:
        openings_bar(figure, panels, openings, bar)
    return figure


def _view(ends: np.ndarray, manifest: Manifest, axis: int) -> tuple[float, float]:
    """Return the part of an axis that is drawn: that of the body, and a margin of the reservoir.

    Parameters
    ----------
    ends : faces of the reservoir's cells, in the displayed unit.
    manifest : description of the run.
    axis : the axis.
    """
    of = manifest.shown.length.of
    margin = AROUND * max(map(of, manifest.size))
    lower, upper = (of(manifest.corner[axis] + s) for s in (0.0, manifest.size[axis]))
    return max(float(ends[0]), lower - margin), min(float(ends[-1]), upper + margin)


def section_axis(facts: ReservoirFacts) -> int:
    """Return the normal of the section through the wells: the axis along which they differ least.

    That is y where several do.
    """
    places = np.array([well.at for well in facts.wells.values()])
    apart = np.ptp(places, axis=0) if len(places) else np.zeros(3)
    return min((1, 0, 2), key=lambda axis: float(apart[axis]))


def _place(facts: ReservoirFacts, normal: int) -> float:
    """Return the position of the section along its normal (m): that of the wells."""
    edges = facts.edges[normal]
    if not facts.wells:
        return (edges[0] + edges[-1]) / 2
    return float(np.mean([well.at[normal] for well in facts.wells.values()]))


def _section(
    values: np.ndarray, edges: Sequence[np.ndarray], normal: int, facts: ReservoirFacts
) -> np.ndarray:
    """Return the values in the cells of the section, shape (n, m)."""
    cells = values.reshape([len(e) - 1 for e in edges], order="F")
    layer = int(np.searchsorted(edges[normal][1:-1], _place(facts, normal)))
    return np.asarray(cells.take(layer, axis=normal))


def _draw_cracks(
    axes: Axes,
    manifest: Manifest,
    frame: Frame,
    normal: int,
    facts: ReservoirFacts,
    colored: CellOpenings | None,
) -> None:
    """Draw damage above the threshold, and the rim of the body, in 3-D of its box.

    Parameters
    ----------
    axes : the panel.
    manifest : description of the run.
    frame : fields of the rock.
    normal : normal of the section.
    facts : the reservoir.
    colored : openings that give cracks their color; None for black.
    """
    if len(manifest.size) == 3:
        x, y, broken = _broken_in(frame, manifest, normal, _place(facts, normal))
        if colored is None:
            only, shown = ListedColormap([CRACK]), np.ma.masked_where(~broken, broken)
            axes.pcolormesh(x, y, shown.T, cmap=only, shading="nearest")
        else:
            colored.draw_points(axes, x, y, broken)
        around = Rectangle((x[0], y[0]), float(np.ptp(x)), float(np.ptp(y)), fill=False, **RIM)
        axes.add_patch(around)
        return
    triangles = triangulation(frame.grid, manifest)
    axes.add_collection(LineCollection(list(rim(triangles)), **RIM))
    if colored is not None:
        colored.draw_triangles(axes, triangles, frame.alpha > manifest.threshold)
    elif frame.alpha.max() > manifest.threshold:
        inside = [manifest.threshold, np.inf]
        axes.tricontourf(triangles, frame.alpha, levels=inside, colors=CRACK)


def _broken_in(
    frame: Frame, manifest: Manifest, normal: int, place: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return coordinates of points of a plane, and where the nearest vertex is cracked, (n, m)."""
    across = [axis for axis in range(3) if axis != normal]
    size = np.array(manifest.size)[across]
    counts = np.maximum(2, np.ceil(RASTER * size / size.max())).astype(int)
    lines = [
        np.linspace(manifest.corner[axis], manifest.corner[axis] + manifest.size[axis], count)
        for axis, count in zip(across, counts, strict=True)
    ]
    points = np.full((*counts, 3), place)
    points[..., across[0]], points[..., across[1]] = np.meshgrid(*lines, indexing="ij")
    apart, nearest = KDTree(frame.grid.points).query(points)
    broken = (frame.alpha[nearest] > manifest.threshold) & (apart < manifest.h)
    x, y = (manifest.shown.length.of(line) for line in lines)
    return x, y, broken


def _draw_wells(
    axes: Axes, manifest: Manifest, facts: ReservoirFacts, across: Sequence[int]
) -> None:
    """Draw a ring with its name for each well."""
    of = manifest.shown.length.of
    for name, well in facts.wells.items():
        x, y = (of(well.at[axis]) for axis in across)
        axes.plot([x], [y], "o", color=BLACK, markerfacecolor="white", markersize=5, clip_on=False)
        ends = _view(of(np.array(facts.edges[across[0]])), manifest, across[0])
        last = x > ends[0] + NEAR_END * (ends[1] - ends[0])
        axes.annotate(
            name, (x, y), xytext=(-4 if last else 4, 4), ha="right" if last else "left",
            textcoords="offset points", fontsize=7.5,
            annotation_clip=False, path_effects=[withStroke(linewidth=2, foreground="white")],
        )  # fmt: skip
