"""Tables of points in CSV files, as meshes: neighbors are joined by triangles or tetrahedra."""

import csv
from pathlib import Path

import numpy as np
import scipy

from staffa.errors import InputError
from staffa.properties.mesh_parts import MeshParts

# Names of the coordinates; the later ones are ParaView's.
COORDINATES = (("x", "Points:0", "Points_0"), ("y", "Points:1", "Points_1"))
HEIGHTS = ("z", "Points:2", "Points_2")
TABLE = (
    "its first line names the columns, x, y (and z) and the fields, with commas between; each "
    "other line has as many numbers"
)
SLIVER = 1e-9  # part of the box around the points below which a cell has no volume
TRIANGLE, TETRAHEDRON = 5, 10  # as VTK counts cells


def table_mesh(path: Path) -> MeshParts:
    """Return the points of a table as a mesh, with its other columns as fields.

    The points are joined by Delaunay's triangulation, so that values are linear between them.

    Raises
    ------
    InputError
        It is no such table, or its points lie on a line.
    """
    columns = _columns(path)
    points = _points(path, columns)
    cells = _joined(path, points)
    corners = cells.shape[1]
    return MeshParts(
        points=points,
        cells=np.insert(cells, 0, corners, axis=1).astype(np.int64).ravel(),
        types=np.full(len(cells), TRIANGLE if corners == 3 else TETRAHEDRON, dtype=np.uint8),
        at_points=columns,
        in_cells={},
    )


def _columns(path: Path) -> dict[str, np.ndarray]:
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            names = [name.strip() for name in next(csv.reader(file), [])]
            values = np.loadtxt(file, delimiter=",", ndmin=2)
    except (ValueError, UnicodeDecodeError, csv.Error):
        raise InputError(f"{path} is no table of points; {TABLE}") from None
    if len(set(names)) != len(names) or values.shape[1:] != (len(names),) or not values.size:
        raise InputError(f"{path} is no table of points; {TABLE}")
    return dict(zip(names, values.T.copy(), strict=True))


def _points(path: Path, columns: dict[str, np.ndarray]) -> np.ndarray:
    """Return the coordinates, shape (n, 3), and take them out of the columns."""
    found = [_taken(columns, names) for names in (*COORDINATES, HEIGHTS)]
    x, y, z = found
    if x is None or y is None:
        raise InputError(f"{path} has no columns x and y; {TABLE}")
    points = np.column_stack([x, y, np.zeros(len(x)) if z is None else z])
    if not np.all(np.isfinite(points)):
        raise InputError(f"{path}: a coordinate is not finite; correct the file")
    return points


def _taken(columns: dict[str, np.ndarray], names: tuple[str, ...]) -> np.ndarray | None:
    return next((columns.pop(name) for name in names if name in columns), None)


def _joined(path: Path, points: np.ndarray) -> np.ndarray:
    """Return the simplices between points, shape (n_cells, 3 or 4), none of them flat."""
    size = np.ptp(points, axis=0)
    spread = np.flatnonzero(size > 0)
    try:
        if len(spread) < 2:
            raise ValueError
        places = (points[:, spread] - points[:, spread].min(axis=0)) / size[spread]
        cells = np.asarray(scipy.spatial.Delaunay(places).simplices)
    except (ValueError, scipy.spatial.QhullError):
        raise InputError(
            f"{path}: its points lie on a line, between which there is no plane or body; give "
            f"points that surround the rock"
        ) from None
    corners = places[cells]
    volumes = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
    return np.asarray(cells[volumes > SLIVER])
