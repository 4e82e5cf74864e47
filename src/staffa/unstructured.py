"""Triangles and tetrahedra of a block that favor no direction, made by Gmsh, as plain arrays."""

from typing import Any

import numpy as np

from staffa.errors import StaffaError
from staffa.with_gmsh import SIMPLEX, missing, opened

# Gmsh's plain Delaunay refinement, in 2-D and on the faces of a box. How well its edges spread over
# the directions theta, as |mean exp(i k theta)| over all 20,000 of 2 x 1 with h = 0.02 (0 without
# any order), and over those in each square of 6 h:
#     algorithm             k = 4   k = 6   k = 6, in 6 h   mean quality   mean edge
#     5, Delaunay           0.01    0.02    0.18            0.95           0.95 h
#     1, MeshAdapt          0.02    0.13    0.27            0.96           0.98 h
#     6, Frontal-Delaunay   0.00    0.94    0.94            1.00           1.00 h
#     9, packing            0.16    0.20    0.49            0.92           1.10 h
# Frontal-Delaunay makes one crystal along the sides; four triangles to a square have 0.33, k = 4.
PLANE, SOLID = 5, 1
# Asked for edges of this times h, Gmsh makes them h long in the mean, within 5 %.
ASKED = {2: 1.0, 3: 0.8}
BLOCK, OTHERWISE = 'domain.cells = "unstructured"', "leave domain.cells out"
MISSING = missing(BLOCK, OTHERWISE)


def unstructured(size: tuple[float, ...], h: float) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, dim) and cells (m, dim + 1) of a rectangle or a box, lower corner at the origin.

    size: extent along each axis (m). h: mean edge of the cells (m).

    Raises
    ------
    InputError
        Gmsh is not installed, or cannot be loaded.
    StaffaError
        Gmsh made no mesh.
    """
    dim = len(size)
    with opened(BLOCK, OTHERWISE) as gmsh:
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
        x[np.abs(x[:, axis]) <= 1e-9 * length, axis] = 0.0
        x[np.abs(x[:, axis] - length) <= 1e-9 * length, axis] = length
    return x, cells


def _meshed(gmsh: Any, size: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3), cells (m, dim + 1), with lengths counted in h."""
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


def generate(gmsh: Any, dim: int) -> None:
    """Mesh what is modelled with lengths counted in h."""
    gmsh.option.setNumber("Mesh.Algorithm", PLANE)
    gmsh.option.setNumber("Mesh.Algorithm3D", SOLID)
    gmsh.option.setNumber("Mesh.ElementOrder", 1)
    for end in ("Min", "Max"):
        gmsh.option.setNumber(f"Mesh.MeshSize{end}", ASKED[dim])
    gmsh.model.mesh.generate(dim)
