"""Meshed body for the tracing of its cracks: a pixel grid of its damage, and its surface."""

from typing import Any

import numpy as np
from scipy.ndimage import distance_transform_edt

from staffa.geometry.places import SAME

# Largest distance outside the body, over the mesh size, that is round-off.
OUTSIDE = 1e-6
# VTK's cell types, by dimension and number of vertices.
TYPES = {(2, 3): 5, (2, 4): 9, (3, 4): 10, (3, 8): 12}


class Body:
    """Mesh sorted by position, since the order in its file depends on the number of ranks.

    Attributes
    ----------
    points : coordinates (m), shape (n, 3).
    cells : vertices of each cell in VTK's order, shape (m, vertices).
    dim : 2 or 3.
    h : mesh size (m).
    vertices : given number of each point, in the order of the body, shape (n,).
    members : given number of each cell, in the order of the body, shape (m,).
    """

    def __init__(self, points: np.ndarray, cells: np.ndarray, *, dim: int, h: float) -> None:
        """Sort a mesh by position.

        Parameters
        ----------
        points : coordinates (m), shape (n, 3).
        cells : vertices of each cell in VTK's order, shape (m, vertices).
        dim : 2 or 3.
        h : mesh size (m).
        """
        import pyvista

        self.dim, self.h = dim, h
        self.vertices = np.lexsort(np.rint(points / (SAME * h)).T)
        number = np.empty_like(self.vertices)
        number[self.vertices] = np.arange(len(points))
        cells = number[cells]
        self.members = np.lexsort(np.sort(cells, axis=1).T)
        self.points, self.cells = points[self.vertices], cells[self.members]
        kind = TYPES[dim, cells.shape[1]]
        self._mesh: Any = pyvista.UnstructuredGrid({kind: self.cells}, self.points)
        self._fills_its_box = False

    def raster(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Sample a field on a pixel grid over the body, with edges of about h.

        Outside the body, in holes too, the value is that of the nearest point inside.

        Parameters
        ----------
        values : field at the points of the body, shape (n,).

        Returns
        -------
        lower : lower corner of the grid (m), shape (3,).
        edge : edges of the grid (m), shape (3,).
        field : values on the grid, shape (n_x, n_y) or (n_x, n_y, n_z).
        """
        import pyvista

        # Slightly inside the body: else round-off would decide which points are inside.
        within = np.array([OUTSIDE * self.h] * self.dim + [0.0] * (3 - self.dim))
        lower, upper = self.points.min(axis=0) + within, self.points.max(axis=0) - within
        counts = np.maximum(np.rint((upper - lower) / self.h).astype(int), 1)
        counts[self.dim :] = 0
        edge = (upper - lower) / np.maximum(counts, 1)
        image = pyvista.ImageData(dimensions=counts + 1, spacing=np.where(edge > 0, edge, 1.0))
        image.origin = lower
        self._mesh["values"] = values
        probed: Any = image.sample(self._mesh)
        shape = tuple(counts[: self.dim] + 1)
        field = np.asarray(probed["values"]).reshape(shape, order="F")
        inside = np.asarray(probed["vtkValidPointMask"]).reshape(shape, order="F").astype(bool)
        self._fills_its_box = bool(inside.all())
        if not self._fills_its_box:
            nearest = distance_transform_edt(~inside, return_distances=False, return_indices=True)
            field = field[tuple(nearest)]
        return lower, edge, field

    def nearest(self, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the nearest points of the body, (n, 3), and a mask of those that moved, (n,).

        Call it after `raster`, which finds out if any point can lie outside.
        """
        if self._fills_its_box or not len(places):
            return places, np.zeros(len(places), dtype=bool)
        _, found = self._mesh.find_closest_cell(places, return_closest_point=True)
        found = np.atleast_2d(found)
        outside = np.linalg.norm(found - places, axis=1) > OUTSIDE * self.h
        return np.where(outside[:, None], found, places), outside
