"""A mesh with its fields as arrays, however it was read."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, kw_only=True)
class MeshParts:
    """A mesh and the fields on it.

    Attributes
    ----------
    points : vertices of the mesh, shape (n, 3).
    cells, types : cells of the mesh, as VTK stores them: of each cell the number of its vertices
        and their numbers, all in one row; and the number of its kind.
    at_points, in_cells : fields by their names, one value or vector a point, or a cell.
    """

    points: np.ndarray
    cells: np.ndarray
    types: np.ndarray
    at_points: dict[str, np.ndarray]
    in_cells: dict[str, np.ndarray]
