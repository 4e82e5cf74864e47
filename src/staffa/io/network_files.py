"""A crack network as a VTP file, which VTK's tools read."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from staffa.io.own_files import write_aside


def write_vtp(
    path: Path,
    points: np.ndarray,
    cells: Sequence[np.ndarray],
    *,
    surface: bool,
    at_points: Mapping[str, np.ndarray],
    on_cells: Mapping[str, np.ndarray],
) -> None:
    """Write polylines, or the triangles of a surface, atomically.

    Parameters
    ----------
    path : the file.
    points : coordinates (m), shape (n, 3).
    cells : numbers of the points of each line or triangle.
    surface : True for triangles.
    at_points : values at the points by name, shape (n, ...).
    on_cells : values of the lines or triangles by name, shape (m, ...).
    """
    import pyvista
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    mesh = pyvista.PolyData()
    if len(cells):
        rows = np.concatenate([np.insert(cell, 0, len(cell)) for cell in cells])
        mesh = pyvista.PolyData(points, **{"faces" if surface else "lines": rows})
    for name, values in at_points.items():
        mesh.point_data[name] = values
    for name, values in on_cells.items():
        mesh.cell_data[name] = values
    writer = vtkXMLPolyDataWriter()
    writer.SetInputData(mesh)
    writer.SetDataModeToBinary()  # as text, in base64
    writer.WriteToOutputStringOn()  # VTK ends the process on a full disk
    writer.Write()
    write_aside(path, writer.GetOutputString())
