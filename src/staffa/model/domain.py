"""A mesh with named boundaries: what the rest of the code knows of the body's shape."""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial

from staffa.backend.stack import MPI

import basix.ufl
import numpy as np
from dolfinx import mesh as dmesh

from staffa.backend.parallel import on_root
from staffa.errors import InputError, choices
from staffa.geometry.block import SIDES, UNSTRUCTURED, divisions, edge, face_axis, face_position
from staffa.geometry.block_simplices import unstructured
from staffa.geometry.edges import cell_edges
from staffa.geometry.layer import cells_along_crack
from staffa.geometry.outline import Outline, without_axis
from staffa.geometry.places import SAME
from staffa.geometry.simplices import Simplices, keys, mesh_outline

CELLS = {
    "quadrilateral": dmesh.CellType.quadrilateral,
    "triangle": dmesh.CellType.triangle,
    "hexahedron": dmesh.CellType.hexahedron,
    "tetrahedron": dmesh.CellType.tetrahedron,
}


@dataclass(frozen=True, kw_only=True)
class Domain:
    """A mesh, its named boundaries and regions (local facets and cells), its nominal cell size.

    axes: of each boundary that is flat across an axis, that axis. regions: the cells of each named
    region, ghosts included; no cell is in two, and one that is in none belongs to the rest. cracks:
    the cells of this rank that break with each crack that the mesh has. lower: corner of the box
    around the body (m); size: its extent along each axis (m). h: cell edge (m), of triangles and
    tetrahedra in the mean. cell_kind: as `block` takes it. graded: whether edges may differ, as in
    a mesh that was read; see `local_edges`. axial: the section of a body of revolution, x the
    distance from its axis and y along it; no boundary lies on the axis. identity: a text that is
    the same for the same mesh on any number of ranks. coarser: makes the same body with cells twice
    as long, boundaries and all; None where that cannot be done.
    """

    mesh: dmesh.Mesh
    boundaries: Mapping[str, np.ndarray]
    axes: Mapping[str, int]
    regions: Mapping[str, np.ndarray] = field(default_factory=dict)
    cracks: Mapping[str, np.ndarray] = field(default_factory=dict)
    lower: tuple[float, ...]
    size: tuple[float, ...]
    h: float
    cell_kind: str
    identity: str
    axial: bool = False
    coarser: Callable[[], "Domain"] | None = None
    graded: bool = False

    @property
    def comm(self) -> MPI.Comm:
        """Communicator of the mesh."""
        return self.mesh.comm

    @property
    def dim(self) -> int:
        """2 or 3."""
        return int(self.mesh.topology.dim)

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
    axial: bool = False,
    hole: float = 0.0,
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
    axial : True for the section of a body of revolution about x = 0.
    hole : distance along x at which the body begins (m), the radius of a hole along the axis.

    Raises
    ------
    InputError
        Unstructured cells, and no Gmsh.
    """
    make = _unstructured if cells == UNSTRUCTURED else _structured
    mesh, description = make(comm, size, h, cells)
    if hole:
        mesh.geometry.x[:, 0] += hole
        description += f" from {hole}".encode()
    lower = (hole, *(0.0,) * (len(size) - 1))
    sides = [name for name in SIDES[len(size)] if not (axial and name == "left" and not hole)]
    return Domain(
        mesh=mesh,
        boundaries={name: _side(mesh, lower, size, name) for name in sides},
        axes={side: face_axis(side, len(size)) for side in sides},
        regions=_regions(mesh, parts or {}),
        lower=lower,
        size=size,
        axial=axial,
        h=edge(size, h, cells),
        cell_kind=cells,
        identity=hashlib.sha256(description).hexdigest()[:16],
        coarser=_coarser(comm, size, h, cells, parts or {}, axial, hole),
    )


def body(
    comm: MPI.Comm,
    make: Callable[[], Simplices],
    coarser: Callable[[], Domain] | None = None,
    h: float | None = None,
    *,
    graded: bool = False,
    axial: bool = False,
) -> Domain:
    """The body that a mesh with names fills, from triangles or tetrahedra. Collective.

    Parameters
    ----------
    make : gives the mesh; called on rank 0 only. Its errors are raised on all ranks.
    coarser : makes the same body with cells twice as long.
    h : the edge of the cells where cracks run (m), their mean edge if None.
    graded : whether cells differ in length.
    axial : True for the section of a body of revolution about x = 0.
    """
    held: list[Simplices] = []

    def described() -> tuple[Outline, _Names, bytes]:
        held.append(make())
        around = mesh_outline(held[0])
        if axial:
            around = without_axis(around)
        return around, _Names.of(held[0]), _digest(held[0].x, held[0].cells)

    around, names, identity = on_root(comm, described)
    x, corners = (held[0].x, held[0].cells) if held else _nothing(around.dim)
    mesh = _distributed(comm, x, corners)
    known = np.asarray(mesh.topology.original_cell_index)
    own = mesh.topology.index_map(around.dim).size_local

    def here(cells: np.ndarray) -> np.ndarray:
        return np.flatnonzero(np.isin(known, cells)).astype(np.int32)

    cracks = {name: here(cells) for name, cells in names.layers.items()}
    return Domain(
        mesh=mesh,
        boundaries=_faces(mesh, {name: names.faces[name] for name in around.faces}),
        axes={n: plane.axis for n, plane in around.faces.items() if plane is not None},
        regions={name: here(cells) for name, cells in names.regions.items()},
        cracks={name: cells[cells < own] for name, cells in cracks.items()},
        lower=around.lower,
        size=around.size,
        h=h or around.h,
        cell_kind=UNSTRUCTURED,
        axial=axial,
        identity=hashlib.sha256(identity).hexdigest()[:16],
        coarser=coarser,
        graded=graded,
    )


def local_edges(domain: Domain) -> np.ndarray:
    """The mean edge (m) of each simplex that this rank owns, shape (n,)."""
    geometry, own = domain.mesh.geometry, domain.mesh.topology.index_map(domain.dim).size_local
    return cell_edges(geometry.x[geometry.dofmaps[0][:own], : domain.dim])


@dataclass(frozen=True, kw_only=True)
class _Names:
    """What every rank is told of a mesh: the cells of each region and those that break with each
    crack, and the corners of each face's facets, in the numbers of rank 0."""

    regions: Mapping[str, np.ndarray]
    layers: Mapping[str, np.ndarray]
    faces: Mapping[str, np.ndarray]

    @staticmethod
    def of(mesh: Simplices) -> "_Names":
        layers = {name: cells_along_crack(mesh.cells, rows) for name, rows in mesh.cracks.items()}
        return _Names(regions=mesh.regions, layers=layers, faces=mesh.faces)


def _faces(mesh: dmesh.Mesh, faces: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The facets on the surface whose corners are those of each face."""
    dim = mesh.topology.dim
    mesh.topology.create_connectivity(dim - 1, dim)
    surface = dmesh.exterior_facet_indices(mesh.topology)
    nodes = dmesh.entities_to_geometry(mesh, dim - 1, surface).reshape(-1, dim)
    mine = mesh.geometry.input_global_indices[nodes]
    number = keys(np.concatenate([mine, *faces.values()]))  # one number for the same corners
    ends = np.cumsum([len(mine), *(len(rows) for rows in faces.values())])
    named = zip(faces, np.split(number, ends)[1:], strict=False)
    return {name: surface[np.isin(number[: len(mine)], rows)] for name, rows in named}


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
    x, corners = _nothing(dim)

    def make() -> bytes:
        nonlocal x, corners
        x, corners = unstructured(size, h)
        return _digest(x, corners)

    identity = on_root(comm, make)
    return _distributed(comm, x, corners), identity


def _distributed(comm: MPI.Comm, x: np.ndarray, corners: np.ndarray) -> dmesh.Mesh:
    """The mesh of simplices that rank 0 holds, handed out."""
    dim = x.shape[1]
    shape = "triangle" if dim == 2 else "tetrahedron"
    element = basix.ufl.element("Lagrange", shape, 1, shape=(dim,), dtype=np.float64)
    # As blocks have it: a rank also knows the cells across a facet that it shares.
    ghosts = dmesh.create_cell_partitioner(dmesh.GhostMode.shared_facet, 2)
    return dmesh.create_mesh(comm, corners, element, x, partitioner=ghosts)


def _nothing(dim: int) -> tuple[np.ndarray, np.ndarray]:
    return np.zeros((0, dim)), np.zeros((0, dim + 1), dtype=np.int64)


def _digest(x: np.ndarray, corners: np.ndarray) -> bytes:
    return hashlib.sha256(x.tobytes() + corners.tobytes()).digest()


def _coarser(
    comm: MPI.Comm,
    size: tuple[float, ...],
    h: float,
    cells: str,
    parts: Mapping[str, Part],
    axial: bool,
    hole: float,
) -> Callable[[], Domain] | None:
    if cells == UNSTRUCTURED:
        useless = 2 * h > min(size) * (1 + SAME)
    else:
        useless = divisions(size, 2 * h) == divisions(size, h)  # a cell along each axis
    if useless:
        return None
    return partial(
        block, comm, size=size, h=2 * h, cells=cells, parts=parts, axial=axial, hole=hole
    )


def _side(
    mesh: dmesh.Mesh, lower: tuple[float, ...], size: tuple[float, ...], name: str
) -> np.ndarray:
    """Facets of a side of a block."""
    tolerance, axis = SAME * max(size), face_axis(name, len(size))
    position = lower[axis] + face_position(name, size)
    mesh.topology.create_connectivity(mesh.topology.dim - 1, mesh.topology.dim)
    return np.asarray(
        dmesh.locate_entities_boundary(
            mesh, mesh.topology.dim - 1, lambda x: np.abs(x[axis] - position) <= tolerance
        )
    )


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
    return np.asarray(dmesh.compute_midpoints(mesh, dim, every).T)


def cell_count(domain: Domain) -> int:
    """Number of cells of the whole mesh."""
    return int(domain.mesh.topology.index_map(domain.dim).size_global)
