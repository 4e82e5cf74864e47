"""Triangles and tetrahedra of a block that favor no direction, made by Gmsh, as plain arrays."""

from typing import Any

import numpy as np

from staffa.errors import StaffaError
from staffa.geometry.gmsh_model import SIMPLEX, generate, missing, open_gmsh
from staffa.geometry.places import SAME

BLOCK, OTHERWISE = 'domain.cells = "unstructured"', "leave domain.cells out"
MISSING = missing(BLOCK, OTHERWISE)


def unstructured(size: tuple[float, ...], h: float) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, dim) and cells (m, dim + 1) of a rectangle or a box.

    The lower corner is at the origin.

    Parameters
    ----------
    size : extent along each axis (m).
    h : mean edge of the cells (m).

    Raises
    ------
    InputError
        Gmsh is not installed, or cannot be loaded.
    StaffaError
        Gmsh made no mesh.
    """
    dim = len(size)
    with open_gmsh(BLOCK, OTHERWISE) as gmsh:
        try:
            # In cells: Gmsh has absolute tolerances, which do not suit a body of micrometers; and
            # rounded, so that 30 um and 0.03 mm give the same mesh.
            x, cells = _meshed(gmsh, [round(length / h, 9) for length in size])
        except Exception as error:  # Gmsh raises this very class
            raise StaffaError(
                f"{BLOCK}: Gmsh made no mesh with domain.h = {h:g} ({error}); take another domain.h"
            ) from error
    x = h * x[:, :dim]
    for axis, length in enumerate(size):  # on the sides exactly
        x[np.abs(x[:, axis]) <= SAME * length, axis] = 0.0
        x[np.abs(x[:, axis] - length) <= SAME * length, axis] = length
    return x, cells


def _meshed(gmsh: Any, size: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Return points (n, 3), cells (m, dim + 1), with lengths counted in h."""
    dim, shape = len(size), gmsh.model.occ
    add = shape.addRectangle if dim == 2 else shape.addBox
    add(0.0, 0.0, 0.0, *size)
    shape.synchronize()
    generate(gmsh, dim)
    tags, x, _ = gmsh.model.mesh.getNodes()
    _, nodes = gmsh.model.mesh.getElementsByType(SIMPLEX[dim])
    order = np.argsort(tags)
    cells = np.searchsorted(tags[order], nodes).reshape(-1, dim + 1)
    return x.reshape(-1, 3)[order], cells.astype(np.int64)
