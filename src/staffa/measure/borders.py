"""Borders between the tiles of a pixel grid, their lengths, and the junctions of tiles."""

from dataclasses import dataclass
from enum import StrEnum
from itertools import combinations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

# Two tiles whose common border is shorter than this (in ell) meet in a point only: ridges are not
# resolved more finely.
SHORTEST = 1.0
# The direction of a crack at a junction is that of its first few ell, up to this length (in ell).
# The nearer half is left out, since the ridge's position at the junction is known to a pixel only.
REACH = 3.0
# The widest of the three angles is 180 degrees at a T and 120 at a Y: the nearer one decides.
WIDEST_OF_Y = 150.0


class Junction(StrEnum):
    """Type of a junction: T (one crack ends at another), Y (three alike), X (four or more).

    After Goehring, Phil. Trans. R. Soc. A 371, 20120353 (2013): at a T a crack meets a straight
    crack at a right angle; at a Y all angles are near 120 degrees.
    """

    T = "T"
    Y = "Y"
    X = "X"


@dataclass(frozen=True, kw_only=True)
class Raster:
    """Pixel grid over a rectangle.

    Attributes
    ----------
    pixel : edges of a pixel along both axes (m).
    shape : number of pixels along both axes.
    periodic : True for each axis along which the grid continues at its other end.
    """

    pixel: tuple[float, float]
    shape: tuple[int, ...]
    periodic: tuple[bool, bool] = (False, False)

    @property
    def extent(self) -> np.ndarray:
        """Lengths of the rectangle along both axes (m), shape (2,)."""
        return np.array(self.pixel) * self.shape

    def onward(self, field: np.ndarray, axes: tuple[bool, bool] = (True, True)) -> np.ndarray:
        """Return the field with its first row repeated at the end of each periodic axis.

        Parameters
        ----------
        field : one value a pixel, shape (n_x, n_y).
        axes : axes to extend, if they are periodic.
        """
        more = [(0, int(p and a)) for p, a in zip(self.periodic, axes, strict=True)]
        return np.pad(field, more, mode="wrap")

    def offsets(self, points: np.ndarray, of: np.ndarray) -> np.ndarray:
        """Return the shortest vectors from a point to other points (m), shape (n, 2).

        Parameters
        ----------
        points : end points (m), shape (n, 2).
        of : start point (m), shape (2,).
        """
        away = points - of
        return np.asarray(
            away - np.where(self.periodic, np.round(away / self.extent) * self.extent, 0.0)
        )

    def tree(self, points: np.ndarray) -> cKDTree:
        """Return a search tree of points (m), shape (n, 2), that knows the periodic axes."""
        size = np.where(self.periodic, self.extent, 0.0)
        return cKDTree(np.where(self.periodic, points % self.extent, points), boxsize=size)


@dataclass(frozen=True, kw_only=True)
class Borders:
    """Faces between pixels of different tiles.

    Attributes
    ----------
    points : centers of the faces (m), shape (n, 2).
    pairs : numbers of the two tiles, the lower one first, shape (n, 2).
    axes : axis across each face, shape (n,).
    """

    points: np.ndarray
    pairs: np.ndarray
    axes: np.ndarray


def borders(tiles: np.ndarray, raster: Raster) -> Borders:
    """Find all borders between tiles.

    Parameters
    ----------
    tiles : number of the tile of each pixel, 0 for none, shape (n_x, n_y).
    raster : the pixel grid.
    """
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
    """Return the pairs of tiles that have a common border, shape (m, 2), and its length (m), (m,).

    A border follows pixel edges like stairs. Its length is that of a straight border between the
    same ends, so that it is the same in all directions.

    Parameters
    ----------
    found : the borders.
    raster : the pixel grid.
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
    """Find the points at which three or more tiles meet, and the type of each junction.

    Junctions closer than SHORTEST ell are one. At a junction of three cracks the widest angle
    decides between T and Y. The direction of a crack is that from the junction to the middle of the
    part of its border within REACH ell, without the nearer half.

    Parameters
    ----------
    tiles : number of the tile of each pixel, shape (n_x, n_y).
    found : the borders of the tiles.
    raster : the pixel grid.
    ell : regularization length (m).

    Returns
    -------
    points : positions of the junctions (m), shape (k, 2).
    kinds : type of each.
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
    """Return the pixel corners at which three tiles or more meet, without gaps, and these tiles."""
    onward = raster.onward(tiles)
    around = np.stack([onward[:-1, :-1], onward[1:, :-1], onward[:-1, 1:], onward[1:, 1:]])
    around.sort(axis=0)
    several = (np.diff(around, axis=0) > 0).sum(axis=0) >= 2
    at = np.nonzero(several & (around[0] > 0))
    return (np.stack(at, axis=1) + 1.0) * raster.pixel, around[(slice(None), *at)].T


def _kind(members: np.ndarray, pairs: np.ndarray, offsets: np.ndarray) -> Junction:
    """Return the type of a junction from the borders around it; offsets are from the junction."""
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
