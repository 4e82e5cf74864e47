"""A mesh of simplices with its names as arrays by name, for the parts of checkpoints."""

from collections.abc import Mapping
from urllib.parse import quote, unquote

import numpy as np

from staffa.geometry.simplices import Simplices

POINTS, CELLS = "points", "cells"
NAMED = ("regions", "faces", "cracks")


def mesh_arrays(mesh: Simplices) -> dict[str, np.ndarray]:
    """Return the arrays of a mesh; names are quoted, since "/" would be a folder of HDF5."""
    named = {
        f"{kind} {quote(name, safe='')}": rows
        for kind in NAMED
        for name, rows in getattr(mesh, kind).items()
    }
    x = np.pad(mesh.x, ((0, 0), (0, 3 - mesh.dim)))
    return {POINTS: x, CELLS: mesh.cells, **named}


def mesh_of_arrays(arrays: Mapping[str, np.ndarray]) -> Simplices:
    """Return the mesh that `mesh_arrays` gave."""

    def named(kind: str) -> dict[str, np.ndarray]:
        start = f"{kind} "
        return {
            unquote(key.removeprefix(start)): rows
            for key, rows in arrays.items()
            if key.startswith(start)
        }

    dim = arrays[CELLS].shape[1] - 1
    return Simplices(
        x=np.ascontiguousarray(arrays[POINTS][:, :dim]),
        cells=arrays[CELLS],
        regions=named("regions"),
        faces=named("faces"),
        cracks=named("cracks"),
    )
