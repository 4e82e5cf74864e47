"""Tips of a crack network, the way in which each would grow, and the room around it."""

from dataclasses import dataclass

import numpy as np

from staffa.measure.network import Network, normals
from staffa.measure.opening import outward

# Rings around a tip end so many ell from it; a ring that ends nearer is too deep in soft rock.
LARGEST, SMALLEST = 6.0, 3.0
# The direction is that of the last so many ell of the crack.
STRAIGHT = 2.0
# The band of another tip reaches so many ell.
BAND = 2.0
# At the mouth of a crack its band meets a face: what presses there is uneven within so many ell.
MOUTH = 1.0
# Points of a front in 3-D are so many ell apart.
APART = 3.0
# Sine of the angle from which a crack, or a face of the body, lies across a direction.
CRACK_ACROSS, FACE_ACROSS = 0.5, 0.2


@dataclass(frozen=True, kw_only=True)
class Surface:
    """The facets of a body's surface: middles and unit normals, shape (n, 3), sizes (m), (n,)."""

    middles: np.ndarray
    normals: np.ndarray
    sizes: np.ndarray


@dataclass(frozen=True, kw_only=True)
class Front:
    """A tip in 2-D, a point of a crack's front in 3-D.

    position (m), direction (unit vector): of three numbers. radius: how far the largest ring around
    it may reach (m). reason: why there is none, None if there is.
    """

    position: tuple[float, float, float]
    direction: tuple[float, float, float]
    radius: float
    reason: str | None = None


def fronts(found: Network, surface: Surface, *, ell: float, h: float) -> tuple[Front, ...]:
    """The tips of a network in order of their places. Ends at the surface of the body are none.

    Parameters
    ----------
    ell, h : regularization length, cell edge (m).
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
    """Numbers of points no nearer to one another than a distance, taken from one side on."""
    taken: list[int] = []
    for k in np.lexsort(np.rint(points / (1e-2 * distance)).T):
        if all(np.linalg.norm(points[k] - points[other]) >= distance for other in taken):
            taken.append(int(k))
    return taken


def _way(end: np.ndarray, middles: np.ndarray, sizes: np.ndarray, reach: float) -> np.ndarray:
    """Unit vector from the middle of the last stretch of a crack to its end."""
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
    """Distance (m) of a tip to the surface, but for faces along its way."""
    across = np.abs(surface.normals @ way) > FACE_ACROSS
    return _nearest(surface.middles - end, across, surface.sizes)


def _nearest(offsets: np.ndarray, which: np.ndarray, less: np.ndarray | float) -> float:
    """Length of the shortest of some offsets, each less a length; inf without any."""
    lengths = np.linalg.norm(offsets, axis=1) - less
    return max(0.0, float(np.min(lengths[which], initial=np.inf)))
