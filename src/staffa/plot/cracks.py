"""Cracks of a 2-D body at selected times, with isotherms: the paper's Figure 1."""

from collections.abc import Sequence
from math import ceil

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.transforms import offset_copy
from matplotlib.tri import Triangulation

from staffa.geometry.block import SIDES, face_position
from staffa.io.vtkhdf import VtkMesh
from staffa.plot.frames import Frame
from staffa.plot.labels import moment, tau_label
from staffa.plot.style import WIDTH, new_figure
from staffa.records.manifest import Manifest

# Pale up to half, so that the dark part is the crack and not the width of its damage profile.
DAMAGE = LinearSegmentedColormap.from_list(
    "damage", [(0, "#ffffff"), (0.4, "#e6e2db"), (0.7, "#a79e93"), (0.9, "#3b342d"), (1, "#14100c")]
)
COLD, OTHER = "#1f5fbf", "#8a8a8a"  # of a face that is cooled, and of one that is not
# T/dT of the isotherms, and their colors from cold to warm, and those of a body that is heated.
COLDER = {-0.8: "#1149a8", -0.6: "#2a74d6", -0.4: "#4f9be8", -0.2: "#86bdf2"}
WARMER = {0.2: "#f4b183", 0.4: "#e8844f", 0.6: "#d6542a", 0.8: "#a82911"}
NEAR = 1e-6  # of the body: so far from a plane points of its mesh may lie, by round-off
FACE = 3.0  # points: width of the line that marks the cooled face
TALLEST = 1.4  # height of the picture over its width, before panels go side by side
ACROSS, BESIDE = 110, 6  # letters that fit across a legend, and that a line beside one takes
BAR = 0.9  # inches for the legend and the labels below


def cracks_figure(manifest: Manifest, frames: Sequence[Frame]) -> Figure:
    """Draw one panel a time: damage white to dark, isotherms, the cooled face marked."""
    columns, height = layout(manifest.size, len(frames))
    figure = new_figure(height, gap=0.05)
    rows = ceil(len(frames) / columns)
    grid = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
    dT = temperature_drop(manifest, frames)
    triangles = triangulation(frames[0].grid, manifest)
    for number, axes in enumerate(grid.flat):
        if number >= len(frames):
            axes.set_axis_off()
            continue
        if len(frames[number].alpha) != len(triangles.x):
            triangles = triangulation(frames[number].grid, manifest)
        draw_panel(axes, manifest, frames[number], triangles, dT)
        if number + columns >= len(frames):
            axes.set_xlabel(manifest.shown.length.label("r" if manifest.axial else "x"))
            axes.tick_params(labelbottom=True)
        if number % columns == 0:
            axes.set_ylabel(manifest.shown.length.label("z" if manifest.axial else "y"))
    add_legend(figure, manifest, frames, dT)
    return figure


def layout(size: Sequence[float], panels: int) -> tuple[int, float]:
    """Return the columns of panels and the height (inches): one column, unless that is too tall."""
    for columns in range(1, panels + 1):
        one = (WIDTH - 0.7) / columns * size[1] / size[0] + 0.36
        height = ceil(panels / columns) * one + BAR
        if height <= TALLEST * WIDTH:
            break
    return columns, min(height, 2 * WIDTH)


def extent(manifest: Manifest) -> list[tuple[float, float]]:
    """Return the ends of the body along each axis, in the displayed unit of length."""
    ends = zip(manifest.corner, manifest.size, strict=True)
    of = manifest.shown.length.of
    return [(of(a), of(a + s)) for a, s in ends]


def draw_panel(
    axes: Axes, manifest: Manifest, frame: Frame, triangles: Triangulation, dT: float
) -> None:
    """Draw damage, isotherms and cooled face at one time.

    Parameters
    ----------
    axes : where it is drawn.
    manifest : description of the run.
    frame : the fields.
    triangles : the mesh as triangles.
    dT : temperature drop by which temperatures are divided (K); 0 for none.
    """
    axes.grid(False)
    axes.set_aspect("equal")
    axes.tripcolor(triangles, frame.alpha, cmap=DAMAGE, vmin=0, vmax=1, shading="gouraud")
    axes.add_collection(LineCollection(list(rim(triangles)), colors="#555555", linewidths=0.6))
    theta = frame.T / dT if dT else frame.T
    known = COLDER | WARMER
    levels = [level for level in known if theta.min() < level < theta.max()]
    if levels:
        colors = [known[level] for level in levels]
        axes.tricontour(
            triangles, theta, levels=levels, colors=colors, linewidths=0.7, linestyles="solid"
        )
    x, y = extent(manifest)
    axes.set(xlim=x, ylim=y)
    axes.locator_params(axis="x", nbins=5)
    for side in axes.spines.values():
        side.set_visible(True)
    for face, color in _marked(manifest).items():
        _mark_face(axes, manifest, triangles, face, color)
    entitle(axes, moment(manifest, frame.step), manifest)


def entitle(axes: Axes, title: str, manifest: Manifest) -> None:
    """Put a title on a panel, above the line of the cooled face if that is the top.

    Parameters
    ----------
    axes : the panel.
    title : its title.
    manifest : description of the run.
    """
    raised = FACE + 1 if "top" in _marked(manifest) else 0.0
    axes.set_title(title, loc="left", pad=3 + raised)


def _marked(manifest: Manifest) -> dict[str, str]:
    """Return the sides of the box that are marked, and their colors; none where a script loads."""
    if manifest.own_load or not manifest.cooled_side:
        return {}
    face = {manifest.cooled_side: COLD if manifest.cools else OTHER}
    return dict.fromkeys(manifest.cooled, COLD) | face


def _mark_face(
    axes: Axes, manifest: Manifest, triangles: Triangulation, side: str, color: str
) -> None:
    """Draw a line along the part of the body that lies on a side of its box, just outside of it.

    Parameters
    ----------
    axes : the panel.
    manifest : description of the run.
    triangles : the mesh as triangles.
    side : the side.
    color : color of the line.
    """
    axis, end = SIDES[2][side]
    of, lower, size = manifest.shown.length.of, manifest.corner, manifest.size
    at, near = of(lower[axis] + face_position(side, size)), NEAR * of(max(size))
    edges = rim(triangles)
    there = edges[(np.abs(edges[:, :, axis] - at) <= near).all(axis=1), :, 1 - axis]
    there = np.sort(there, axis=1)[np.argsort(there.min(axis=1))]
    gaps = np.flatnonzero(there[1:, 0] > there[:-1, 1] + near) + 1
    outwards = end * (FACE + 1) / 2
    shift = {"x": outwards} if axis == 0 else {"y": outwards}
    outside = offset_copy(axes.transData, axes.get_figure(root=True), units="points", **shift)
    for part in np.split(there, gaps) if len(there) else ():
        ends = [part[0, 0], part[-1, 1]]
        axes.plot(
            *(([at, at], ends) if axis == 0 else (ends, [at, at])),
            color=color,
            linewidth=FACE,
            clip_on=False,
            solid_capstyle="butt",
            transform=outside,
        )


def _faces_of_legend(manifest: Manifest) -> dict[str, str]:
    """Return the names of the marked faces with their colors: all cooled ones are one."""
    marked = _marked(manifest)
    cooled = sum(color == COLD for color in marked.values())
    found = {"cooled faces" if cooled > 1 else "cooled face": COLD} if cooled else {}
    return found if manifest.cools or not marked else {manifest.surface: OTHER} | found


def temperature_drop(manifest: Manifest, frames: Sequence[Frame]) -> float:
    """Return the drop by which temperatures are divided (K): the case's, or the largest found."""
    known = manifest.scales.get("dT")
    return known if known else max(float(np.abs(frame.T).max()) for frame in frames)


def rim(triangles: Triangulation) -> np.ndarray:
    """Return the edges around the body and its holes, shape (n, 2, 2)."""
    cell, side = np.nonzero(triangles.neighbors < 0)
    ends = triangles.triangles[cell[:, None], np.column_stack([side, (side + 1) % 3])]
    return np.stack([triangles.x[ends], triangles.y[ends]], axis=-1)


def triangulation(grid: VtkMesh, manifest: Manifest) -> Triangulation:
    """Return the mesh as triangles, in the displayed unit of length.

    Quadrilaterals are divided in two along alternating diagonals.
    """
    cells = grid.cells
    if cells.shape[1] == 4:
        a, b, c, d = cells.T
        even = (np.arange(len(cells)) % 2 == 0)[:, None]
        one = np.where(even, np.column_stack([a, b, c]), np.column_stack([a, b, d]))
        two = np.where(even, np.column_stack([a, c, d]), np.column_stack([b, c, d]))
        cells = np.concatenate([one, two])
    points = manifest.shown.length.of(grid.points)
    return Triangulation(points[:, 0], points[:, 1], cells)


def add_legend(figure: Figure, manifest: Manifest, frames: Sequence[Frame], dT: float) -> None:
    """Add the meaning of the colors above, and the definition of tau below.

    Parameters
    ----------
    figure : the figure.
    manifest : description of the run.
    frames : the fields that are drawn.
    dT : temperature drop by which temperatures are divided (K); 0 for none.
    """
    handles = [Line2D([], [], color="#1a1512", linewidth=5, label="crack (damage 1)")]
    handles += [
        Line2D([], [], color=color, linewidth=FACE, label=name)
        for name, color in _faces_of_legend(manifest).items()
    ]
    handles += [
        Line2D([], [], color=color, linewidth=1.4, label=isotherm(manifest, level, dT))
        for level, color in isotherms(frames, dT).items()
    ]
    letters = sum(len(str(handle.get_label())) + BESIDE for handle in handles)
    figure.legend(
        handles=handles, loc="outside upper left", handlelength=1.3,
        ncols=ceil(len(handles) / ceil(letters / ACROSS)),
        columnspacing=1.3, borderaxespad=0.1,
    )  # fmt: skip
    if frames[0].step.tau is not None:
        figure.supxlabel(tau_label(manifest), fontsize=8, parse_math=True)


def isotherms(frames: Sequence[Frame], dT: float) -> dict[float, str]:
    """Return the levels of T/dT within the temperatures of these frames, with their colors."""
    if not dT:
        return {}
    low = min(float(frame.T.min()) for frame in frames) / dT
    high = max(float(frame.T.max()) for frame in frames) / dT
    return {level: color for level, color in (COLDER | WARMER).items() if low < level < high}


def isotherm(manifest: Manifest, level: float, dT: float) -> str:
    """Return the label of an isotherm: a temperature if the case has one, else a change.

    Parameters
    ----------
    manifest : description of the run.
    level : level of T/dT.
    dT : temperature drop (K).
    """
    if manifest.scaled:
        text = f"T = {level:g} ΔT"
    elif manifest.reference is not None:
        text = f"T = {manifest.shown.temperature.text(manifest.reference + level * dT, 3)}"
    else:
        text = f"T = T₀ {level * dT:+.3g} {manifest.shown.difference.name}"
    return text.replace("-", "−")
