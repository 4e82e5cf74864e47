"""Meshes with fields, in VTK's own classes: they load in 0.1 s, and PyVista in 0.4 s.

A check looks into files of fields too, and needs no pictures.
"""

from pathlib import Path

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import reference, vtkDataArray, vtkIdTypeArray, vtkObject, vtkPoints
from vtkmodules.vtkCommonDataModel import (
    vtkCellArray,
    vtkDataSet,
    vtkDataSetAttributes,
    vtkGenericCell,
    vtkImageData,
    vtkPolyData,
    vtkRectilinearGrid,
    vtkStaticCellLocator,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm
from vtkmodules.vtkFiltersCore import vtkAppendFilter, vtkResampleWithDataSet

from staffa.properties.mesh_parts import MeshParts

VALUE, INSIDE = "value", "vtkValidPointMask"  # the latter is VTK's name


def mesh_in(path: Path) -> MeshParts | None:
    """Read a mesh with its fields; None if VTK finds none in the file."""
    mesh = _read(path)
    if mesh is None:
        return None
    cells = vtkIdTypeArray()
    mesh.GetCells().ExportLegacyFormat(cells)
    return MeshParts(
        points=vtk_to_numpy(mesh.GetPoints().GetData()),
        cells=vtk_to_numpy(cells),
        types=vtk_to_numpy(mesh.GetCellTypes()),
        at_points=_fields(mesh.GetPointData()),
        in_cells=_fields(mesh.GetCellData()),
    )


def _read(path: Path) -> vtkUnstructuredGrid | None:
    vtkObject.GlobalWarningDisplayOff()  # a sentence is said in its place
    reader = _reader(path.suffix.lower())
    reader.SetFileName(str(path))
    reader.Update()
    read = reader.GetOutputDataObject(0)
    if not isinstance(read, vtkDataSet) or not read.GetNumberOfCells():
        return None
    cast = vtkAppendFilter()
    cast.AddInputData(read)
    if _is_double(read):  # the filter looks at stored points alone, and these have none
        cast.SetOutputPointsPrecision(vtkAlgorithm.DOUBLE_PRECISION)
    cast.Update()
    mesh = cast.GetOutput()
    corners = vtk_to_numpy(mesh.GetCells().GetConnectivityArray())
    is_whole = corners.size and corners.min() >= 0 and corners.max() < mesh.GetNumberOfPoints()
    return mesh if is_whole else None


def _reader(ending: str) -> vtkAlgorithm:
    """Return the reader of files that end so; each library loads only where a file needs it."""
    if ending == ".vtkhdf":
        from vtkmodules.vtkIOHDF import vtkHDFReader

        return vtkHDFReader()
    if ending == ".vtk":
        from vtkmodules.vtkIOLegacy import vtkDataSetReader

        reader = vtkDataSetReader()
        for kind in (
            "Scalars",
            "ColorScalars",
            "Normals",
            "TCoords",
            "Vectors",
            "Tensors",
            "Fields",
        ):
            getattr(reader, f"ReadAll{kind}On")()
        return reader
    from vtkmodules import vtkIOXML

    kinds = {".vtu": "Unstructured", ".vts": "Structured", ".vtr": "Rectilinear"}
    name = "ImageData" if ending == ".vti" else f"{kinds[ending]}Grid"
    return getattr(vtkIOXML, f"vtkXML{name}Reader")()


def _is_double(read: vtkDataSet) -> bool:
    if isinstance(read, vtkRectilinearGrid):
        axes = (read.GetXCoordinates(), read.GetYCoordinates(), read.GetZCoordinates())
        return any(vtk_to_numpy(axis).dtype == np.float64 for axis in axes)
    return isinstance(read, vtkImageData)


def _fields(data: vtkDataSetAttributes) -> dict[str, np.ndarray]:
    """Return the arrays of a mesh by their names; one of texts is one without numbers."""
    found = {}
    for k in range(data.GetNumberOfArrays()):
        array = data.GetAbstractArray(k)
        numbers = vtk_to_numpy(array) if isinstance(array, vtkDataArray) else np.array([""])
        found[array.GetName() or f"Unnamed_{k}"] = numbers
    return found


def made_mesh(points: np.ndarray, cells: np.ndarray, types: np.ndarray) -> vtkUnstructuredGrid:
    """Return a mesh of these parts, see `MeshParts`."""
    mesh, connected = vtkUnstructuredGrid(), vtkCellArray()
    connected.ImportLegacyFormat(numpy_to_vtkIdTypeArray(cells, deep=True))
    mesh.SetPoints(_points(points))
    mesh.SetCells(numpy_to_vtk(types, deep=True), connected)
    return mesh


def _points(points: np.ndarray) -> vtkPoints:
    made = vtkPoints()
    made.SetData(numpy_to_vtk(np.ascontiguousarray(points, dtype=float), deep=True))
    return made


def values_at(
    mesh: vtkUnstructuredGrid, values: np.ndarray, places: np.ndarray, *, per_cell: bool
) -> np.ndarray:
    """Interpolate a field of a mesh at places; NaN outside.

    Parameters
    ----------
    mesh : the mesh.
    values : one value a point, or one a cell.
    places : points, shape (n, 3).
    per_cell : True if `values` has one value a cell.
    """
    array = numpy_to_vtk(np.ascontiguousarray(values, dtype=float), deep=True)
    array.SetName(VALUE)
    (mesh.GetCellData() if per_cell else mesh.GetPointData()).AddArray(array)
    asked, resample = vtkPolyData(), vtkResampleWithDataSet()
    asked.SetPoints(_points(places))
    resample.SetInputData(asked)
    resample.SetSourceData(mesh)
    resample.SetCellLocator(vtkStaticCellLocator())
    resample.Update()
    found = resample.GetOutput().GetPointData()
    inside = vtk_to_numpy(found.GetArray(INSIDE)).astype(bool)
    return np.where(inside, vtk_to_numpy(found.GetArray(VALUE)), np.nan)


def cells_at(mesh: vtkUnstructuredGrid, places: np.ndarray) -> np.ndarray:
    """Return the numbers of the cells that contain places, shape (n, 3); -1 outside of all."""
    locator = _locator(mesh)
    return np.array([locator.FindCell(place) for place in places])


def nearest_places(mesh: vtkUnstructuredGrid, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the cells nearest to places, shape (n, 3), and the nearest points of them (n, 3)."""
    locator, cell, nearest = _locator(mesh), vtkGenericCell(), np.zeros_like(places)
    cells = np.zeros(len(places), dtype=int)
    for k, place in enumerate(places):
        number, part, far, point = reference(0), reference(0), reference(0.0), [0.0] * 3
        locator.FindClosestPoint(place, point, cell, number, part, far)
        cells[k], nearest[k] = int(number), point
    return cells, nearest


def _locator(mesh: vtkUnstructuredGrid) -> vtkStaticCellLocator:
    locator = vtkStaticCellLocator()
    locator.SetDataSet(mesh)
    locator.BuildLocator()
    return locator


def cell_points(mesh: vtkUnstructuredGrid, number: int) -> np.ndarray:
    """Return the points of a cell, shape (n, 3)."""
    return np.asarray(vtk_to_numpy(mesh.GetCell(number).GetPoints().GetData()))


def weights_in_cell(
    mesh: vtkUnstructuredGrid, number: int, place: np.ndarray
) -> tuple[list[int], list[float]]:
    """Return the points of a cell, and their weights in the interpolation at a place of it."""
    cell = mesh.GetCell(number)
    ids = [cell.GetPointId(i) for i in range(cell.GetNumberOfPoints())]
    weights = [0.0] * len(ids)
    part, far = reference(0), reference(0.0)
    cell.EvaluatePosition(place.tolist(), [0.0] * 3, part, [0.0] * 3, far, weights)
    return ids, weights
