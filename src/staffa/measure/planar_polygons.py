"""Planar polygons in place of the crack surfaces of a 3-D network, for discrete fracture networks.

A crack surface is parted where it bends. Each part is replaced by a polygon in its plane of least
squares: the convex hull of its points there.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np
import scipy

from staffa.measure.network import Network, normals

# Angle (degrees) of a triangle to the mean normal of a part, beyond which it is no part of it.
BEND = 30.0
# Corners of a polygon are left out if they lie nearer than this part of its extent to the side
# between their neighbors.
STRAIGHT = 0.01


@dataclass(frozen=True, kw_only=True)
class Polygon:
    """Planar polygon that stands for a part of a crack.

    Attributes
    ----------
    crack : number of the crack in the network.
    corners : corners in order (m), shape (n, 3), all in one plane.
    center : center of the area of the part (m), shape (3,).
    normal : unit normal of the plane, shape (3,); its largest component is positive.
    area : area of the traced part (m^2).
    polygon_area : area of the polygon (m^2), larger where the part is not convex.
    flatness : root of the mean square distance of the part from the plane (m).
    aperture, uncertainty : mean opening of the part and its uncertainty (m).
    """

    crack: int
    corners: np.ndarray
    center: np.ndarray
    normal: np.ndarray
    area: float
    polygon_area: float
    flatness: float
    aperture: float
    uncertainty: float


def planar_polygons(found: Network, *, least: float) -> list[Polygon]:
    """Return polygons for the parts of a 3-D network, those of the largest crack first.

    Parameters
    ----------
    found : the network, of triangles.
    least : area (m^2) below which a part is left out.
    """
    if not len(found.elements):
        return []
    part, number = planar_parts(found)
    areas = np.bincount(part, weights=found.sizes, minlength=number)
    order = sorted(
        np.flatnonzero(areas >= least).tolist(), key=lambda k: (_crack(found, part, k), -areas[k])
    )
    polygons = (_polygon(found, np.flatnonzero(part == k)) for k in order)
    return [polygon for polygon in polygons if polygon is not None]


def planar_parts(found: Network) -> tuple[np.ndarray, int]:
    """Return the number of each triangle's part, shape (m,), and how many parts there are.

    A part grows from its largest triangle over shared sides, as long as it does not bend.
    """
    across, neighbors = normals(found.points, found.elements), _neighbors(found.elements)
    part = np.full(len(found.elements), -1)
    number, limit = 0, float(np.cos(np.radians(BEND)))
    for seed in np.argsort(-found.sizes, kind="stable").tolist():
        if part[seed] >= 0:
            continue
        part[seed], total, waiting = number, across[seed] * found.sizes[seed], deque([seed])
        while waiting:
            for other in neighbors[waiting.popleft()]:
                along = float(across[other] @ total) / max(float(np.linalg.norm(total)), 1e-300)
                if part[other] < 0 and abs(along) >= limit:
                    part[other] = number
                    total = total + np.sign(along) * across[other] * found.sizes[other]
                    waiting.append(other)
        number += 1
    return part, number


def _crack(found: Network, part: np.ndarray, number: int) -> int:
    return int(found.cracks[np.argmax(part == number)])


def _neighbors(elements: np.ndarray) -> list[list[int]]:
    """Return the triangles that share a side with each."""
    sides = np.sort(elements[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(elements)), 3)
    _, side = np.unique(sides, axis=0, return_inverse=True)
    meets = scipy.sparse.coo_array((np.ones(len(owner)), (owner, side.ravel()))).tocsr()
    graph = (meets @ meets.T).tocsr()
    rows = np.split(graph.indices, graph.indptr[1:-1])
    return [sorted(set(row.tolist()) - {k}) for k, row in enumerate(rows)]


def _polygon(found: Network, members: np.ndarray) -> Polygon | None:
    """Return the polygon of these triangles; None if they have no extent in two directions."""
    elements, sizes = found.elements[members], found.sizes[members]
    area = float(sizes.sum())
    corners = found.points[elements]
    center = np.asarray((sizes[:, None] * corners.mean(axis=1)).sum(axis=0) / area)
    axes, spread = _plane(corners - center, sizes)
    flat = (found.points[np.unique(elements)] - center) @ axes[:2].T
    outline = _outline(flat)
    if outline is None:
        return None
    volumes = (
        sizes @ values[elements].mean(axis=1) for values in (found.opening, found.uncertainty)
    )
    aperture, uncertainty = (float(volume) / area for volume in volumes)
    return Polygon(
        crack=int(found.cracks[members[0]]),
        corners=center + outline @ axes[:2],
        center=center,
        normal=axes[2],
        area=area,
        polygon_area=_area(outline),
        flatness=spread,
        aperture=aperture,
        uncertainty=uncertainty,
    )


def _plane(corners: np.ndarray, sizes: np.ndarray) -> tuple[np.ndarray, float]:
    """Return two axes in the plane of least squares with its normal, and the mean distance from it.

    The second moments of the triangles are exact: of linear functions on them.
    """
    sums = corners.sum(axis=1)
    moments = np.einsum("m,mki,mkj->ij", sizes, corners, corners)
    moments = (moments + np.einsum("m,mi,mj->ij", sizes, sums, sums)) / (12 * sizes.sum())
    axes = np.linalg.eigh(moments)[1]
    normal = axes[:, 0]
    normal = normal * np.sign(normal[np.argmax(np.abs(normal))])
    first = axes[:, 2] * np.sign(axes[np.argmax(np.abs(axes[:, 2])), 2])
    away = corners @ normal
    squares = sizes @ ((away**2).sum(axis=1) + away.sum(axis=1) ** 2) / (12 * sizes.sum())
    return np.array([first, np.cross(normal, first), normal]), float(np.sqrt(squares))


def _outline(flat: np.ndarray) -> np.ndarray | None:
    """Return the corners of the convex hull of points (n, 2), counterclockwise."""
    try:
        hull = flat[scipy.spatial.ConvexHull(flat).vertices]
    except scipy.spatial.QhullError:
        return None
    limit = STRAIGHT * float(np.ptp(hull, axis=0).max())
    while len(hull) > 3:
        before, after = np.roll(hull, 1, axis=0), np.roll(hull, -1, axis=0)
        side = after - before
        length = np.maximum(np.linalg.norm(side, axis=1), np.finfo(float).tiny)
        away = np.abs(side[:, 0] * (hull - before)[:, 1] - side[:, 1] * (hull - before)[:, 0])
        least = int(np.argmin(away / length))
        if (away / length)[least] > limit:
            break
        hull = np.delete(hull, least, axis=0)
    return np.asarray(hull)


def _area(corners: np.ndarray) -> float:
    """Return the area within corners (n, 2) in order."""
    x, y = corners.T
    return float(abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2)
