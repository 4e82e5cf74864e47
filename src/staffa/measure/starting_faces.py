"""Faces from which cracks start, where more than one of a body is cooled."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from staffa.backend.stack import MPI  # noqa: F401

import dolfinx.mesh as dmesh
import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

from staffa.backend.parallel import gather
from staffa.geometry.places import SAME
from staffa.measure.statistics import tips
from staffa.model.domain import Domain
from staffa.records.step import CracksAtHeight, OtherCracks, Tip

type Ahead = tuple[np.ndarray, np.ndarray]  # a place (m) and a direction, shape (3,) each

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
    points: np.ndarray,
    edges: np.ndarray,
    distances: np.ndarray,
    touching: np.ndarray,
    *,
    reach: float,
) -> np.ndarray:
    """Return the face from which the crack of each point starts, shape (n,); NOWHERE for none.

    Of several faces that a crack joins, it is the one to which the way within the crack is the
    shortest, and of equal ways that to the first face. So cracks that meet are parted halfway.

    Parameters
    ----------
    points : coordinates of the cracked points (m), shape (n, 3).
    edges : pairs of neighboring points, shape (m, 2).
    distances : distance of each point from each face (m), shape (n, faces).
    touching : True where a point touches a face, shape (n, faces).
    reach : largest distance from a face at which a crack touches it (m).
    """
    n, faces = distances.shape
    i, j = edges.T
    at, of = np.nonzero(touching)
    ways = distances[at, of] + SAME * reach * (of > OWN)
    lengths = np.concatenate([np.linalg.norm(points[i] - points[j], axis=1), ways])
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
    ways : direction from the nearest point of each other face, shape (n, faces - 1, 3).
    face : number of the face of each point, shape (n,).
    crack : number of the connected crack of each point, shape (n,).
    joined : largest depth (m) at which a crack of the first face touches each other one, shape
        (faces - 1,); -inf without such a crack.
    from_own : True for each point whose crack touches the first face, shape (n,).
    reach : distance (m) from a crack of another face within which an end is no tip.
    """

    names: tuple[str, ...]
    points: np.ndarray
    edges: np.ndarray
    distances: np.ndarray
    ways: np.ndarray
    face: np.ndarray
    crack: np.ndarray
    joined: np.ndarray
    from_own: np.ndarray
    reach: float

    def among(self, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the numbers of the chosen points, and the edges among these.

        Parameters
        ----------
        chosen : True for each point that is taken, shape (n,).
        """
        numbers = np.flatnonzero(chosen)
        inside = self.edges[chosen[self.edges].all(axis=1)]
        return numbers, np.searchsorted(numbers, inside)

    def own(
        self, depth: np.ndarray, before: Sequence[Tip], *, dim: int, prominence: float
    ) -> tuple[Tip, ...]:
        """Return the tips of the cracks that start on no other cooled face.

        Where such a crack has met one of another face, its place is the deeper one of that where
        both are parted and its tip of the step before, which is kept as it was.

        Parameters
        ----------
        depth : depth of the points (m), shape (n,).
        before : tips of the step before.
        dim : dimension of the body.
        prominence : least length of a crack (m).
        """
        numbers, edges = self.among(self.face <= OWN)
        ends = tips(self.points[numbers, :dim], depth[numbers], edges, prominence=prominence)
        at = self._nearest(ends)[1]
        cut = self._cut(at)
        free = [tip for tip, of in zip(ends, cut, strict=True) if not of]
        parted = {
            int(i): replace(tip, room=0.0, met=True)
            for i, tip, of in zip(at, ends, cut, strict=True)
            if of
        }
        kept, stood = [], self._nearest(before)
        for tip, away, i in zip(before, *stood, strict=True):
            if away <= self.reach and self.face[i] > OWN and self.from_own[i]:
                kept.append(replace(tip, met=True))
                same = [k for k in parted if self.crack[k] == self.crack[i]]
                if same:
                    to = np.linalg.norm(self.points[same] - self.points[i], axis=1)
                    del parted[same[int(to.argmin())]]
        return tuple(sorted([*free, *parted.values(), *kept], key=lambda tip: tip.position))

    def others(
        self, before: Sequence[OtherCracks], *, prominence: float
    ) -> tuple[tuple[OtherCracks, Ahead | None], ...]:
        """Return the cracks of each other face that has any, with depths from their own face.

        Beside each stand the place of its deepest tip and the direction in which it goes; None
        where its room is known.

        Parameters
        ----------
        before : those of the step before.
        prominence : least length of a crack (m).
        """
        found, known = [], {one.face: one for one in before}
        for number, name in enumerate(self.names, start=1):
            numbers, edges = self.among(self.face == number)
            depth = self.distances[numbers, number]
            ends = tips(self.points[numbers], depth, edges, prominence=prominence)
            joined = float(self.joined[number - 1])
            old = known.get(name)
            if not ends and old is None:
                continue
            deepest = max(ends, key=lambda tip: tip.depth, default=None)
            at = self._nearest([deepest] if deepest else [])[1]
            cut = bool(self._cut(at).any())
            one = OtherCracks(
                face=name,
                cracks=len(ends) or (old.cracks if old else 0),
                deepest=deepest.depth if deepest else 0.0,
                room=0.0 if cut else None,
                joined=joined if np.isfinite(joined) else None,
            )
            stays = old is not None and old.deepest >= one.deepest
            if old and stays:
                one = replace(one, deepest=old.deepest, room=old.room)
            ahead = None if cut or stays else (self.points[at[0]], self.ways[at[0], number - 1])
            found.append((one, ahead))
        return tuple(found)

    def _nearest(self, ends: Sequence[Tip]) -> tuple[np.ndarray, np.ndarray]:
        """Return the distance (m) of the point nearest to each tip, and its number."""
        if not ends:
            return np.zeros(0), np.zeros(0, dtype=np.int64)
        places = np.zeros((len(ends), 3))
        for place, tip in zip(places, ends, strict=True):
            place[: len(tip.position)] = tip.position
        away, at = cKDTree(self.points).query(places)
        return away, at

    def _cut(self, at: np.ndarray) -> np.ndarray:
        """Return True for each of these points that lies where its crack is parted."""
        found = np.zeros(len(at), dtype=bool)
        for k, i in enumerate(at):
            beyond = (self.crack == self.crack[i]) & (self.face != self.face[i])
            gaps = np.linalg.norm(self.points[beyond] - self.points[i], axis=1)
            found[k] = gaps.min(initial=np.inf) <= self.reach
        return found

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
    layer: float,
    reach: float,
    cools: bool,
) -> Starts:
    """Return the faces from which cracks start; called on rank 0.

    Parameters
    ----------
    points : coordinates of the cracked points (m), shape (n, 3).
    edges : pairs of neighboring points, shape (m, 2).
    depth : distance from the face that depths are measured from (m), shape (n,).
    others : the other cooled faces.
    layer : depth of the layer at the first face that is broken all over (m).
    reach : largest distance from a face, or that layer, at which a crack touches it (m).
    cools : False if the first face is not cooled: then no crack starts there.
    """
    n = len(points)
    away, ways = _from_surfaces(points, others, reach=reach)
    distances = np.column_stack([np.maximum(depth, 0.0), away])
    touching = distances <= reach
    touching[:, OWN] = cools & (depth - layer <= reach)
    count, crack = connected_components(csr_array((np.ones(len(edges)), edges.T), shape=(n, n)))
    owned = np.zeros(count, dtype=bool)
    owned[crack[touching[:, OWN]]] = True
    from_own = owned[crack]
    both = from_own[:, None] & touching[:, OWN + 1 :]
    return Starts(
        names=tuple(one.name for one in others),
        points=points,
        edges=edges,
        distances=distances,
        ways=ways,
        face=starts(points, edges, distances, touching, reach=reach),
        crack=crack,
        joined=np.where(both, distances[:, [OWN]], -np.inf).max(axis=0),
        from_own=from_own,
        reach=reach,
    )


def _from_surfaces(
    points: np.ndarray, others: Sequence[OtherFace], *, reach: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return distances from other faces, shape (n, faces), and directions, shape (n, faces, 3)."""
    away, ways = (
        np.full((len(points), len(others)), np.inf),
        np.zeros((len(points), len(others), 3)),
    )
    for k, one in enumerate(others):
        if one.surface is not None:
            away[:, k], nearest = one.surface.query(points)
            apart = np.maximum(away[:, k], SAME * reach)
            ways[:, k] = (points - one.surface.data[nearest]) / apart[:, None]
    return away, ways
