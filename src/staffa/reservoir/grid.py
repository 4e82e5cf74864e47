"""Cartesian grid of a reservoir, and the way from its cells to the vertices of the rock."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np


@dataclass(frozen=True, kw_only=True)
class Grid:
    """Cartesian cells, the first axis fastest. In 2-D the last axis has one cell of the thickness.

    Attributes
    ----------
    edges : coordinates of the faces of cells along x, y and z (m), each increasing.
    dim : dimension of the rock, 2 or 3.
    """

    edges: tuple[np.ndarray, np.ndarray, np.ndarray]
    dim: int

    @property
    def shape(self) -> tuple[int, int, int]:
        """Number of cells along each axis."""
        x, y, z = (len(edges) - 1 for edges in self.edges)
        return x, y, z

    @property
    def size(self) -> int:
        """Number of cells."""
        return int(np.prod(self.shape))

    @cached_property
    def sizes(self) -> np.ndarray:
        """Edge lengths of each cell (m), shape (size, 3)."""
        return _product([np.diff(edges) for edges in self.edges])

    @cached_property
    def centers(self) -> np.ndarray:
        """Center of each cell (m), shape (size, 3)."""
        return _product([(edges[1:] + edges[:-1]) / 2 for edges in self.edges])

    @cached_property
    def volumes(self) -> np.ndarray:
        """Volume of each cell (m^3), shape (size,)."""
        return np.asarray(self.sizes.prod(axis=1))


def _product(axes: list[np.ndarray]) -> np.ndarray:
    """Return one row for each cell, the first axis fastest."""
    return np.stack([a.ravel(order="F") for a in np.meshgrid(*axes, indexing="ij")], axis=1)
