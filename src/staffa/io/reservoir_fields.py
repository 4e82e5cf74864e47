"""Fields of a reservoir's cells on disk, beside the fields of a step; no finite elements."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from staffa.io.field_names import fields_name, reservoir_name
from staffa.io.vtkhdf import VtkMesh, read_vtkhdf, write_vtkhdf


@dataclass(frozen=True, kw_only=True)
class ReservoirFields:
    """Fields of the cells of a reservoir, the first axis fastest, at one time.

    Attributes
    ----------
    grid : the cells, of n in all.
    T : temperature (K), shape (n,).
    p : pressure (Pa), shape (n,).
    k : permeability (m^2) along the axis along which it is largest, shape (n,).
    w : opening of cracks (m), shape (n,); None where cracks do not change the flow.
    A : area of cracks in a unit of volume (1/m), shape (n,); None likewise.
    """

    grid: VtkMesh
    T: np.ndarray
    p: np.ndarray
    k: np.ndarray
    w: np.ndarray | None = None
    A: np.ndarray | None = None


def write_reservoir(
    directory: Path,
    index: int,
    edges: Sequence[np.ndarray],
    *,
    T: np.ndarray,
    p: np.ndarray,
    k: np.ndarray,
    w: np.ndarray | None = None,
    A: np.ndarray | None = None,
) -> str:
    """Write the fields of the cells at a step, and return the file's name in the run directory.

    Not collective: called on the rank that has them, before the index of the files is written.

    Parameters
    ----------
    directory : the run directory.
    index : index of the step.
    edges : coordinates of the faces of the cells (m) along x and y, in 3-D also z.
    T, p, k : temperature (K), pressure (Pa) and permeability (m^2) of the cells, shape (n,), the
        first axis fastest.
    w, A : opening of cracks (m) and their area in a unit of volume (1/m), likewise; None where
        cracks do not change the flow.
    """
    name = reservoir_name(fields_name(index))
    fields = {"T": T, "p": p, "k": k}
    if w is not None and A is not None:
        fields |= {"w": w, "A": A}
    write_vtkhdf(directory / name, cell_mesh(edges), {}, fields)
    return name


def read_reservoir(directory: Path, fields: str) -> ReservoirFields:
    """Return the fields of the reservoir at a step.

    Parameters
    ----------
    directory : the run directory.
    fields : name of the step's own file of fields, as its record has it.

    Raises
    ------
    OSError, KeyError, ValueError, IndexError
        There is no such file, or it is damaged.
    """
    grid, values = read_vtkhdf(directory / reservoir_name(fields))
    names = ("T", "p", "k", *(name for name in ("w", "A") if name in values))
    found = {name: values[name] for name in names}
    if any(of.shape != (len(grid.cells),) for of in found.values()):
        raise ValueError("it has not one value in each cell")
    return ReservoirFields(grid=grid, **found)


def cell_mesh(edges: Sequence[np.ndarray]) -> VtkMesh:
    """Return rectangles in the plane z = 0, or boxes, as a mesh; the first axis fastest.

    Parameters
    ----------
    edges : coordinates of their faces (m) along x and y, in 3-D also z.
    """
    corners = np.meshgrid(*edges, indexing="ij")
    points = np.stack([axis.ravel(order="F") for axis in corners], axis=1)
    number = np.arange(len(points)).reshape(corners[0].shape, order="F")
    low = number[tuple(slice(0, -1) for _ in edges)].ravel(order="F")
    along = len(edges[0])
    square = np.column_stack([low, low + 1, low + 1 + along, low + along])
    if len(edges) == 2:
        return VtkMesh(points=np.pad(points, ((0, 0), (0, 1))), cells=square, type=9)
    return VtkMesh(
        points=points, cells=np.hstack([square, square + along * len(edges[1])]), type=12
    )
