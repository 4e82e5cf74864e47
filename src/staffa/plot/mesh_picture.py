"""Picture of a mesh that follows the cracks: cells over the damage, and their number in time."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from staffa.geometry.block import face_axis
from staffa.io.vtkhdf import VtkMesh
from staffa.plot.cracks import DAMAGE
from staffa.plot.frames import Frame
from staffa.plot.labels import moment, show_clock, time_axis_values
from staffa.plot.style import BLUE, WIDTH, new_figure
from staffa.records.manifest import Manifest
from staffa.records.step import Step

EDGES = "#5b7a99"
POINTS = 72.0  # of an inch
SHARE, THICKEST, THINNEST = 0.08, 0.4, 0.04  # width of a line over the edge of a cell; in points
CURVE = 1.9  # inches: height of the panel of their number
TALLEST = 1.3  # height of the cells' panel over the width of the picture, at most
BESIDE_THE_MIDDLE = 0.48  # where a section is, so that it runs along no faces of cells


def mesh_figure(manifest: Manifest, frame: Frame, steps: Sequence[Step]) -> Figure:
    """Draw the cells of one step, of a 3-D body in a section, and below them their number.

    Parameters
    ----------
    manifest : description of the run.
    frame : fields of the step.
    steps : steps of the run, whose numbers of cells are drawn.
    """
    axes_of, counted = plane(manifest), [step for step in steps if step.mesh]
    width, height = (manifest.size[axis] for axis in axes_of)
    tall = min((WIDTH - 0.7) * height / width, TALLEST * WIDTH) + 0.6
    rows = 1 + (len(counted) > 1)
    figure = new_figure(tall + CURVE * (rows - 1), gap=0.05)
    panels = figure.subplots(rows, 1, squeeze=False, height_ratios=[tall, CURVE][:rows])[:, 0]
    _draw_cells(panels[0], manifest, frame, axes_of)
    if rows > 1:
        _draw_numbers(panels[1], manifest, counted)
    return figure


def plane(manifest: Manifest) -> tuple[int, int]:
    """Return the axes, across and up, of the plane that is drawn: with the depth, if there is."""
    if manifest.flat:
        return 0, 1
    depth = face_axis(manifest.cooled_side, 3) if manifest.cooled_side else 2
    return (0, depth) if depth else (1, 0)


def section(grid: VtkMesh, alpha: np.ndarray, axis: int, at: float) -> tuple[list[np.ndarray], ...]:
    """Return the polygons that a plane cuts out of the cells, and the damage in each.

    Parameters
    ----------
    grid : the mesh.
    alpha : damage at its points, shape (n,).
    axis : the axis across the plane.
    at : position of the plane along it (m).

    Returns
    -------
    tuple of list of ndarray
        The corners (m) of each, shape (m, 3), and the damage at them, shape (m,).
    """
    import pyvista  # takes a second to load

    body = pyvista.UnstructuredGrid({grid.type: grid.cells}, grid.points)
    body["alpha"] = alpha
    origin = np.zeros(3)
    origin[axis] = at
    cut = body.slice(normal=np.eye(3)[axis], origin=origin, generate_triangles=False)
    faces = cut.irregular_faces
    points, values = np.asarray(cut.points), np.asarray(cut["alpha"])
    return [points[face] for face in faces], [values[face] for face in faces]


def _draw_cells(axes: Axes, manifest: Manifest, frame: Frame, axes_of: tuple[int, int]) -> None:
    """Draw cells with thin edges, each in the color of its mean damage."""
    of, grid, place = manifest.shown.length.of, frame.grid, ""
    if manifest.flat:
        corners, damage = list(grid.points[grid.cells]), list(frame.alpha[grid.cells])
    else:
        across = ({0, 1, 2} - set(axes_of)).pop()
        at = manifest.corner[across] + BESIDE_THE_MIDDLE * manifest.size[across]
        corners, damage = section(grid, frame.alpha, across, at)
        place = f", section at {'xyz'[across]} = {manifest.shown.length.text(at, 2)}"
    ends = [(of(manifest.corner[a]), of(manifest.corner[a] + manifest.size[a])) for a in axes_of]
    inches = (WIDTH - 0.7) / manifest.size[axes_of[0]]
    line = np.clip(SHARE * POINTS * inches * manifest.h, THINNEST, THICKEST)
    axes.add_collection(
        PolyCollection(
            [of(polygon[:, list(axes_of)]) for polygon in corners],
            facecolors=DAMAGE([values.mean() for values in damage]),
            edgecolors=EDGES,
            linewidths=float(line),
        )
    )
    names = ("r", "z") if manifest.axial else tuple("xyz"[a] for a in axes_of)
    label = manifest.shown.length.label
    axes.set(xlim=ends[0], ylim=ends[1], xlabel=label(names[0]), ylabel=label(names[1]))
    axes.set_aspect("equal")
    axes.grid(False)
    for side in axes.spines.values():
        side.set_visible(True)
    number = f"{len(grid.cells):,} cells"
    axes.set_title(f"{moment(manifest, frame.step)}: {number}{place}", loc="left")


def _draw_numbers(axes: Axes, manifest: Manifest, steps: Sequence[Step]) -> None:
    """Draw the number of cells against time."""
    at = time_axis_values(manifest, steps)
    cells = [step.mesh.cells for step in steps if step.mesh]
    marker = "o" if len(steps) < 40 else ""
    axes.plot(at, cells, color=BLUE, marker=marker, markersize=3)
    axes.set_ylim(0, 1.08 * max(cells))
    axes.set_ylabel("cells")
    axes.yaxis.set_major_formatter(lambda value, _: f"{value:,.0f}")
    show_clock(axes, manifest, steps)
