"""Ridge of a field on a pixel grid, as segments in 2-D or quadrilaterals in 3-D.

A point of the ridge is a maximum along the direction in which the field bends most: there
e . grad f = 0, with e the eigenvector of the Hessian of the lowest eigenvalue (Eberly, Ridges in
Image and Data Analysis, 1996). The sign of e is arbitrary, but it can be made equal at the two ends
of a grid edge, and the ridge is built from the crossed edges alone (surface nets; Gibson, MICCAI
1998): each grid cell has one point, the mean of its crossings, and across each crossed edge one
element joins the cells around it. So the method is the same in 2-D and in 3-D.
"""

from itertools import combinations_with_replacement
from math import ceil

import numpy as np
from scipy.ndimage import gaussian_filter

# Two neighbors whose directions differ by more have no crossing: there ridges meet.
ALIKE = 0.5
# The ridge of a symmetric field may lie exactly on grid points. So the field, over its height, is
# tilted by this amount an edge.
TILT = 1e-7


def ridge(
    field: np.ndarray, *, sigma: float, lowest: float, sharpest: float
) -> tuple[np.ndarray, np.ndarray]:
    """Find the ridge of a field on a pixel grid, smoothed by a Gaussian.

    All lengths are in edges of the grid.

    Parameters
    ----------
    field : shape (n_x, n_y) or (n_x, n_y, n_z).
    sigma : standard deviation of the Gaussian.
    lowest : value of the smoothed field that a ridge exceeds.
    sharpest : least downward second derivative across a ridge.

    Returns
    -------
    points : positions, shape (n, 2 or 3).
    elements : numbers of points, shape (m, 2) in 2-D; (m, 4), around each quadrilateral, in 3-D.
    """
    dim = field.ndim
    there, direction, slope = _bending(field, sigma, lowest, sharpest)
    place = np.full(field.shape, -1)
    place[there] = np.arange(len(slope))
    crossings, cells = [], []
    for axis in range(dim):
        start, end = _ends(place, axis)
        sign = np.einsum("ij,ij->i", direction[place[start]], direction[place[end]])
        a, b = slope[place[start]], np.sign(sign) * slope[place[end]]
        crossed = ((a < 0) != (b < 0)) & (np.abs(sign) > ALIKE)
        at = np.stack(start, axis=1)[crossed]
        share = (a / np.where(a == b, 1.0, a - b))[crossed]
        crossings.append(at + share[:, None] * np.eye(dim)[axis])
        cells.append(at[:, None, :] + _around(axis, dim) + 1)  # cells also lie outside, by one
    return _joined(np.concatenate(crossings), np.concatenate(cells), field.shape)


def _bending(
    field: np.ndarray, sigma: float, lowest: float, sharpest: float
) -> tuple[tuple[np.ndarray, ...], np.ndarray, np.ndarray]:
    """Return the points near a ridge, the direction across it, and the slope in that direction."""
    dim, margin = field.ndim, ceil(4 * sigma)  # beyond it the Gaussian is cut off
    # An odd reflection about each side continues the field smoothly, inclined ridges too.
    beyond = np.pad(field, margin, mode="reflect", reflect_type="odd")
    inside = (slice(margin, -margin),) * dim

    def derivative(*axes: int) -> np.ndarray:
        order = tuple(axes.count(axis) for axis in range(dim))
        return np.asarray(gaussian_filter(beyond, sigma, order=order)[inside])

    there = np.nonzero(derivative() > lowest)
    hessian = np.empty((len(there[0]), dim, dim))
    for i, j in combinations_with_replacement(range(dim), 2):
        hessian[:, i, j] = hessian[:, j, i] = derivative(i, j)[there]
    bend, directions = np.linalg.eigh(hessian)
    sharp = bend[:, 0] < -sharpest
    there = tuple(index[sharp] for index in there)
    direction = directions[sharp, :, 0]
    tilt = TILT * np.array([1.0, np.sqrt(2), np.sqrt(3)])[:dim]
    gradient = np.stack([derivative(axis)[there] for axis in range(dim)], axis=1) + tilt
    return there, direction, np.einsum("ij,ij->i", direction, gradient)


def _ends(place: np.ndarray, axis: int) -> tuple[tuple[np.ndarray, ...], tuple[np.ndarray, ...]]:
    """Return both ends of the grid edges along an axis between points near a ridge."""
    lower = np.take(place, range(place.shape[axis] - 1), axis=axis)
    upper = np.take(place, range(1, place.shape[axis]), axis=axis)
    start = np.nonzero((lower >= 0) & (upper >= 0))
    return start, tuple(index + (k == axis) for k, index in enumerate(start))


def _around(axis: int, dim: int) -> np.ndarray:
    """Return the grid cells around an edge, relative to its start, in order around it."""
    others = [k for k in range(dim) if k != axis]
    steps = np.array([[0, 0], [-1, 0], [-1, -1], [0, -1]]) if dim == 3 else np.array([[0], [-1]])
    found = np.zeros((len(steps), dim), dtype=np.int64)
    found[:, others] = steps
    return found


def _joined(
    crossings: np.ndarray, cells: np.ndarray, shape: tuple[int, ...]
) -> tuple[np.ndarray, np.ndarray]:
    """Return one point in each cell, the mean of its crossings, and the elements that join them."""
    numbers = np.ravel_multi_index(tuple(np.moveaxis(cells, -1, 0)), tuple(n + 1 for n in shape))
    _, elements = np.unique(numbers, return_inverse=True)
    elements = elements.reshape(numbers.shape)
    counts = np.bincount(elements.ravel())
    repeated = np.repeat(crossings, elements.shape[1], axis=0)
    sums = [np.bincount(elements.ravel(), weights=column) for column in repeated.T]
    return np.stack(sums, axis=1) / counts[:, None], elements
