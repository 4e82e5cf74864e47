"""A mesh with named boundaries: what the rest of the code knows of the body's shape."""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from staffa.stack import MPI

import basix.ufl
import numpy as np
from dolfinx import mesh as dmesh

from staffa.errors import InputError, choices
from staffa.grid import SIDES, UNSTRUCTURED, divisions, edge, face_position
from staffa.parallel import on_root
from staffa.unstructured import unstructured

CELLS = {
    "quadrilateral": dmesh.CellType.quadrilateral,
    "triangle": dmesh.CellType.triangle,
    "hexahedron": dmesh.CellType.hexahedron,
    "tetrahedron": dmesh.CellType.tetrahedron,
}


@dataclass(frozen=True, kw_only=True)
class Domain:
    """A mesh, its named boundaries and regions (local facets and cells), its nominal cell size.

    regions: the cells of each named region, ghosts included; no cell is in two, and one that is in
    none belongs to the rest. size: extent along each axis (m), the lower corner at the origin. h:
    cell edge (m).
    identity: a text that is the same for the same mesh on any number of ranks. coarser: makes the
    same body with cells twice as long, boundaries and all; None where that cannot be done.
    """

    mesh: dmesh.Mesh
    boundaries: Mapping[str, np.ndarray]
    regions: Mapping[str, np.ndarray] = field(default_factory=dict)
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

    def cells(self, region: str) -> np.ndarray:
        """Local cells of a named region, ghosts included.

        Raises
        ------
        InputError
            There is no region of that name.
        """
        if region not in self.regions:
            raise InputError(f"domain has no region '{region}'; {choices(region, self.regions)}")
        return self.regions[region]


# Whether points, shape (3, n), lie in a part of the body: shape (n,).
Part = Callable[[np.ndarray], np.ndarray]


def block(
    comm: MPI.Comm,
    *,
    size: tuple[float, ...],
    h: float,
    cells: str,
    parts: Mapping[str, Part] | None = None,
) -> Domain:
    """A rectangle or a box with its lower corner at the origin, meshed with cells of edge <= h.

    Triangles are four to a square, so that no diagonal direction is preferred; unstructured cells
    prefer no direction at all, and their mean edge is h. Collective.

    Parameters
    ----------
    size : extent along each axis (m), two or three numbers.
    cells : "quadrilateral" or "triangle" in 2-D, "hexahedron" or "tetrahedron" in 3-D, or
        "unstructured" for triangles or tetrahedra made by Gmsh.
    parts : the named regions: a cell whose middle is in several belongs to the last of them.

    Raises
    ------
    InputError
        Unstructured cells, and no Gmsh.
    """
    make = _unstructured if cells == UNSTRUCTURED else _structured
    mesh, description = make(comm, size, h, cells)
    return Domain(
        mesh=mesh,
        boundaries=_sides(mesh, size),
        regions=_regions(mesh, parts or {}),
        size=size,
        h=edge(size, h, cells),
        identity=hashlib.sha256(description).hexdigest()[:16],
        coarser=_coarser(comm, size, h, cells, parts or {}),
    )


def _structured(
    comm: MPI.Comm, size: tuple[float, ...], h: float, cells: str
) -> tuple[dmesh.Mesh, bytes]:
    """The mesh, and what identifies it."""
    counts = divisions(size, h)
    corners = [np.zeros(len(size)), np.array(size)]
    if len(size) == 2:
        mesh = dmesh.create_rectangle(
            comm, corners, counts, CELLS[cells], diagonal=dmesh.DiagonalType.crossed
        )
    else:
        mesh = dmesh.create_box(comm, corners, counts, CELLS[cells])
    return mesh, f"block {size} {counts} {cells}".encode()


def _unstructured(
    comm: MPI.Comm, size: tuple[float, ...], h: float, cells: str
) -> tuple[dmesh.Mesh, bytes]:
    """The mesh, made on rank 0, and what identifies it: another Gmsh may make another mesh."""
    dim = len(size)
    x, corners = np.zeros((0, dim)), np.zeros((0, dim + 1), dtype=np.int64)

    def make() -> bytes:
        nonlocal x, corners
        x, corners = unstructured(size, h)
        return hashlib.sha256(x.tobytes() + corners.tobytes()).digest()

    identity = on_root(comm, make)
    shape = "triangle" if dim == 2 else "tetrahedron"
    element = basix.ufl.element("Lagrange", shape, 1, shape=(dim,), dtype=np.float64)
    # As blocks have it: a rank also knows the cells across a facet that it shares.
    ghosts = dmesh.create_cell_partitioner(dmesh.GhostMode.shared_facet, 2)
    return dmesh.create_mesh(comm, corners, element, x, partitioner=ghosts), identity


def _coarser(
    comm: MPI.Comm, size: tuple[float, ...], h: float, cells: str, parts: Mapping[str, Part]
) -> Callable[[], Domain] | None:
    if cells == UNSTRUCTURED:
        useless = 2 * h > min(size) * (1 + 1e-9)
    else:
        useless = divisions(size, 2 * h) == divisions(size, h)  # a cell along each axis
    if useless:
        return None
    return lambda: block(comm, size=size, h=2 * h, cells=cells, parts=parts)


def _sides(mesh: dmesh.Mesh, size: tuple[float, ...]) -> dict[str, np.ndarray]:
    tolerance = 1e-9 * max(size)
    mesh.topology.create_connectivity(mesh.topology.dim - 1, mesh.topology.dim)

    def on_side(name: str, axis: int) -> np.ndarray:
        position = face_position(name, size)
        return dmesh.locate_entities_boundary(
            mesh, mesh.topology.dim - 1, lambda x: np.abs(x[axis] - position) <= tolerance
        )

    return {name: on_side(name, axis) for name, (axis, _) in SIDES[len(size)].items()}


def _regions(mesh: dmesh.Mesh, parts: Mapping[str, Part]) -> dict[str, np.ndarray]:
    if not parts:
        return {}
    x = middles(mesh)
    number = np.full(x.shape[1], -1)
    for k, inside in enumerate(parts.values()):
        number[inside(x)] = k
    return {name: np.flatnonzero(number == k).astype(np.int32) for k, name in enumerate(parts)}


def middles(mesh: dmesh.Mesh) -> np.ndarray:
    """The middle of each cell (m), ghosts included, shape (3, n)."""
    dim = mesh.topology.dim
    cells = mesh.topology.index_map(dim)
    every = np.arange(cells.size_local + cells.num_ghosts, dtype=np.int32)
    return dmesh.compute_midpoints(mesh, dim, every).T


def cell_count(domain: Domain) -> int:
    """Number of cells of the whole mesh."""
    return int(domain.mesh.topology.index_map(domain.dim).size_global)
