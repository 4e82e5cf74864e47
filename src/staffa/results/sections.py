"""The planes below the cooled face of a 3-D body that are drawn, and the theory beside them."""

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
    """At most six depths (m): those at which the run found cells, or even ones down to the deepest
    crack; none without a cooled face or a crack."""
    measures = step.measures
    if not manifest.cooled_side or measures is None:
        return []
    known = [section.depth for section in measures.cells]
    if not known:
        return [measures.front * (k + 0.5) / MOST for k in range(MOST)] if measures.front else []
    if len(known) <= MOST:
        return known
    return [known[i] for i in np.linspace(0, len(known) - 1, MOST).round().astype(int)]


def planes_of(manifest: Manifest, frame: Frame) -> list[ColumnPlane]:
    """The damage of one moment on planes below the cooled face, and the cells in them."""
    return [_plane(manifest, frame, depth) for depth in depths_of(manifest, frame.step)]


def doubling(manifest: Manifest, deepest: float) -> list[ReferenceCurve]:
    """Between which spacings parallel cracks are, by theory, down to a depth (m); none where the
    case tells no ell0."""
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
    """On the raster of `measure.planes`, so that the cells are those of the records."""
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
    """The damage at points, NaN outside of the body."""
    import pyvista  # takes a second to load

    body = pyvista.UnstructuredGrid({grid.type: grid.cells}, grid.points)
    body["alpha"] = alpha
    found = pyvista.PolyData(points).sample(body)
    inside = np.asarray(found["vtkValidPointMask"]).astype(bool)
    return np.where(inside, np.asarray(found["alpha"]), np.nan)
