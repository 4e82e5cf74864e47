"""Triangles and tetrahedra of a block that favor no direction, made by Gmsh, as plain arrays."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from staffa.errors import InputError, StaffaError

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
MISSING = (
    'domain.cells = "unstructured" needs Gmsh, which is not installed; install it with pip install '
    "gmsh, or leave domain.cells out"
)
TRIANGLE, TETRAHEDRON = 2, 4  # Gmsh's numbers of its cells
OPTIONS = {
    "General.Terminal": 0,
    # One thread and one seed: the same body gives the same mesh every time.
    "General.NumThreads": 1,
    "Mesh.RandomSeed": 1,
    "Mesh.Algorithm": PLANE,
    "Mesh.Algorithm3D": SOLID,
    "Mesh.ElementOrder": 1,
}


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
    with _gmsh() as gmsh:
        try:
            # In cells: Gmsh has absolute tolerances, which do not suit a body of micrometers; and
            # rounded, so that 30 um and 0.03 mm give the same mesh.
            x, cells = _meshed(gmsh, [round(length / h, 9) for length in size])
        except Exception as error:  # Gmsh raises this very class
            raise StaffaError(
                f'domain.cells = "unstructured": Gmsh made no mesh with domain.h = {h:g} '
                f"({error}); take another domain.h"
            ) from error
    x = h * x[:, :dim]
    for axis, length in enumerate(size):  # on the sides exactly
        x[np.abs(x[:, axis]) <= 1e-9 * length, axis] = 0.0
        x[np.abs(x[:, axis] - length) <= 1e-9 * length, axis] = length
    return x, cells


def _meshed(gmsh: Any, size: list[float]) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3), cells (m, dim + 1), with lengths counted in h."""
    dim, shape = len(size), gmsh.model.occ
    add, cell = (shape.addRectangle, TRIANGLE) if dim == 2 else (shape.addBox, TETRAHEDRON)
    add(0.0, 0.0, 0.0, *size)
    shape.synchronize()
    for end in ("Min", "Max"):
        gmsh.option.setNumber(f"Mesh.MeshSize{end}", ASKED[dim])
    gmsh.model.mesh.generate(dim)
    tags, x, _ = gmsh.model.mesh.getNodes()
    _, nodes = gmsh.model.mesh.getElementsByType(cell)
    order = np.argsort(tags)
    cells = np.searchsorted(tags[order], nodes).reshape(-1, dim + 1)
    return x.reshape(-1, 3)[order], cells.astype(np.int64)


@contextmanager
def _gmsh() -> Iterator[Any]:
    """Gmsh with a model and options of its own; a Gmsh that the caller has open stays open."""
    try:
        import gmsh  # only where it is asked for: the extra `mesh` brings it

        opened = not gmsh.isInitialized()
        if opened:
            gmsh.initialize(readConfigFiles=False, interruptible=False)
    except ImportError as error:
        raise InputError(MISSING) from error
    except (OSError, AttributeError) as error:  # its library, or one that this needs, is missing
        raise InputError(
            f'domain.cells = "unstructured" needs Gmsh, which cannot be loaded ({error}); install '
            f"what that names, or leave domain.cells out"
        ) from error
    try:
        gmsh.model.add("staffa")
        for name, value in OPTIONS.items():
            gmsh.option.setNumber(name, value)
        yield gmsh
    finally:
        gmsh.finalize() if opened else gmsh.model.remove()
