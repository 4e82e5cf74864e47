"""Mesh with named boundaries and regions."""

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
    """Mesh with its named boundaries and regions, as local facets and cells.

    Attributes
    ----------
    mesh : the mesh.
    boundaries : local facets of each named boundary.
    axes : axis across each boundary that is flat across an axis.
    regions : cells of each named region, ghosts included; no cell is in two.
    cracks : cells of this rank that break with each crack that the mesh has.
    lower : lower corner of the box around the body (m).
    size : extent of that box along each axis (m).
    h : mesh size (m); of triangles and tetrahedra the mean edge.
    cell_kind : shape of the cells, as `block` takes it.
    identity : text that is the same for the same mesh on any number of ranks.
    axial : True for the meridian plane of a body of revolution (x = r, y = z); the axis is no
        boundary.
    coarser : makes the same body with cells twice as long; None if that is impossible.
    graded : True if edges may differ, as in a mesh that was read; see `local_edges`.
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
        """Dimension, 2 or 3."""
        return int(self.mesh.topology.dim)

    def facets(self, name: str) -> np.ndarray:
        """Return the local facets of a named boundary.

        Raises
        ------
        InputError
            There is no boundary of that name.
        """
        if name not in self.boundaries:
            raise InputError(f"domain has no boundary '{name}'; {choices(name, self.boundaries)}")
        return self.boundaries[name]

    def cells(self, region: str) -> np.ndarray:
        """Return the local cells of a named region, ghosts included.

        Raises
        ------
        InputError
            There is no region of that name.
        """
        if region not in self.regions:
            raise InputError(f"domain has no region '{region}'; {choices(region, self.regions)}")
        return self.regions[region]


# True for points, shape (3, n), in a part of the body: shape (n,).
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
    """Mesh a rectangle or a box with its lower corner at the origin. Collective.

    No direction is preferred: triangles are four to a square, and unstructured cells have none.

    Parameters
    ----------
    comm : communicator of the mesh.
    size : extent along each axis (m), two or three numbers.
    h : largest edge of a cell (m); of unstructured cells the mean edge.
    cells : a key of `CELLS`, or "unstructured" for triangles or tetrahedra made by Gmsh.
    parts : the named regions: a cell whose center is in several belongs to the last of them.
    axial : True for the meridian plane of a body of revolution about x = 0.
    hole : distance along x at which the body begins (m), the radius of a hole along the axis.

    Raises
    ------
    InputError
        Gmsh is missing for unstructured cells.
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
    """Return the body that a mesh of triangles or tetrahedra with names fills. Collective.

    Parameters
    ----------
    comm : communicator of the mesh.
    make : returns the mesh; called on rank 0 only. Its errors are raised on all ranks.
    coarser : makes the same body with cells twice as long; None if that is impossible.
    h : edge of the cells along crack paths (m); None for the mean edge.
    graded : True if edges may differ.
    axial : True for the meridian plane of a body of revolution about x = 0.
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
    """Return the mean edge (m) of each simplex that this rank owns, shape (n,)."""
    geometry, own = domain.mesh.geometry, domain.mesh.topology.index_map(domain.dim).size_local
    return cell_edges(geometry.x[geometry.dofmaps[0][:own], : domain.dim])


@dataclass(frozen=True, kw_only=True)
class _Names:
    """Cells of regions and along cracks, and corners of faces' facets, in the numbers of rank 0."""

    regions: Mapping[str, np.ndarray]
    layers: Mapping[str, np.ndarray]
    faces: Mapping[str, np.ndarray]

    @staticmethod
    def of(mesh: Simplices) -> "_Names":
        layers = {name: cells_along_crack(mesh.cells, rows) for name, rows in mesh.cracks.items()}
        return _Names(regions=mesh.regions, layers=layers, faces=mesh.faces)


def _faces(mesh: dmesh.Mesh, faces: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Return the surface facets whose corners are those of each face."""
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
    """Return the mesh, and a text that identifies it."""
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
    """Return the mesh, made on rank 0, and its digest: another Gmsh may make another mesh."""
    dim = len(size)
    x, corners = _nothing(dim)

    def make() -> bytes:
        nonlocal x, corners
        x, corners = unstructured(size, h)
        return _digest(x, corners)

    identity = on_root(comm, make)
    return _distributed(comm, x, corners), identity


def _distributed(comm: MPI.Comm, x: np.ndarray, corners: np.ndarray) -> dmesh.Mesh:
    """Distribute a mesh of simplices from rank 0."""
    dim = x.shape[1]
    shape = "triangle" if dim == 2 else "tetrahedron"
    element = basix.ufl.element("Lagrange", shape, 1, shape=(dim,), dtype=np.float64)
    # As in blocks: a rank also knows the cells across a shared facet.
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
    """Return the facets of a side of a block."""
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
    """Return the center of each cell (m), ghosts included, shape (3, n)."""
    dim = mesh.topology.dim
    cells = mesh.topology.index_map(dim)
    every = np.arange(cells.size_local + cells.num_ghosts, dtype=np.int32)
    return np.asarray(dmesh.compute_midpoints(mesh, dim, every).T)


def cell_count(domain: Domain) -> int:
    """Return the number of cells of the whole mesh."""
    return int(domain.mesh.topology.index_map(domain.dim).size_global)
