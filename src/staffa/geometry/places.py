"""Places in a body at which properties are sampled before there is a mesh."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

# Places closer than this part of a cell are one: "0.03 mm" and "30 um" differ in the last digit.
SAME = 1e-9
ALONG = 21  # places along each axis
MOST = 5000  # vertices of a mesh, or of a face of it, that are looked at
Bounds = tuple[tuple[float, ...], tuple[float, ...]]
Contains = Callable[[np.ndarray, float], np.ndarray]


def in_box(
    lower: Sequence[float], upper: Sequence[float], x: np.ndarray, *, h: float
) -> np.ndarray:
    """Return whether each point lies in a box or on a side of it, shape (n,).

    Points on a side that two boxes share are in both: round-off decides nothing.

    Parameters
    ----------
    lower, upper : corners of the box (m), one number per axis.
    x : points (m), shape (3, n).
    h : edge of the cells (m), which sets how near to a side a point counts as on it.
    """
    slack, bounds = SAME * h, zip(x, lower, upper, strict=False)
    return np.all([(c >= low - slack) & (c <= high + slack) for c, low, high in bounds], axis=0)


@dataclass(frozen=True, eq=False)
class Sample:
    """Sample of places in a body.

    Attributes
    ----------
    x : places (m), shape (3, n).
    weight : part of the body that each place stands for, shape (n,); None if all are equal.
    """

    x: np.ndarray
    weight: np.ndarray | None = None

    def mean(self, values: np.ndarray) -> float:
        """Return the mean over the body of values at the places, shape (n,)."""
        return float(np.average(values, weights=self.weight))


class Places(Protocol):
    """Protocol of the places of a body that are sampled."""

    def within(self, region: str | None = None) -> Sample:
        """Return places inside of the body, or of one of its regions; at least one."""

    def on(self, face: str | None = None) -> np.ndarray:
        """Return places of the body with its surface, or of one face (m), shape (3, n)."""


@dataclass(frozen=True, kw_only=True)
class BoxGrid:
    """Places of a body that is made of boxes, or cut out of them by a shape.

    Attributes
    ----------
    boxes : region, lower and upper corner (m) of each box.
    flat : axis and position (m) of each flat face, by its name.
    contains : returns whether points, shape (3, n), are in the shape and in its cells of edge h,
        which cut round faces short; None if the boxes are the body.
    h : edge of the cells (m).
    """

    boxes: tuple[tuple[str, Bounds], ...]
    flat: Mapping[str, tuple[int, float]]
    contains: Contains | None = None
    h: float = 0.0

    def within(self, region: str | None = None) -> Sample:
        """See `Places`: middles of a grid in each box."""
        boxes = [box for name, box in self.boxes if region in (None, name)]
        found = [self._kept(_middles(*box), self.h) for box in boxes]
        if len(boxes) == 1:
            return Sample(found[0])
        # Each grid has as many places, whatever the size of its box.
        sizes = [float(np.prod(np.subtract(upper, lower))) for lower, upper in boxes]
        weight = np.repeat(sizes, [x.shape[1] for x in found])
        return Sample(np.hstack(found), weight)

    def on(self, face: str | None = None) -> np.ndarray:
        """See `Places`: a grid in each box, ends included; on a round face all of it."""
        plane = self.flat.get(face) if face is not None else None
        return self._kept(np.hstack([_ends(*box, plane) for _, box in self.boxes]), 0.0)

    def _kept(self, x: np.ndarray, h: float) -> np.ndarray:
        return x if self.contains is None else x[:, self.contains(x, h)]


@dataclass(frozen=True, kw_only=True)
class OfMesh:
    """Places of a mesh.

    Attributes
    ----------
    cells : middles of some cells.
    regions : middles of some cells of each region.
    vertices : some vertices (m), shape (3, n).
    faces : some vertices of each face (m), shape (3, n).
    """

    cells: Sample
    regions: Mapping[str, Sample]
    vertices: np.ndarray
    faces: Mapping[str, np.ndarray]

    def within(self, region: str | None = None) -> Sample:
        """See `Places`."""
        return self.regions[region] if region else self.cells

    def on(self, face: str | None = None) -> np.ndarray:
        """See `Places`."""
        return self.faces[face] if face else self.vertices


def some(n: int) -> np.ndarray:
    """Choose at most `MOST` of the numbers 0 ... n - 1 at random, the same each time."""
    if n <= MOST:
        return np.arange(n)
    return np.sort(np.random.default_rng(0).choice(n, MOST, replace=False))


def as_space_points(x: np.ndarray) -> np.ndarray:
    """Return points of 2-D or 3-D, shape (n, dim), as points of space: shape (3, n)."""
    return np.vstack([x.T, np.zeros((3 - x.shape[1], len(x)))])


def _middles(lower: tuple[float, ...], upper: tuple[float, ...]) -> np.ndarray:
    steps = (np.arange(ALONG) + 0.5) / ALONG
    return _grid([low + steps * (up - low) for low, up in zip(lower, upper, strict=True)])


def _ends(
    lower: tuple[float, ...], upper: tuple[float, ...], plane: tuple[int, float] | None
) -> np.ndarray:
    along = [np.linspace(*ends, ALONG) for ends in zip(lower, upper, strict=True)]
    if plane is not None:
        along[plane[0]] = np.array([plane[1]])
    return _grid(along)


def _grid(along: list[np.ndarray]) -> np.ndarray:
    return as_space_points(np.array([x.ravel() for x in np.meshgrid(*along)]).T)
