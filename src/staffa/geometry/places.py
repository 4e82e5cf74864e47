"""Places in a body at which what varies is looked at before there is a mesh."""

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
    """Which points x, shape (3, n), lie between two corners (m), or on a side: shape (n,).

    h: edge of the cells (m), which says how near to a side a point is on it. Points on a side that
    two boxes share are in both: round-off decides nothing.
    """
    slack, bounds = SAME * h, zip(x, lower, upper, strict=False)
    return np.all([(c >= low - slack) & (c <= high + slack) for c, low, high in bounds], axis=0)


@dataclass(frozen=True, eq=False)
class Sample:
    """Places x, shape (3, n) (m), and how much of the body each stands for, shape (n,); None if all
    stand for as much."""

    x: np.ndarray
    weight: np.ndarray | None = None

    def mean(self, values: np.ndarray) -> float:
        """Of values at the places, over the body."""
        return float(np.average(values, weights=self.weight))


class Places(Protocol):
    """Where to look."""

    def within(self, region: str | None = None) -> Sample:
        """Places inside of the body, or of one of its regions; at least one."""

    def on(self, face: str | None = None) -> np.ndarray:
        """Places all over the body, its surface included, or on a face of it; shape (3, n)."""


@dataclass(frozen=True, kw_only=True)
class BoxGrid:
    """Of a body that is made of boxes, or of what a shape leaves of them.

    boxes: region, lower and upper corner of each. flat: axis and position of the faces that are
    flat. contains: which points, shape (3, n), the shape holds, and cells of edge h do too, which
    cut its round faces short; None for all. h: that edge (m).
    """

    boxes: tuple[tuple[str, Bounds], ...]
    flat: Mapping[str, tuple[int, float]]
    contains: Contains | None = None
    h: float = 0.0

    def within(self, region: str | None = None) -> Sample:
        """As the protocol has it: middles of a grid in each box."""
        boxes = [box for name, box in self.boxes if region in (None, name)]
        found = [self._kept(_middles(*box), self.h) for box in boxes]
        if len(boxes) == 1:
            return Sample(found[0])
        # Each grid has as many places, whatever the size of its box.
        sizes = [float(np.prod(np.subtract(upper, lower))) for lower, upper in boxes]
        weight = np.repeat(sizes, [x.shape[1] for x in found])
        return Sample(np.hstack(found), weight)

    def on(self, face: str | None = None) -> np.ndarray:
        """As the protocol has it: a grid in each box, ends included; on a round face all of it."""
        plane = self.flat.get(face) if face is not None else None
        return self._kept(np.hstack([_ends(*box, plane) for _, box in self.boxes]), 0.0)

    def _kept(self, x: np.ndarray, h: float) -> np.ndarray:
        return x if self.contains is None else x[:, self.contains(x, h)]


@dataclass(frozen=True, kw_only=True)
class OfMesh:
    """Of a mesh: middles of some cells and of each region's, vertices and those of each face."""

    cells: Sample
    regions: Mapping[str, Sample]
    vertices: np.ndarray
    faces: Mapping[str, np.ndarray]

    def within(self, region: str | None = None) -> Sample:
        """As the protocol has it."""
        return self.regions[region] if region else self.cells

    def on(self, face: str | None = None) -> np.ndarray:
        """As the protocol has it."""
        return self.faces[face] if face else self.vertices


def some(n: int) -> np.ndarray:
    """The numbers of at most so many of n things, by chance, the same each time."""
    if n <= MOST:
        return np.arange(n)
    return np.sort(np.random.default_rng(0).choice(n, MOST, replace=False))


def as_space_points(x: np.ndarray) -> np.ndarray:
    """Points of 2-D or 3-D, shape (n, dim), as points of space: shape (3, n)."""
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
