"""Where the tiles of a raster border one another, how far, and where three or more meet."""

from dataclasses import dataclass
from enum import StrEnum
from itertools import combinations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

# Two tiles that share a border of less than so many ell meet in a point only: crests are told
# apart no better.
SHORTEST = 1.0
# The direction of a crack where it meets others is that of its first few ell: beyond half of this,
# as the crest's own place at the meeting is known to a pixel only.
REACH = 3.0
# The widest of the three angles is 180 degrees at a T and 120 at a Y: it is told by the nearer one.
WIDEST_OF_Y = 150.0


class Junction(StrEnum):
    """How cracks meet: one ends at another (T), three part alike (Y), four or more cross (X).

    After Goehring, Phil. Trans. R. Soc. A 371, 20120353 (2013): at a T a crack meets another,
    straight one at a right angle; at a Y all angles are near 120 degrees.
    """

    T = "T"
    Y = "Y"
    X = "X"


@dataclass(frozen=True, kw_only=True)
class Raster:
    """Pixels over a rectangle: their edges (m) and number along both axes, and whether the raster
    goes on at its other end."""

    pixel: tuple[float, float]
    shape: tuple[int, ...]
    periodic: tuple[bool, bool] = (False, False)

    @property
    def extent(self) -> np.ndarray:
        """Along both axes (m)."""
        return np.array(self.pixel) * self.shape

    def onward(self, field: np.ndarray, axes: tuple[bool, bool] = (True, True)) -> np.ndarray:
        """The field, and along a periodic axis its first row once more."""
        more = [(0, int(p and a)) for p, a in zip(self.periodic, axes, strict=True)]
        return np.pad(field, more, mode="wrap")

    def offsets(self, points: np.ndarray, of: np.ndarray) -> np.ndarray:
        """The shortest ways from a point to others (m)."""
        away = points - of
        return np.asarray(
            away - np.where(self.periodic, np.round(away / self.extent) * self.extent, 0.0)
        )

    def tree(self, points: np.ndarray) -> cKDTree:
        """Points by nearness."""
        size = np.where(self.periodic, self.extent, 0.0)
        return cKDTree(np.where(self.periodic, points % self.extent, points), boxsize=size)


@dataclass(frozen=True, kw_only=True)
class Borders:
    """Faces between pixels of different tiles: their middles (m), shape (n, 2), the two tiles, the
    lower number first, shape (n, 2), and the axis across each, shape (n,)."""

    points: np.ndarray
    pairs: np.ndarray
    axes: np.ndarray


def borders(tiles: np.ndarray, raster: Raster) -> Borders:
    """All borders of tiles, 0 being no tile."""
    points, pairs, axes = [], [], []
    for axis in range(2):
        onward = raster.onward(tiles, (axis == 0, axis == 1))
        one = np.take(onward, range(onward.shape[axis] - 1), axis)
        other = np.take(onward, range(1, onward.shape[axis]), axis)
        at = np.nonzero((one != other) & (one > 0) & (other > 0))
        middles = np.stack(at, axis=1) + 0.5 + 0.5 * np.eye(2)[axis]
        points.append(middles * raster.pixel)
        pairs.append(np.sort(np.stack([one[at], other[at]], axis=1), axis=1))
        axes.append(np.full(len(middles), axis))
    return Borders(
        points=np.concatenate(points), pairs=np.concatenate(pairs), axes=np.concatenate(axes)
    )


def shared(found: Borders, raster: Raster) -> tuple[np.ndarray, np.ndarray]:
    """The pairs of tiles that border one another, shape (m, 2), and the lengths of that (m), (m,).

    A border goes up and down stairs; its length is that of a straight one between the same ends,
    so that it is the same in all directions.
    """
    pairs, number = np.unique(found.pairs, axis=0, return_inverse=True)
    length = np.zeros((2, len(pairs)))
    for axis in range(2):
        faces = np.bincount(number[found.axes == axis], minlength=len(pairs))
        length[axis] = faces * raster.pixel[1 - axis]
    return pairs, np.hypot(*length)


def junctions(
    tiles: np.ndarray, found: Borders, raster: Raster, ell: float
) -> tuple[np.ndarray, tuple[Junction, ...]]:
    """Where three or more tiles meet (m), shape (k, 2), and how.

    Meetings closer than SHORTEST ell are one. Of three cracks the widest angle tells whether they
    are a T or a Y; each one's direction is from the meeting to the middle of the part of the border
    that is within REACH ell, its nearer half left out.
    """
    corners, around = _corners(tiles, raster)
    if not len(corners):
        return np.zeros((0, 2)), ()
    near = raster.tree(corners).query_pairs(SHORTEST * ell, output_type="ndarray")
    graph = coo_array((np.ones(len(near)), near.T), shape=(len(corners), len(corners)))
    count, number = connected_components(graph, directed=False)
    tree = raster.tree(found.points)
    points, kinds = np.empty((count, 2)), []
    for k in range(count):
        here = corners[number == k]
        points[k] = here[0] + raster.offsets(here, here[0]).mean(axis=0)
        members = np.unique(around[number == k])
        nearby = np.array(tree.query_ball_point(points[k], REACH * ell), dtype=int)
        offsets = raster.offsets(found.points[nearby], points[k])
        kinds.append(_kind(members, found.pairs[nearby], offsets))
    return points, tuple(kinds)


def _corners(tiles: np.ndarray, raster: Raster) -> tuple[np.ndarray, np.ndarray]:
    """The corners of pixels at which three tiles or more meet, and nothing else, with the tiles."""
    onward = raster.onward(tiles)
    around = np.stack([onward[:-1, :-1], onward[1:, :-1], onward[:-1, 1:], onward[1:, 1:]])
    around.sort(axis=0)
    several = (np.diff(around, axis=0) > 0).sum(axis=0) >= 2
    at = np.nonzero(several & (around[0] > 0))
    return (np.stack(at, axis=1) + 1.0) * raster.pixel, around[(slice(None), *at)].T


def _kind(members: np.ndarray, pairs: np.ndarray, offsets: np.ndarray) -> Junction:
    """How the cracks between some tiles meet, from the borders around, relative to the meeting."""
    if len(members) > 3:
        return Junction.X
    distance = np.linalg.norm(offsets, axis=1)
    angles = []
    for pair in combinations(members, 2):
        arm = (pairs == pair).all(axis=1)
        if arm.any():  # one may be shorter than half a pixel
            far = arm & (distance >= distance[arm].max() / 2)
            x, y = offsets[far].sum(axis=0)
            angles.append(np.degrees(np.arctan2(y, x)))
    angles.sort()
    gaps = np.diff([*angles, angles[0] + 360])
    return Junction.T if len(angles) < 3 or gaps.max() > WIDEST_OF_Y else Junction.Y
