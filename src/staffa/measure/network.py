"""Crack network of one state: polylines in 2-D, triangles in 3-D, with openings at points."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components


@dataclass(frozen=True, kw_only=True)
class Network:
    """Cracks of one state.

    The opening is linear between points, and its integral over the network is the crack volume.

    Attributes
    ----------
    points : coordinates (m), shape (n, 3).
    elements : points of each segment, shape (m, 2), or of each triangle, shape (m, 3).
    damage : damage at the points, shape (n,).
    opening : crack opening at the points (m), shape (n,); empty if it is not known yet.
    uncertainty : uncertainty of the opening (m), shape (n,); empty if it is not known yet.
    axial : True if each segment is a ring around the axis x = 0, and counts by its area.
    """

    points: np.ndarray
    elements: np.ndarray
    damage: np.ndarray
    opening: np.ndarray = field(default_factory=lambda: np.zeros(0))
    uncertainty: np.ndarray = field(default_factory=lambda: np.zeros(0))
    axial: bool = False

    @cached_property
    def sizes(self) -> np.ndarray:
        """Length of each segment (m), or area of each triangle or ring (m^2), shape (m,)."""
        found = sizes(self.points, self.elements)
        if not self.axial:
            return found
        return np.asarray(2 * np.pi * self.points[self.elements, 0].mean(axis=1) * found)

    @cached_property
    def cracks(self) -> np.ndarray:
        """Number of each element's crack, shape (m,): a connected part; the largest is 0."""
        return _parts(self.elements, self.sizes)

    @cached_property
    def branches(self) -> np.ndarray:
        """Number of each segment's branch, from tip or junction to the next (2-D), shape (m,)."""
        return _branches(self.elements, len(self.points))

    @property
    def size(self) -> float:
        """Total length (m), or area (m^2)."""
        return float(self.sizes.sum())

    @property
    def volume(self) -> float:
        """Integral of the opening: area in 2-D (m^2), volume in 3-D (m^3)."""
        return float(self.sizes @ self.opening[self.elements].mean(axis=1))

    @property
    def uncertain_volume(self) -> float:
        """Integral of the uncertainty: area in 2-D (m^2), volume in 3-D (m^3)."""
        return float(self.sizes @ self.uncertainty[self.elements].mean(axis=1))


def sizes(points: np.ndarray, elements: np.ndarray) -> np.ndarray:
    """Return the length of each segment (m), or the area of each triangle (m^2), shape (m,)."""
    sides = points[elements[:, 1:]] - points[elements[:, :1]]
    if elements.shape[1] == 2:
        return np.asarray(np.linalg.norm(sides[:, 0], axis=1))
    return np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2


def normals(points: np.ndarray, elements: np.ndarray) -> np.ndarray:
    """Return a unit vector across each element, shape (m, 3)."""
    sides = points[elements[:, 1:]] - points[elements[:, :1]]
    other = sides[:, 1] if elements.shape[1] == 3 else np.array([0.0, 0.0, 1.0])
    across = np.cross(sides[:, 0], other)
    return across / np.maximum(np.linalg.norm(across, axis=1), np.finfo(float).tiny)[:, None]


def polylines(found: Network) -> list[np.ndarray]:
    """Return the points of each branch of a 2-D network in order along the branch."""
    lines = []
    order = np.argsort(found.branches, kind="stable")
    starts = np.flatnonzero(np.diff(found.branches[order], prepend=-1))
    for members in np.split(order, starts[1:]) if len(order) else []:
        lines.append(_walk(found.elements[members]))
    return lines


def _walk(segments: np.ndarray) -> np.ndarray:
    """Return the points of a chain of segments in order from one end; a ring closes on itself."""
    ways: dict[int, list[int]] = {}
    for number, segment in enumerate(segments.tolist()):
        for point in segment:
            ways.setdefault(point, []).append(number)
    at = min(ways, key=lambda point: (len(ways[point]), point))
    line, left = [at], set(range(len(segments)))
    while onward := [number for number in ways[at] if number in left]:
        left.remove(onward[0])
        i, j = segments[onward[0]].tolist()
        at = j if at == i else i
        line.append(at)
    return np.array(line)


def selected(found: Network, elements: np.ndarray) -> Network:
    """Return these elements and the points that they use, without openings."""
    used, numbers = np.unique(elements, return_inverse=True)
    return Network(
        points=found.points[used],
        elements=numbers.reshape(elements.shape),
        damage=found.damage[used],
    )


def _parts(elements: np.ndarray, extents: np.ndarray) -> np.ndarray:
    """Return the number of the connected part of each element, the largest part first."""
    if not len(elements):
        return np.zeros(0, dtype=np.int64)
    n = elements.max() + 1
    pairs = np.concatenate([elements[:, [k - 1, k]] for k in range(elements.shape[1])])
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(n, n))
    part = connected_components(graph, directed=False)[1][elements[:, 0]]
    order = np.argsort(-np.bincount(part, weights=extents), kind="stable")
    return np.asarray(np.argsort(order)[part])


def _branches(elements: np.ndarray, n_points: int) -> np.ndarray:
    """Number the branches: segments joined at points that exactly two of them share."""
    m = len(elements)
    degree = np.bincount(elements.ravel(), minlength=n_points)
    order = np.argsort(elements.ravel(), kind="stable")
    through = degree[elements.ravel()[order]] == 2
    pairs = (order[through] // elements.shape[1]).reshape(-1, 2)
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(m, m))
    return np.asarray(connected_components(graph, directed=False)[1].astype(np.int64))
