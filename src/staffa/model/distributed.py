"""Meshes of simplices with names, distributed from rank 0."""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field

from staffa.backend.stack import MPI

import basix.ufl
import numpy as np
from dolfinx import mesh as dmesh

from staffa.backend.parallel import on_root
from staffa.geometry.layer import cells_along_crack
from staffa.geometry.simplices import Simplices, keys


@dataclass(frozen=True, kw_only=True)
class LocalNames:
    """Named parts of what a rank has of a mesh.

    Attributes
    ----------
    boundaries : local facets of each boundary.
    regions : local cells of each region, ghosts included.
    cracks : owned cells of the layer that breaks with each crack.
    """

    boundaries: Mapping[str, np.ndarray]
    regions: Mapping[str, np.ndarray]
    cracks: Mapping[str, np.ndarray] = field(default_factory=dict)


def distributed(comm: MPI.Comm, whole: Simplices | None, dim: int) -> dmesh.Mesh:
    """Distribute a mesh of simplices. Collective.

    Parameters
    ----------
    comm : communicator of the mesh.
    whole : the mesh, on rank 0; None elsewhere.
    dim : its dimension.
    """
    shape = "triangle" if dim == 2 else "tetrahedron"
    element = basix.ufl.element("Lagrange", shape, 1, shape=(dim,), dtype=np.float64)
    # As in blocks: a rank also knows the cells across a shared facet.
    ghosts = dmesh.create_cell_partitioner(dmesh.GhostMode.shared_facet, 2)
    x, cells = np.zeros((0, dim)), np.zeros((0, dim + 1), dtype=np.int64)
    if whole is not None:
        x, cells = whole.x, whole.cells
    return dmesh.create_mesh(comm, cells, element, x, partitioner=ghosts)


def digest(x: np.ndarray, corners: np.ndarray) -> bytes:
    """Return a hash of the points and the cells of a mesh."""
    return hashlib.sha256(x.tobytes() + corners.tobytes()).digest()


def local_names(faces: tuple[str, ...], mesh: dmesh.Mesh, whole: Simplices | None) -> LocalNames:
    """Find the named parts of a mesh that was distributed. Collective.

    Parameters
    ----------
    faces : names of the faces that are boundaries.
    mesh : the distributed mesh.
    whole : the mesh with its names, on rank 0; None elsewhere.
    """

    def named() -> tuple[dict[str, np.ndarray], ...]:
        assert whole is not None
        layers = {n: cells_along_crack(whole.cells, rows) for n, rows in whole.cracks.items()}
        return {name: whole.faces[name] for name in faces}, dict(whole.regions), layers

    around, regions, layers = on_root(mesh.comm, named)
    known = np.asarray(mesh.topology.original_cell_index)
    own = mesh.topology.index_map(mesh.topology.dim).size_local

    def here(cells: np.ndarray) -> np.ndarray:
        return np.flatnonzero(np.isin(known, cells)).astype(np.int32)

    broken = {name: here(cells) for name, cells in layers.items()}
    return LocalNames(
        boundaries=_facets(mesh, around),
        regions={name: here(cells) for name, cells in regions.items()},
        cracks={name: cells[cells < own] for name, cells in broken.items()},
    )


def _facets(mesh: dmesh.Mesh, faces: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
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
