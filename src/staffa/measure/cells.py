"""Polygonal cells that cracks cut out of a plane, from the damage on a pixel grid.

A cell is a connected uncracked region. A watershed of the damage, started from these regions,
gives each a tile; the borders of the tiles are the ridges of the cracks between them. So tiles
fill the body whatever the threshold is, and a crack that ends within a region is no border.
"""

from collections import Counter
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import mean
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from skimage.measure import label
from skimage.segmentation import watershed

from staffa.measure.borders import SHORTEST, Junction, Raster, borders, junctions, shared
from staffa.records.step import CellSection

# A smaller uncracked region (in ell^2) is a gap between cracks, and no cell.
SMALLEST = 4.0
# Digits of the damage that count. The same run on another number of ranks differs in later digits,
# which would decide the watershed on flat ridges.
DIGITS = 6


@dataclass(frozen=True, kw_only=True)
class Cells:
    """Polygonal cells of a plane, n of them, numbered from 1.

    Attributes
    ----------
    tiles : number of the cell of each pixel, 0 outside the body, shape (n_x, n_y).
    areas : areas of the tiles (m^2), shape (n,).
    centroids : centroids of the tiles, from the corner of the grid (m), shape (n, 2).
    perimeters : length of the borders with other cells (m), shape (n,).
    sides : number of cells with which a cell has a border, shape (n,).
    ends : number of axes along which a cell touches an end of the body: 2 in a corner, 0 inside; at
        most 1 if the body is no rectangle. Shape (n,).
    junctions : positions of the junctions of cracks (m), shape (k, 2).
    kinds : type of each junction.
    cracked : part of the body's pixels whose damage exceeds the threshold.
    """

    tiles: np.ndarray
    areas: np.ndarray
    centroids: np.ndarray
    perimeters: np.ndarray
    sides: np.ndarray
    ends: np.ndarray
    junctions: np.ndarray
    kinds: tuple[Junction, ...]
    cracked: float

    @property
    def number(self) -> int:
        """Number of cells."""
        return len(self.areas)


def cell_section(found: Cells, *, depth: float, pixel: tuple[float, float]) -> CellSection:
    """Return the record of the cells of one plane.

    Parameters
    ----------
    found : the cells.
    depth : depth of the plane below the cooled face (m).
    pixel : edges of a pixel along both axes (m).
    """
    counts = Counter(found.kinds)
    return CellSection(
        depth=depth,
        pixel=pixel,
        areas=tuple(found.areas.tolist()),
        perimeters=tuple(found.perimeters.tolist()),
        sides=tuple(found.sides.tolist()),
        ends=tuple(found.ends.tolist()),
        junctions={str(kind): counts[kind] for kind in Junction},
        cracked=found.cracked,
    )


def cells(
    damage: np.ndarray,
    *,
    pixel: tuple[float, float],
    ell: float,
    threshold: float,
    periodic: tuple[bool, bool] = (False, False),
) -> Cells:
    """Find the polygonal cells of a plane.

    Parameters
    ----------
    damage : at the centers of pixels, shape (n_x, n_y); NaN outside the body.
    pixel : edges of a pixel along both axes (m).
    ell : regularization length (m).
    threshold : damage above which a pixel is cracked.
    periodic : True for each axis along which the grid continues at its other end: no cell ends
        there.
    """
    raster = Raster(pixel=pixel, shape=damage.shape, periodic=periodic)
    body, area = np.isfinite(damage), pixel[0] * pixel[1]
    height = np.where(body, np.round(damage, DIGITS), np.inf)
    regions = _regions(height <= threshold, periodic, SMALLEST * ell**2 / area)
    tiles = _flooded(height, regions, body, periodic)
    n, found = int(tiles.max(initial=0)), borders(tiles, raster)
    pairs, lengths = shared(found, raster)
    points, kinds = junctions(tiles, found, raster, ell)
    return Cells(
        tiles=tiles,
        areas=np.bincount(tiles.ravel(), minlength=n + 1)[1:] * area,
        centroids=_centroids(tiles, n, raster),
        perimeters=_by_cell(pairs, lengths, n),
        sides=_by_cell(pairs, lengths >= SHORTEST * ell, n).astype(int),
        ends=_ends(tiles, n, periodic),
        junctions=points,
        kinds=kinds,
        cracked=float(np.mean(height[body] > threshold)) if body.any() else 0.0,
    )


def _regions(sound: np.ndarray, periodic: tuple[bool, bool], smallest: float) -> np.ndarray:
    """Number the connected regions of at least `smallest` pixels from 1."""
    found = label(sound, connectivity=1)  # a crack from pixel to pixel across corners divides
    first_and_last = [
        np.stack([np.take(found, end, axis) for end in (0, -1)])
        for axis, joined in enumerate(periodic)
        if joined
    ]
    seam = np.concatenate([np.zeros((2, 0), dtype=int), *first_and_last], axis=1)
    seam = seam[:, (seam > 0).all(axis=0)]
    n = int(found.max(initial=0)) + 1
    graph = coo_array((np.ones(seam.shape[1]), tuple(seam)), shape=(n, n))
    found = connected_components(graph, directed=False)[1][found]
    large = np.bincount(found.ravel()) >= smallest
    large[0] = False
    return np.asarray(np.where(large, np.cumsum(large), 0)[found])


def _flooded(
    height: np.ndarray, regions: np.ndarray, body: np.ndarray, periodic: tuple[bool, bool]
) -> np.ndarray:
    """Return the regions, grown over the cracks until they meet on the ridges."""
    # Beyond a periodic end the watershed continues for half of the grid.
    more = [(n // 2 * joined,) * 2 for n, joined in zip(height.shape, periodic, strict=True)]
    fields = (np.pad(field, more, mode="wrap") for field in (height, regions, body))
    height, regions, body = fields
    grown = watershed(height, regions, mask=body)
    return np.asarray(grown[tuple(slice(low, -low or None) for low, _ in more)])


def _by_cell(pairs: np.ndarray, values: np.ndarray, n: int) -> np.ndarray:
    """Return the sum over the pairs of each cell."""
    return np.bincount(pairs.ravel(), weights=np.repeat(values, 2), minlength=n + 1)[1:]


def _centroids(tiles: np.ndarray, n: int, raster: Raster) -> np.ndarray:
    """Return the mean pixel positions; along a periodic axis, the circular means."""
    found = np.empty((n, 2))
    for axis, (extent, joined) in enumerate(zip(raster.extent, raster.periodic, strict=True)):
        place = np.expand_dims((np.arange(tiles.shape[axis]) + 0.5) * raster.pixel[axis], 1 - axis)
        place = np.broadcast_to(place, tiles.shape)
        if joined:
            turn = 2 * np.pi * place / extent
            x, y = (mean(wave(turn), tiles, range(1, n + 1)) for wave in (np.cos, np.sin))
            found[:, axis] = np.arctan2(y, x) / (2 * np.pi) * extent % extent
        else:
            found[:, axis] = mean(place, tiles, range(1, n + 1))
    return found


def _ends(tiles: np.ndarray, n: int, periodic: tuple[bool, bool]) -> np.ndarray:
    """Return the number of axes along which each cell touches the outside of the body."""
    beyond = np.pad(tiles, [(int(not joined),) * 2 for joined in periodic])
    found = np.zeros(n + 1, dtype=int)
    for axis in range(2):
        out = np.zeros(beyond.shape, dtype=bool)
        for step in (1, -1):
            out |= np.roll(beyond, step, axis) == 0
        found[np.unique(beyond[out])] += 1
    # A body that does not fill the raster has no corners that are known.
    return found[1:] if tiles.all() else np.minimum(found[1:], 1)
