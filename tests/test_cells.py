"""The cells of drawn sections are as many, as large and as sided as they were drawn."""

from collections import Counter

import numpy as np
import pytest
from scipy.spatial import cKDTree

from staffa.measure.cells import Cells, cells

ELL = 0.03
WHOLE, PERIODIC = (False, False), (True, True)


def middles(*counts: int, edge: float) -> tuple[np.ndarray, np.ndarray]:
    """The middles of pixels."""
    x, y = ((np.arange(n) + 0.5) * edge for n in counts)
    return np.meshgrid(x, y, indexing="ij")


def damage(distance: np.ndarray, ell: float = ELL) -> np.ndarray:
    """The damage of AT1 at a distance from cracks."""
    return np.clip(1 - distance / (2 * ell), 0, 1) ** 2


def to_lines(x: np.ndarray, apart: float) -> np.ndarray:
    """Distance to the nearest of parallel lines, the first one through 0."""
    return np.abs((x + apart / 2) % apart - apart / 2)


def measured(alpha: np.ndarray, edge: float, periodic=PERIODIC, **more) -> Cells:
    given = {"ell": ELL, "threshold": 0.8, "periodic": periodic, **more}
    return cells(alpha, pixel=(edge, edge), **given)


def to_borders(x: np.ndarray, y: np.ndarray, points: np.ndarray, size) -> np.ndarray:
    """Distance to the borders of the periodic Voronoi cells of points, shape (n, 2)."""
    at = np.stack([x.ravel(), y.ravel()], axis=1)
    near, number = cKDTree(points, boxsize=size).query(at, k=8)
    way = points[number[:, 1:]] - points[number[:, :1]]
    way -= np.round(way / size) * size
    to_bisectors = (near[:, 1:] ** 2 - near[:, :1] ** 2) / (2 * np.linalg.norm(way, axis=2))
    return to_bisectors.min(axis=1).reshape(x.shape)


def test_squares_have_four_sides_and_cross() -> None:
    x, y = middles(120, 120, edge=1 / 120)
    found = measured(damage(np.minimum(to_lines(x, 0.25), to_lines(y, 0.25))), 1 / 120)
    assert found.number == 16
    assert set(found.sides) == {4} and set(found.ends) == {0}
    assert found.areas == pytest.approx(np.full(16, 1 / 16), rel=1e-9)
    assert Counter(found.kinds) == {"X": 16}
