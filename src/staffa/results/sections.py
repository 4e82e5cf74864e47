"""Depth planes of a 3-D body that are drawn, and the theoretical curves beside them."""

from collections.abc import Sequence

import numpy as np

from staffa.geometry.block import SIDES, face_position, section_raster
from staffa.io.vtkhdf import VtkMesh
from staffa.measure.cells import cells
from staffa.physics.doubling import spacing_at
from staffa.plot.cell_planes import ColumnPlane, ReferenceCurve
from staffa.plot.frames import Frame
from staffa.records.manifest import Manifest
from staffa.records.step import Step

MOST = 6  # planes in one picture
POINTS = 100  # of a curve


def depths_of(manifest: Manifest, step: Step) -> list[float]:
    """Return at most six depths (m) of planes to draw.

    They are those of the case; without, even ones down to the deepest crack. There are none without
    a cooled face or a crack.
    """
    measures = step.measures
    if not manifest.cooled_side or measures is None:
        return []
    known = [section.depth for section in measures.cells]
    if not known:
        return [measures.front * (k + 0.5) / MOST for k in range(MOST)] if measures.front else []
    if len(known) <= MOST:
        return known
    return [known[i] for i in np.linspace(0, len(known) - 1, MOST).round().astype(int)]


def planes_of(
    manifest: Manifest, frame: Frame, depths: Sequence[float] | None = None
) -> list[ColumnPlane]:
    """Return the damage of one step on planes below the cooled face, and the cells in them.

    Parameters
    ----------
    manifest : description of the run.
    frame : the step with its fields.
    depths : depths of the planes (m); by default those that are drawn.
    """
    chosen = depths_of(manifest, frame.step) if depths is None else depths
    return [_plane(manifest, frame, depth) for depth in chosen]


def doubling(manifest: Manifest, deepest: float) -> list[ReferenceCurve]:
    """Return curves of the theoretical spacings of parallel cracks.

    Parameters
    ----------
    manifest : description of the run; without its ell0 there is no curve.
    deepest : depth at which the curves end (m).
    """
    ell0 = manifest.scales.get("ell0")
    if not ell0:
        return []
    depths = np.linspace(0.0, deepest, POINTS)
    spacing = spacing_at(depths, ell0)
    names = ("p(a): where parallel cracks double", "2 p(a): where they have doubled")
    return [
        ReferenceCurve(name=name, depths=depths, lengths=times * spacing)
        for times, name in enumerate(names, start=1)
        if np.isfinite(spacing).any()
    ]


def _plane(manifest: Manifest, frame: Frame, depth: float) -> ColumnPlane:
    """Return a plane on the pixel grid of `measure.column_planes`: its cells are the records'."""
    side = str(manifest.cooled_side)
    across, end = SIDES[3][side]
    one, other = (axis for axis in range(3) if axis != across)
    corner, size = manifest.corner, manifest.size
    raster = section_raster((size[one], size[other]), manifest.h)
    middles = raster.middles
    points = np.empty((len(middles), 3))
    points[:, [one, other]] = np.array([corner[one], corner[other]]) + middles
    points[:, across] = corner[across] + face_position(side, size) - end * depth
    damage = _damage(frame.grid, frame.alpha, points).reshape(raster.counts)
    return ColumnPlane(
        depth=depth,
        axes=(one, other),
        extent=(
            (corner[one], corner[one] + size[one]),
            (corner[other], corner[other] + size[other]),
        ),
        damage=damage,
        threshold=manifest.threshold,
        cells=cells(damage, pixel=raster.pixel, ell=manifest.ell, threshold=manifest.threshold),
    )


def _damage(grid: VtkMesh, alpha: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Return the damage at points, NaN outside the body."""
    import pyvista  # takes a second to load

    body = pyvista.UnstructuredGrid({grid.type: grid.cells}, grid.points)
    body["alpha"] = alpha
    found = pyvista.PolyData(points).sample(body)
    inside = np.asarray(found["vtkValidPointMask"]).astype(bool)
    return np.where(inside, np.asarray(found["alpha"]), np.nan)
