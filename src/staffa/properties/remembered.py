"""Memory of a function of position, for meshes of which most cells stay as they are."""

import numpy as np

from staffa.physics.elasticity import PointFunction

# Odd numbers by which the bits of a point become one number, which almost no other point has.
FACTORS = np.array([0x9E3779B97F4A7C15, 0xC2B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.uint64)


class Remembered:
    """A function of position that is computed once at each point, to the bit the same."""

    def __init__(self, function: PointFunction) -> None:
        """Take a function whose value at a point does not depend on other points."""
        self._function = function
        self._keys = np.zeros(0, dtype=np.uint64)
        self._points, self._values = np.zeros((0, 3)), np.zeros(0)

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Return the values at points of shape (3, n)."""
        points = np.ascontiguousarray(x.T, dtype=float)
        keys = points.view(np.uint64) @ FACTORS
        known, found = self._known(points, keys)
        if not known.all():
            found[~known] = self._function(x[:, ~known])
        order = np.argsort(keys, kind="stable")
        self._keys, self._points, self._values = keys[order], points[order], found[order]
        return found

    def _known(self, points: np.ndarray, keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return which points were among the last ones, and the values there."""
        found = np.zeros(len(points))
        if not len(self._keys):
            return np.zeros(len(points), dtype=bool), found
        place = np.minimum(np.searchsorted(self._keys, keys), len(self._keys) - 1)
        known = np.all(self._points[place] == points, axis=1)
        found[known] = self._values[place[known]]
        return known, found
