"""Refinement of a mesh of simplices by DOLFINx: cells that are too coarse are split, none merged.

All of it happens on rank 0, and the finer mesh is distributed again. So it is the same mesh on any
number of ranks, each rank has its share of it, and ties between edges are broken alike.
"""

from dataclasses import dataclass
from typing import Self

from staffa.backend.stack import MPI

import numpy as np
from dolfinx import mesh as dmesh
from scipy.spatial import cKDTree

from staffa.backend.parallel import gather, on_root
from staffa.geometry.edges import cell_edges
from staffa.geometry.nested import Nested, itself, nested
from staffa.geometry.simplices import Simplices
from staffa.model.distributed import distributed
from staffa.model.domain import Domain, Source, finer

# A cell is too coarse if its mean edge is longer than the wanted one by this; then its edges that
# are longer by this are halved. Were all halved, cells cut in two would come out far too small.
# Right triangles cut in two reach the root of 2 exactly: round-off must not decide about them.
COARSE = 2**0.5 * (1 + 1e-6)


@dataclass(frozen=True, kw_only=True)
class Wanted:
    """Edges that cells should get.

    Attributes
    ----------
    edge : mean edge to which each cell is to be split (m), infinite for none, shape (n,).
    around : True for cells around which others are split to the finest too, shape (n,).
    """

    edge: np.ndarray
    around: np.ndarray

    @classmethod
    def nothing(cls, n: int) -> Self:
        """Return the same for n cells that may stay as they are."""
        return cls(edge=np.full(n, np.inf), around=np.zeros(n, dtype=bool))


def too_coarse(edges: np.ndarray, wanted: np.ndarray | float) -> np.ndarray:
    """Mark cells that are too coarse, from their mean edges and the wanted ones (m): shape (n,)."""
    return np.asarray(edges > COARSE * wanted)


def refined(domain: Domain, wanted: Wanted, *, ahead: float) -> tuple[Domain, Nested | None]:
    """Return the body with finer cells, and on rank 0 how the meshes are related. Collective.

    Parameters
    ----------
    domain : the body, with a source.
    wanted : what the cells that this rank owns should become.
    ahead : distance (m) around cells within which others are split too, see `Wanted`.
    """
    source, topology = domain.source, domain.mesh.topology
    assert source is not None
    number = np.asarray(topology.original_cell_index)[: topology.index_map(domain.dim).size_local]
    told = [gather(domain.comm, part) for part in (number, wanted.edge, wanted.around)]
    held: list[Nested] = []

    def split() -> None:
        assert source.mesh is not None
        numbers, edges, around = (np.concatenate(part or []) for part in told)
        order = np.argsort(numbers)
        every = Wanted(edge=edges[order], around=around[order])
        held.append(_split(source.mesh, every, source, ahead))

    on_root(domain.comm, split)
    found = held[0] if held else None
    return finer(domain, None if found is None else found.mesh), found


def _split(mesh: Simplices, wanted: Wanted, source: Source, ahead: float) -> Nested:
    """Split cells, and those around them, until none is too coarse."""
    found, finest = itself(mesh), source.finest
    whole, at = distributed(MPI.COMM_SELF, mesh, mesh.dim), np.unique(mesh.cells[wanted.around])
    known = np.asarray(whole.topology.original_cell_index)
    near = cKDTree(mesh.x[at]) if len(at) else None
    while True:
        corners = found.mesh.x[found.mesh.cells]
        edges, goal = cell_edges(corners), np.maximum(wanted.edge[found.parents], finest)
        long = np.flatnonzero(too_coarse(edges, finest))
        to_finest = source.parted(found.mesh, long)
        if near is not None:
            away, _ = near.query(corners[long].mean(axis=1), distance_upper_bound=ahead)
            to_finest |= away < ahead
        goal[long[to_finest]] = finest
        goal[~too_coarse(edges, goal)] = np.inf
        if np.isinf(goal).all():
            return found
        whole, corners, parents = _halved(whole, COARSE * goal[known])
        found = found.then(nested(found.mesh, corners, known[parents]))
        known = np.arange(len(parents))


def _halved(whole: dmesh.Mesh, longest: np.ndarray) -> tuple[dmesh.Mesh, np.ndarray, np.ndarray]:
    """Halve edges of local cells that are longer than allowed, and those around that it takes.

    Return the finer mesh, the points of its local cells' corners, and their local parents.
    """
    topology, dim = whole.topology, whole.topology.dim
    topology.create_entities(1)
    topology.create_connectivity(dim, 1)
    topology.create_connectivity(1, dim)
    edges = topology.connectivity(dim, 1).array.reshape(len(longest), -1)
    every = np.arange(topology.index_map(1).size_local, dtype=np.int32)
    x = whole.geometry.x[dmesh.entities_to_geometry(whole, 1, every)]
    lengths = np.linalg.norm(x[:, 1] - x[:, 0], axis=-1)[edges]
    halved, parents, _ = dmesh.refine(
        whole,
        np.unique(edges[lengths > longest[:, None]]).astype(np.int32),
        partitioner=None,
        option=dmesh.RefinementOption.parent_cell,
    )
    corners = halved.geometry.x[halved.geometry.dofmaps[0]][..., :dim]
    return halved, corners, np.asarray(parents)[halved.topology.original_cell_index]
