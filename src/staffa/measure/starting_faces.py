"""Faces from which cracks start, where more than one of a body is cooled."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from staffa.backend.stack import MPI  # noqa: F401

import dolfinx.mesh as dmesh
import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from staffa.backend.parallel import gather
from staffa.measure.statistics import tips
from staffa.model.domain import Domain
from staffa.records.step import CracksAtHeight, OtherCracks

NOWHERE, OWN = -1, 0  # labels of cracks of no cooled face, and of that from which depth is measured


@dataclass(frozen=True, kw_only=True)
class OtherFace:
    """A cooled face besides that from which depths are measured.

    Attributes
    ----------
    name : name of the boundary.
    surface : its vertices, on rank 0; None elsewhere.
    """

    name: str
    surface: cKDTree | None


def cooled_faces(domain: Domain, names: Sequence[str]) -> tuple[OtherFace, ...]:
    """Return the cooled faces of these names that the mesh has. Collective.

    Parameters
    ----------
    domain : the mesh.
    names : names of boundaries.
    """
    found = []
    domain.mesh.topology.create_connectivity(domain.dim - 1, domain.dim)
    for name in names:
        nodes = dmesh.entities_to_geometry(domain.mesh, domain.dim - 1, domain.facets(name))
        parts = gather(domain.comm, domain.mesh.geometry.x[np.unique(nodes)])
        points = np.concatenate(parts) if parts is not None else np.zeros((0, 3))
        found.append(OtherFace(name=name, surface=cKDTree(points) if len(points) else None))
    return tuple(found)


def starts(
    points: np.ndarray, edges: np.ndarray, distances: np.ndarray, *, reach: float
) -> np.ndarray:
    """Return the face from which the crack of each point starts, shape (n,); NOWHERE for none.

    Of several faces that a crack joins, it is the one to which the way within the crack is the
    shortest. So cracks that meet are parted halfway.

    Parameters
    ----------
    points : coordinates of the cracked points (m), shape (n, 3).
    edges : pairs of neighboring points, shape (m, 2).
    distances : distance of each point from each face (m), shape (n, faces).
    reach : largest distance from a face at which a crack touches it (m).
    """
    n, faces = distances.shape
    i, j = edges.T
    at, of = np.nonzero(distances <= reach)
    lengths = np.concatenate([np.linalg.norm(points[i] - points[j], axis=1), distances[at, of]])
    whole = (np.concatenate([i, at]), np.concatenate([j, n + of]))
    positive = np.maximum(lengths, 1e-12 * reach)  # a length of 0 would be no edge
    graph = csr_array((positive, whole), shape=(n + faces, n + faces))
    *_, nearest = dijkstra(
        graph, directed=False, indices=np.arange(n, n + faces), return_predecessors=True,
        min_only=True,
    )  # fmt: skip
    return np.where(nearest[:n] >= n, nearest[:n] - n, NOWHERE)


@dataclass(frozen=True, kw_only=True, eq=False)
class Starts:
    """Cracked points with the faces from which their cracks start.

    Attributes
    ----------
    names : names of the other cooled faces; they have the numbers from 1.
    points : coordinates (m), shape (n, 3).
    edges : pairs of neighboring points, shape (m, 2).
    distances : distance of each point from each face (m), shape (n, faces).
    face : number of the face of each point, shape (n,).
    """

    names: tuple[str, ...]
    points: np.ndarray
    edges: np.ndarray
    distances: np.ndarray
    face: np.ndarray

    def among(self, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the numbers of the chosen points, and the edges among these.

        Parameters
        ----------
        chosen : True for each point that is taken, shape (n,).
        """
        numbers = np.flatnonzero(chosen)
        inside = self.edges[chosen[self.edges].all(axis=1)]
        return numbers, np.searchsorted(numbers, inside)

    def own(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the points and edges of the cracks that start on no other cooled face."""
        return self.among(self.face <= OWN)

    def others(self, *, prominence: float) -> tuple[OtherCracks, ...]:
        """Return the cracks of the other faces that have any, with depths from their own face.

        Parameters
        ----------
        prominence : least length of a crack (m).
        """
        found = []
        for number, name in enumerate(self.names, start=1):
            numbers, edges = self.among(self.face == number)
            depth = self.distances[numbers, number]
            ends = tips(self.points[numbers], depth, edges, prominence=prominence)
            if ends:
                deepest = max(tip.depth for tip in ends)
                found.append(OtherCracks(face=name, cracks=len(ends), deepest=deepest))
        return tuple(found)

    def on_line(self, found: CracksAtHeight, places: np.ndarray) -> CracksAtHeight:
        """Return the cracks on a line that start on no other face, with the number of the others.

        Parameters
        ----------
        found : all cracks on the line.
        places : their places (m), shape (cracks, 3).
        """
        if not len(self.points) or not found.cracks:
            return found
        face = self.face[cKDTree(self.points).query(places)[1]]
        kept = tuple(p for p, of in zip(found.positions, face, strict=True) if of <= OWN)
        return replace(
            found,
            cracks=len(kept),
            spacing=float(np.diff(kept).mean()) if len(kept) > 1 else None,
            positions=kept,
            elsewhere=found.cracks - len(kept),
        )


def started(
    points: np.ndarray,
    edges: np.ndarray,
    depth: np.ndarray,
    others: Sequence[OtherFace],
    *,
    reach: float,
) -> Starts:
    """Return the faces from which cracks start; called on rank 0.

    Parameters
    ----------
    points : coordinates of the cracked points (m), shape (n, 3).
    edges : pairs of neighboring points, shape (m, 2).
    depth : distance from the face that depths are measured from, or from the layer there that is
        broken all over (m), shape (n,).
    others : the other cooled faces.
    reach : largest distance from a face at which a crack touches it (m).
    """
    away = [one.surface.query(points)[0] if one.surface else depth + np.inf for one in others]
    distances = np.column_stack([np.maximum(depth, 0.0), *away])
    return Starts(
        names=tuple(one.name for one in others),
        points=points,
        edges=edges,
        distances=distances,
        face=starts(points, edges, distances, reach=reach),
    )
