"""A mesh with named boundaries: what the rest of the code knows of the body's shape."""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from staffa.stack import MPI

import numpy as np
from dolfinx import mesh as dmesh

from staffa.errors import InputError, choices
from staffa.grid import SIDES, divisions, edge, face_position

CELLS = {
    "quadrilateral": dmesh.CellType.quadrilateral,
    "triangle": dmesh.CellType.triangle,
    "hexahedron": dmesh.CellType.hexahedron,
    "tetrahedron": dmesh.CellType.tetrahedron,
}


@dataclass(frozen=True, kw_only=True)
class Domain:
    """A mesh, the facets of each named boundary (local indices), and its nominal cell size.

    size: extent along each axis (m), the lower corner at the origin. h: cell edge (m).
    identity: a text that is the same for the same mesh on any number of ranks. coarser: makes the
    same body with cells twice as long, boundaries and all; None where that cannot be done.
    """

    mesh: dmesh.Mesh
    boundaries: Mapping[str, np.ndarray]
    size: tuple[float, ...]
    h: float
    identity: str
    coarser: Callable[[], "Domain"] | None = None

    @property
    def comm(self) -> MPI.Comm:
        """Communicator of the mesh."""
        return self.mesh.comm

    @property
    def dim(self) -> int:
        """2 or 3."""
        return self.mesh.topology.dim

    def facets(self, name: str) -> np.ndarray:
        """Local facets of a named boundary.

        Raises
        ------
        InputError
            There is no boundary of that name.
        """
        if name not in self.boundaries:
            raise InputError(f"domain has no boundary '{name}'; {choices(name, self.boundaries)}")
        return self.boundaries[name]


def block(comm: MPI.Comm, *, size: tuple[float, ...], h: float, cells: str) -> Domain:
    """A rectangle or a box with its lower corner at the origin, meshed with cells of edge <= h.

    Triangles are four to a square, so that no diagonal direction is preferred. Collective.

    Parameters
    ----------
    size : extent along each axis (m), two or three numbers.
    cells : "quadrilateral" or "triangle" in 2-D, "hexahedron" or "tetrahedron" in 3-D.
    """
    counts = divisions(size, h)
    corners = [np.zeros(len(size)), np.array(size)]
    if len(size) == 2:
        mesh = dmesh.create_rectangle(
            comm, corners, counts, CELLS[cells], diagonal=dmesh.DiagonalType.crossed
        )
    else:
        mesh = dmesh.create_box(comm, corners, counts, CELLS[cells])
    description = f"block {size} {counts} {cells}"
    return Domain(
        mesh=mesh,
        boundaries=_sides(mesh, size),
        size=size,
        h=edge(size, h),
        identity=hashlib.sha256(description.encode()).hexdigest()[:16],
        coarser=_coarser(comm, size, h, cells),
    )


def _coarser(
    comm: MPI.Comm, size: tuple[float, ...], h: float, cells: str
) -> Callable[[], Domain] | None:
    if divisions(size, 2 * h) == divisions(size, h):  # a cell along each axis
        return None
    return lambda: block(comm, size=size, h=2 * h, cells=cells)


def _sides(mesh: dmesh.Mesh, size: tuple[float, ...]) -> dict[str, np.ndarray]:
    tolerance = 1e-9 * max(size)
    mesh.topology.create_connectivity(mesh.topology.dim - 1, mesh.topology.dim)

    def on_side(name: str, axis: int) -> np.ndarray:
        position = face_position(name, size)
        return dmesh.locate_entities_boundary(
            mesh, mesh.topology.dim - 1, lambda x: np.abs(x[axis] - position) <= tolerance
        )

    return {name: on_side(name, axis) for name, (axis, _) in SIDES[len(size)].items()}


def cell_count(domain: Domain) -> int:
    """Number of cells of the whole mesh."""
    return int(domain.mesh.topology.index_map(domain.dim).size_global)
