"""Fields in files, each on its mesh: read once, and evaluated at any points."""

import hashlib
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from staffa.backend.guarded_reading import read_apart
from staffa.backend.one_file import require_alone
from staffa.errors import InputError, choices
from staffa.properties.mesh_parts import MeshParts
from staffa.properties.point_table import table_mesh

if TYPE_CHECKING:
    from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid

MANY = 30  # more cells than can meet in a body that is smaller than each of them
# Files that name no others, in which numbers might be that a run does not keep.
FORMATS = (".vtu", ".vti", ".vtr", ".vts", ".vtk", ".vtkhdf", ".csv")


@dataclass(frozen=True, kw_only=True)
class MeshField:
    """A field with its mesh; it can be sent to other ranks.

    Attributes
    ----------
    points : vertices of the mesh (m), shape (n, 3).
    cells, types : cells of the mesh, as VTK stores them.
    values : one value a point, or one a cell.
    per_cell : True if `values` has one value a cell.
    digest : fingerprint; two fields of one digest are the same.
    path : file from which the field was read.
    slack : distance from the mesh (m) within which a point has the value of the nearest place.
    """

    points: np.ndarray = field(compare=False, repr=False)
    cells: np.ndarray = field(compare=False, repr=False)
    types: np.ndarray = field(compare=False, repr=False)
    values: np.ndarray = field(compare=False, repr=False)
    per_cell: bool
    digest: str
    path: Path = field(compare=False)
    slack: float = 0.0

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Interpolate at points x, shape (3, n), linear within each cell; NaN outside."""
        from staffa.properties.vtk_mesh import values_at  # few cases need it

        if x.shape[1] == 0:
            return np.zeros(0)
        mesh, places = self._mesh(), np.ascontiguousarray(x.T, dtype=float)
        values = values_at(mesh, self.values, places, per_cell=self.per_cell)
        outside = np.isnan(values)
        if self.slack and outside.any():
            values[outside] = self._beside(mesh, places[outside])
        return values

    def reaching(self, slack: float) -> "MeshField":
        """Return the same with this slack (m)."""
        return replace(self, slack=slack)

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the corners of the box around its mesh (m), shape (3,) each."""
        return self.points.min(axis=0), self.points.max(axis=0)

    def cells_around(self, x: np.ndarray) -> np.ndarray | None:
        """Return the least extent (m) along each axis of the cells around these points, shape (3,).

        None if the points lie in many cells, or beside all.
        """
        from staffa.properties.vtk_mesh import cell_points, cells_at

        mesh = self._mesh()
        found = np.unique(cells_at(mesh, np.ascontiguousarray(x.T, dtype=float)))
        if len(found) > MANY or found.min() < 0:
            return None
        extents = [np.ptp(cell_points(mesh, int(k)), axis=0) for k in found]
        return np.asarray(np.min(extents, axis=0))

    def _mesh(self) -> "vtkUnstructuredGrid":
        from staffa.properties.vtk_mesh import made_mesh

        return made_mesh(self.points, self.cells, self.types)

    def _beside(self, mesh: "vtkUnstructuredGrid", places: np.ndarray) -> np.ndarray:
        """Return values at the nearest places of the mesh, NaN beyond slack; places: (n, 3)."""
        from staffa.properties.vtk_mesh import nearest_places

        cells, nearest = nearest_places(mesh, places)
        values = np.full(len(places), np.nan)
        near = np.linalg.norm(nearest - places, axis=1) <= self.slack
        for k in np.flatnonzero(near & (cells >= 0)):
            values[k] = self._in_cell(mesh, int(cells[k]), nearest[k])
        return values

    def _in_cell(self, mesh: "vtkUnstructuredGrid", number: int, place: np.ndarray) -> float:
        """Return the value in a cell at a place of it."""
        from staffa.properties.vtk_mesh import weights_in_cell

        if self.per_cell:
            return float(self.values[number])
        ids, weights = weights_in_cell(mesh, number, place)
        return float(np.dot(weights, self.values[ids]))


@dataclass(frozen=True, kw_only=True)
class Counting:
    """Units of a file, in SI or scaled as the case is.

    Attributes
    ----------
    length : length of 1 in the file's coordinates (m).
    zero, one : quantities that the values 0 and 1 of the file stand for.
    component : component of a vector, None for a scalar.
    """

    length: float = 1.0
    zero: float = 0.0
    one: float = 1.0
    component: int | None = None


def read_field(path: Path, name: str, counting: Counting | None = None) -> MeshField:
    """Read a field from a file of one of FORMATS, in a separate process.

    Parameters
    ----------
    path : the file.
    name : name of the field in the file.
    counting : units of the file and component of the field; None for the defaults.

    Raises
    ------
    InputError
        There is no such file or field, or it is not one finite number at each place; or reading it
        crashes.
    """
    require_field_file(path)
    asked = [name, asdict(counting or Counting())]
    return read_apart(
        MeshField, "staffa.properties.mesh_field:field_in", path, asked, where=str(path)
    )


def require_field_file(path: Path) -> None:
    """Require a file that is there, of one of FORMATS."""
    if path.suffix.lower() not in FORMATS:
        raise InputError(
            f"{path} is none of {', '.join(FORMATS)}, each of which is one file, of which a run "
            f"keeps a copy; write the field as one .vtu"
        )
    if not path.is_file():
        raise InputError(f"there is no file {path}; a path counts from the folder of the case file")


def field_in(path: Path, name: str, counted: dict[str, Any]) -> MeshField:
    """Read a field as `read_field`, in this process.

    Parameters
    ----------
    path : the file.
    name : name of the field in the file.
    counted : the fields of a `Counting`, by name.
    """
    if path.suffix.lower() == ".vtkhdf":
        require_alone(path, str(path))
    mesh, counting = _mesh(path), Counting(**counted)
    found = mesh.in_cells | mesh.at_points
    if name not in found:
        held = choices(name, found) if found else "it has none"
        raise InputError(f"the file has no field '{name}'; {held}")
    values = _numbers(found[name], name, counting.component)
    if not np.all(np.isfinite(values)):
        raise InputError(f"'{name}' is not finite everywhere; correct the file")
    per_cell = name not in mesh.at_points
    return _field(mesh, values.astype(float), counting, per_cell=per_cell, path=path)


def _numbers(values: np.ndarray, name: str, component: int | None) -> np.ndarray:
    """Return one number at each place, of a vector one of its components."""
    if values.dtype.kind in "fiu" and component is not None:
        if values.ndim == 2 and component < values.shape[1]:
            return values[:, component]
        raise InputError(f"'{name}' has no such component; name a vector, or leave component out")
    if values.ndim != 1 or values.dtype.kind not in "fiu":
        raise InputError(f"'{name}' is not one number at each place; name a field that is")
    return values


def _field(
    mesh: MeshParts, values: np.ndarray, counting: Counting, *, per_cell: bool, path: Path
) -> MeshField:
    scaled = values if counting.one == 1 and counting.zero == 0 else _counted(values, counting)
    arrays: dict[str, Any] = {
        "points": counting.length * np.asarray(mesh.points, dtype=float),
        "cells": mesh.cells,
        "types": mesh.types,
        "values": scaled,
    }
    digest = hashlib.sha256(b"".join(a.tobytes() for a in arrays.values())).hexdigest()
    return MeshField(**arrays, per_cell=per_cell, digest=digest, path=path)


def _counted(values: np.ndarray, counting: Counting) -> np.ndarray:
    return counting.zero + (counting.one - counting.zero) * values


def _mesh(path: Path) -> MeshParts:
    if path.suffix.lower() == ".csv":
        return table_mesh(path)
    from staffa.properties.vtk_mesh import mesh_in

    mesh = mesh_in(path)
    if mesh is None:
        raise InputError(
            f"{path} holds no mesh that can be read; write it with ParaView or meshio, as .vtu"
        )
    return mesh
