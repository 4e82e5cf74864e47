"""Mesh with named boundaries and regions."""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

from staffa.backend.stack import MPI

import numpy as np
from dolfinx import mesh as dmesh

from staffa.backend.parallel import on_root
from staffa.errors import InputError, choices
from staffa.geometry.block import SIDES, UNSTRUCTURED, divisions, edge, face_axis
from staffa.geometry.block_simplices import unstructured
from staffa.geometry.edges import cell_edges
from staffa.geometry.outline import Outline, without_axis
from staffa.geometry.places import SAME
from staffa.geometry.simplices import Simplices, mesh_outline
from staffa.model.block_parts import Part, parted_cells, region_cells, side_facets
from staffa.model.block_parts import middles as middles
from staffa.model.distributed import LocalNames, digest, distributed, local_names

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
    source : what finer meshes of the body are made from; None for a mesh that stays as it is.
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
    source: "Source | None" = None

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


@dataclass(frozen=True, kw_only=True)
class Source:
    """Source of finer meshes of a body.

    Attributes
    ----------
    mesh : the whole current mesh, on rank 0; None elsewhere.
    finest : mean edge of the finest cells (m).
    named : finds what has a name in a distributed mesh, from the whole one. Collective.
    parted : marks those of some cells of a whole mesh that lie in several named regions.
    """

    mesh: Simplices | None
    finest: float
    named: Callable[[dmesh.Mesh, Simplices | None], LocalNames]
    parted: Callable[[Simplices, np.ndarray], np.ndarray] = lambda mesh, cells: cells < 0


def block(
    comm: MPI.Comm,
    *,
    size: tuple[float, ...],
    h: float,
    cells: str,
    parts: Mapping[str, Part] | None = None,
    axial: bool = False,
    hole: float = 0.0,
    halvings: int = 0,
    uneven: Mapping[str, Part] | None = None,
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
    halvings : how often edges may be halved, from cells that begin so much longer, until they are
        no longer than h; 0 for a mesh that stays as it is. Of triangles and tetrahedra alone.
    uneven : other parts of the rock that differ: their boundaries are fine as those of regions are.

    Raises
    ------
    InputError
        Gmsh is missing for unstructured cells.
    """
    longest, whole = h * 2**halvings, None
    if cells == UNSTRUCTURED or halvings:
        whole, description = _whole(comm, size, longest, cells)
        mesh = distributed(comm, whole, len(size))
    else:
        mesh, description = _structured(comm, size, longest, cells)
    if hole:
        mesh.geometry.x[:, 0] += hole
        description += f" from {hole}".encode()
        if whole is not None:
            whole = replace(whole, x=whole.x + hole * np.eye(len(size))[0])
    lower, known = (hole, *(0.0,) * (len(size) - 1)), parts or {}
    sides = [name for name in SIDES[len(size)] if not (axial and name == "left" and not hole)]

    def named(mesh: dmesh.Mesh, whole: Simplices | None) -> LocalNames:
        return LocalNames(
            boundaries={name: side_facets(mesh, lower, size, name) for name in sides},
            regions=region_cells(mesh, known),
        )

    source = None
    if halvings:
        edges = None if whole is None else float(cell_edges(whole.x[whole.cells]).mean())
        finest = comm.bcast(edges) / 2**halvings
        source = Source(
            mesh=whole,
            finest=finest,
            named=named,
            parted=partial(
                parted_cells, {**known, **(uneven or {})}, edge(size, longest, cells) / 2**halvings
            ),
        )
        description += f" halved {halvings} times".encode()
    return Domain(
        mesh=mesh,
        **vars(named(mesh, whole)),
        axes={side: face_axis(side, len(size)) for side in sides},
        lower=lower,
        size=size,
        axial=axial,
        h=edge(size, longest, cells) / 2**halvings,
        cell_kind=cells,
        identity=_short(description),
        coarser=None if halvings else _coarser(comm, size, h, cells, known, axial, hole),
        graded=halvings > 0,
        source=source,
    )


def body(
    comm: MPI.Comm,
    make: Callable[[], Simplices],
    coarser: Callable[[], Domain] | None = None,
    h: float | None = None,
    *,
    graded: bool = False,
    axial: bool = False,
    halvings: int = 0,
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
    halvings : how often mean edges may be halved, down to h; 0 for a mesh that stays as it is.
    """
    held: list[Simplices] = []

    def described() -> tuple[Outline, bytes]:
        held.append(make())
        around = mesh_outline(held[0])
        if axial:
            around = without_axis(around)
        return around, digest(held[0].x, held[0].cells)

    around, identity = on_root(comm, described)
    whole = held[0] if held else None
    mesh = distributed(comm, whole, around.dim)
    named, finest = partial(local_names, tuple(around.faces)), h or around.h / 2**halvings
    return Domain(
        mesh=mesh,
        **vars(named(mesh, whole)),
        axes={n: plane.axis for n, plane in around.faces.items() if plane is not None},
        lower=around.lower,
        size=around.size,
        h=finest,
        cell_kind=UNSTRUCTURED,
        axial=axial,
        identity=_short(identity),
        coarser=coarser,
        graded=graded or halvings > 0,
        source=Source(mesh=whole, finest=finest, named=named) if halvings else None,
    )


def finer(domain: Domain, whole: Simplices | None) -> Domain:
    """Return the same body on a finer mesh. Collective.

    Parameters
    ----------
    domain : the body, with a source.
    whole : the finer mesh, on rank 0; None elsewhere.
    """
    assert domain.source is not None
    comm, source = domain.comm, replace(domain.source, mesh=whole)
    mesh = distributed(comm, whole, domain.dim)
    identity = on_root(comm, lambda: digest(whole.x, whole.cells) if whole is not None else b"")
    named = vars(source.named(mesh, whole))
    return replace(domain, mesh=mesh, **named, identity=_short(identity), source=source)


def local_edges(domain: Domain) -> np.ndarray:
    """Return the mean edge (m) of each simplex that this rank owns, shape (n,)."""
    geometry, own = domain.mesh.geometry, domain.mesh.topology.index_map(domain.dim).size_local
    return cell_edges(geometry.x[geometry.dofmaps[0][:own], : domain.dim])


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


def _whole(
    comm: MPI.Comm, size: tuple[float, ...], h: float, cells: str
) -> tuple[Simplices | None, bytes]:
    """Return the whole mesh on rank 0, and its digest: another Gmsh may make another mesh."""
    held: list[Simplices] = []

    def make() -> bytes:
        if cells == UNSTRUCTURED:
            x, corners = unstructured(size, h)
        else:
            mesh, _ = _structured(MPI.COMM_SELF, size, h, cells)
            x, corners = mesh.geometry.x[:, : len(size)], mesh.geometry.dofmaps[0].astype(np.int64)
        held.append(Simplices(x=x, cells=corners, regions={}, faces={}, cracks={}))
        return digest(x, corners)

    identity = on_root(comm, make)
    return (held[0] if held else None), identity


def _short(description: bytes) -> str:
    return hashlib.sha256(description).hexdigest()[:16]


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


def cell_count(domain: Domain) -> int:
    """Return the number of cells of the whole mesh."""
    return int(domain.mesh.topology.index_map(domain.dim).size_global)
