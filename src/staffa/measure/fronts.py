"""Tips of a crack network, their directions of growth, and the free radius around each."""

from dataclasses import dataclass

import numpy as np

from staffa.measure.network import Network, normals
from staffa.measure.opening import outward

# Radius (in ell) at which rings around a tip end; a smaller ring is too deep in damaged rock.
LARGEST, SMALLEST = 6.0, 3.0
# The direction of a tip is that of this last length (in ell) of the crack.
STRAIGHT = 2.0
# Half width (in ell) of the band of another crack.
BAND = 2.0
# At the mouth of a crack its band meets a face: within this distance (in ell) loads are uneven.
MOUTH = 1.0
# Distance (in ell) between the points of a crack front in 3-D.
APART = 3.0
# Sine of the angle from which a crack, or a face of the body, lies across a direction.
CRACK_ACROSS, FACE_ACROSS = 0.5, 0.2


@dataclass(frozen=True, kw_only=True)
class Surface:
    """Facets of a body's surface.

    Attributes
    ----------
    middles : centers of the facets (m), shape (n, 3).
    normals : unit normals, shape (n, 3).
    sizes : radius of each facet around its center (m), shape (n,).
    """

    middles: np.ndarray
    normals: np.ndarray
    sizes: np.ndarray


@dataclass(frozen=True, kw_only=True)
class Front:
    """Crack tip in 2-D, or point of a crack front in 3-D.

    Attributes
    ----------
    position : coordinates (m), three numbers.
    direction : direction of growth, a unit vector of three numbers.
    radius : largest radius of a ring around it (m).
    reason : sentence that says why no ring fits; None if one does.
    """

    position: tuple[float, float, float]
    direction: tuple[float, float, float]
    radius: float
    reason: str | None = None


def fronts(found: Network, surface: Surface, *, ell: float, h: float) -> tuple[Front, ...]:
    """Return the tips of a network, sorted by position; ends at the body's surface are none.

    Parameters
    ----------
    found : the network.
    surface : facets of the body's surface.
    ell : regularization length (m).
    h : mesh size (m).
    """
    if not len(found.elements):
        return ()
    plane = found.elements.shape[1] == 2
    ends = found.points[outward(found.points, found.elements).any(axis=1)]
    middles = found.points[found.elements].mean(axis=1)
    ways = np.array([_way(end, middles, found.sizes, STRAIGHT * ell) for end in ends])
    tip = [_to_face(end, way, surface) > ell + h for end, way in zip(ends, ways, strict=True)]
    ends, ways = ends[tip], ways[tip]
    if not len(ends):
        return ()
    if not plane:
        apart = _spread(ends, APART * ell)
        ends, ways = ends[apart], ways[apart]
    order = np.lexsort(np.rint(ends / (1e-3 * h)).T)
    ends, ways = ends[order], ways[order]
    crack = middles, normals(found.points, found.elements)
    return tuple(_front(k, ends, ways, crack, surface, ell, plane) for k in range(len(ends)))


def _spread(points: np.ndarray, distance: float) -> list[int]:
    """Select points that are at least a distance apart, taken in order from one side."""
    taken: list[int] = []
    for k in np.lexsort(np.rint(points / (1e-2 * distance)).T):
        if all(np.linalg.norm(points[k] - points[other]) >= distance for other in taken):
            taken.append(int(k))
    return taken


def _way(end: np.ndarray, middles: np.ndarray, sizes: np.ndarray, reach: float) -> np.ndarray:
    """Return the unit vector from the middle of the last stretch of a crack to its end."""
    behind = np.linalg.norm(middles - end, axis=1) < reach
    if not behind.any():
        return np.zeros(3)
    way = end - np.average(middles[behind], axis=0, weights=sizes[behind])
    length = float(np.linalg.norm(way))
    return way / length if length > 0 else way


def _front(
    k: int,
    ends: np.ndarray,
    ways: np.ndarray,
    crack: tuple[np.ndarray, np.ndarray],
    surface: Surface,
    ell: float,
    plane: bool,
) -> Front:
    end, way = ends[k], ways[k]
    near = {
        "a face of the body": _to_face(end, way, surface) - MOUTH * ell,
        "a crack across its way": _nearest(
            crack[0] - end, np.abs(crack[1] @ way) > CRACK_ACROSS, BAND * ell
        ),
    }
    others = np.arange(len(ends)) != k
    if not plane:  # the front of one crack grows together
        others &= ways @ way < CRACK_ACROSS
    near["another tip"] = _nearest(ends - end, others, BAND * ell)
    what = min(near, key=lambda name: near[name])
    radius = min(LARGEST * ell, near[what])
    reason = None
    if radius < SMALLEST * ell:
        reason = f"{what} is nearer than a ring around the tip needs ({SMALLEST:g} ell)"
    return Front(
        position=(float(end[0]), float(end[1]), float(end[2])),
        direction=(float(way[0]), float(way[1]), float(way[2])),
        radius=float(radius),
        reason=reason,
    )


def _to_face(end: np.ndarray, way: np.ndarray, surface: Surface) -> float:
    """Return the distance (m) of a tip to the surface, without faces along its direction."""
    across = np.abs(surface.normals @ way) > FACE_ACROSS
    return _nearest(surface.middles - end, across, surface.sizes)


def _nearest(offsets: np.ndarray, which: np.ndarray, less: np.ndarray | float) -> float:
    """Return the length of the shortest selected offset, each less a length; inf without any."""
    lengths = np.linalg.norm(offsets, axis=1) - less
    return max(0.0, float(np.min(lengths[which], initial=np.inf)))
