"""Fields in files on meshes of their own: read once, and evaluated at any points."""

import hashlib
import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from staffa.errors import InputError, choices

SPREAD = (".pvd", ".pvtu", ".vtm", ".xdmf")  # files that name others, in which the numbers are


@dataclass(frozen=True, kw_only=True)
class MeshField:
    """A field on a mesh of its own; it can be sent to other ranks.

    points: shape (n, 3) (m); cells, types: as VTK stores them; values: one a point, or one a cell
    if per_cell. digest: two fields of one digest are the same. path: where it was read.
    """

    points: np.ndarray = field(compare=False, repr=False)
    cells: np.ndarray = field(compare=False, repr=False)
    types: np.ndarray = field(compare=False, repr=False)
    values: np.ndarray = field(compare=False, repr=False)
    per_cell: bool
    digest: str
    path: Path = field(compare=False)

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Interpolated at points x, shape (3, n), straight within each cell; NaN outside."""
        import pyvista  # takes seconds to load, and few cases need it

        if x.shape[1] == 0:
            return np.zeros(0)
        mesh = pyvista.UnstructuredGrid(self.cells, self.types, self.points)
        (mesh.cell_data if self.per_cell else mesh.point_data)["value"] = self.values
        found = pyvista.PolyData(np.ascontiguousarray(x.T, dtype=float)).sample(mesh)
        inside = np.asarray(found["vtkValidPointMask"], dtype=bool)
        return np.where(inside, np.asarray(found["value"], dtype=float), np.nan)


def read_field(path: Path, name: str) -> MeshField:
    """The field of this name in a file that PyVista reads: .vtu, .vtk, .vtkhdf.

    Raises
    ------
    InputError
        There is no such file or field, or it is not one finite number at each place.
    """
    mesh = _mesh(path)
    found = dict(mesh.cell_data.items()) | dict(mesh.point_data.items())
    if name not in found:
        held = choices(name, found) if found else "it has none"
        raise InputError(f"the file has no field '{name}'; {held}")
    values = np.asarray(found[name])
    if values.ndim != 1 or values.dtype.kind not in "fiu":
        raise InputError(f"'{name}' is not one number at each place; name a field that is")
    if not np.all(np.isfinite(values)):
        raise InputError(f"'{name}' is not finite everywhere; mend the file")
    per_cell = name not in dict(mesh.point_data.items())
    return _field(mesh, values.astype(float), per_cell=per_cell, path=path)


def _field(mesh: Any, values: np.ndarray, *, per_cell: bool, path: Path) -> MeshField:
    arrays = {
        "points": np.asarray(mesh.points, dtype=float),
        "cells": np.asarray(mesh.cells),
        "types": np.asarray(mesh.celltypes),
        "values": values,
    }
    digest = hashlib.sha256(b"".join(a.tobytes() for a in arrays.values())).hexdigest()
    return MeshField(**arrays, per_cell=per_cell, digest=digest, path=path)


@contextmanager
def _silence() -> Iterator[None]:
    """Within it, VTK and PyVista print and log nothing of what is said in a sentence after it."""
    import pyvista

    before = logging.root.manager.disable
    logging.disable(logging.CRITICAL)
    try:
        with pyvista.vtk_verbosity("off"), warnings.catch_warnings(action="ignore"):
            yield
    finally:
        logging.disable(before)


def _mesh(path: Path) -> Any:
    if path.suffix.lower() in SPREAD:
        raise InputError(
            f"{path} only names other files, and a run keeps one; write the field as one .vtu"
        )
    if not path.is_file():
        raise InputError(f"there is no file {path}; a path counts from the folder of the case file")
    import pyvista

    mesh = None
    with _silence(), suppress(Exception):
        mesh = pyvista.read(path).cast_to_unstructured_grid()
    if mesh is None or mesh.n_cells == 0:
        raise InputError(
            f"{path} holds no mesh that can be read; write it with ParaView or meshio, as .vtu"
        )
    return mesh
