"""Fields on a mesh as one VTKHDF file for ParaView and PyVista; no finite elements.

The format: https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format/, UnstructuredGrid.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from staffa.backend.one_file import require_alone
from staffa.errors import InputError
from staffa.io.own_files import write_aside

# VTK's cell types (vtkCellType.h) and their number of vertices.
VERTICES = {5: 3, 9: 4, 10: 4, 12: 8}
DENSEST = 1100  # largest factor by which gzip makes them smaller


@dataclass(frozen=True, kw_only=True)
class VtkMesh:
    """Mesh of one cell type.

    Attributes
    ----------
    points : coordinates (m), shape (n, 3).
    cells : vertices of each cell in VTK's order, shape (m, vertices).
    type : VTK's number of the cell type.
    """

    points: np.ndarray
    cells: np.ndarray
    type: int


def write_vtkhdf(
    path: Path,
    grid: VtkMesh,
    fields: Mapping[str, np.ndarray],
    in_cells: Mapping[str, np.ndarray] | None = None,
) -> None:
    """Write values at points and in cells, atomically.

    Parameters
    ----------
    path : the file.
    grid : the mesh.
    fields : values at points by name, shape (n,) or (n, components).
    in_cells : values in cells by name, shape (m,) or (m, components).
    """
    # In memory first: on a disk that is full HDF5 breaks off in the middle, and is of no use then.
    with h5py.File(path.name, "w", driver="core", backing_store=False) as file:
        _fill(file.create_group("VTKHDF"), grid, fields, in_cells or {})
        file.flush()
        content = file.id.get_file_image()
    write_aside(path, content)


def _fill(
    root: h5py.Group,
    grid: VtkMesh,
    fields: Mapping[str, np.ndarray],
    in_cells: Mapping[str, np.ndarray],
) -> None:
    n_cells, width = grid.cells.shape
    root.attrs["Version"] = np.array([1, 0])  # all that is used here; older readers take it
    kind = b"UnstructuredGrid"
    root.attrs.create("Type", kind, dtype=h5py.string_dtype("ascii", len(kind)))
    root["NumberOfPoints"] = np.array([len(grid.points)])
    root["NumberOfCells"] = np.array([n_cells])
    root["NumberOfConnectivityIds"] = np.array([n_cells * width])
    _put(root, "Points", grid.points)
    _put(root, "Connectivity", grid.cells.ravel().astype(np.int64))
    _put(root, "Offsets", np.arange(0, n_cells * width + 1, width))
    _put(root, "Types", np.full(n_cells, grid.type, dtype=np.uint8))
    data = root.create_group("PointData")
    for name, values in fields.items():
        _put(data, name, values)
    if in_cells:
        data = root.create_group("CellData")
        for name, values in in_cells.items():
            _put(data, name, values)


def _put(group: h5py.Group, name: str, values: np.ndarray) -> None:
    # Level 1 halves a file of fields; higher levels gain little and take long.
    group.create_dataset(name, data=values, compression="gzip", compression_opts=1)


def read_vtkhdf(path: Path) -> tuple[VtkMesh, dict[str, np.ndarray]]:
    """The mesh and the values, of points and of cells, of a file that `write_vtkhdf` wrote.

    Raises
    ------
    OSError, KeyError, ValueError, IndexError
        It is none: also where it shows what is in another file, or where that would crash what
        draws it.
    """
    if path.exists() and not path.is_file():  # a pipe would be waited for
        raise ValueError("it is no ordinary file")
    try:
        require_alone(path, "it")
    except InputError as error:
        raise ValueError(str(error).removeprefix("it: ")) from None
    with h5py.File(path, "r") as file:
        root = file["VTKHDF"]
        _is_of_sense(root, path.stat().st_size)
        kind = int(root["Types"][0])
        grid = VtkMesh(
            points=root["Points"][:],
            cells=root["Connectivity"][:].reshape(-1, VERTICES[kind]),
            type=kind,
        )
        values = {name: of[:] for name, of in root["PointData"].items()}
        in_cells = {name: of[:] for name, of in root.get("CellData", {}).items()}
    _is_whole(grid, values, in_cells)
    return grid, values | in_cells


def _is_of_sense(root: h5py.Group, size: int) -> None:
    """Refuse numbers that take more memory than a file of this size can hold."""
    sets = [root["Points"], root["Connectivity"], root["Types"]]
    sets += [*root["PointData"].values(), *root.get("CellData", {}).values()]
    if not all(isinstance(one, h5py.Dataset) and one.dtype.kind in "fiu" for one in sets):
        raise ValueError("it holds other things than numbers")
    if any(one.nbytes > DENSEST * size for one in sets):
        raise ValueError("it tells of more numbers than it can hold")


def _is_whole(
    grid: VtkMesh, values: Mapping[str, np.ndarray], in_cells: Mapping[str, np.ndarray]
) -> None:
    """Its cells are of its points, and each of both has its values."""
    n, cells = len(grid.points), grid.cells
    if grid.points.shape != (n, 3) or not len(cells) or not np.all(np.isfinite(grid.points)):
        raise ValueError("it has no points with three coordinates, or no cells")
    if cells.dtype.kind not in "iu" or cells.min() < 0 or cells.max() >= n:
        raise ValueError("its cells have corners that are not there")
    counts = [(of, n) for of in values.values()] + [(of, len(cells)) for of in in_cells.values()]
    if any(len(of) != count for of, count in counts):
        raise ValueError("it has not one value at each place")
