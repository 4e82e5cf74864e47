"""Values at vertices in an order that no partition changes: that in which the mesh was made."""

from staffa.stack import MPI

import numpy as np
from dolfinx import fem

from staffa.fields import vertices
from staffa.parallel import gather, scatter


class Numbering:
    """The way from the vertices of each rank to those of the whole mesh, on rank 0, and back.

    The same mesh on other ranks has the same order (DOLFINx's `input_global_indices`), so that what
    some ranks wrote any others read. Everything is collective.
    """

    def __init__(self, comm: MPI.Comm, space: fem.FunctionSpace) -> None:
        """space: linear scalar elements."""
        self.comm = comm
        geometry = space.mesh.geometry
        points = vertices(space)
        node = np.zeros(len(points), dtype=np.int64)
        node[space.dofmap.list.ravel()] = geometry.dofmaps[0].ravel()
        self._owned = space.dofmap.index_map.size_local
        places = gather(comm, geometry.input_global_indices[node[: self._owned]])
        if places is not None:
            self._order = np.argsort(np.concatenate(places))
            self._ends = np.cumsum([len(part) for part in places])[:-1]
        self.points = self.whole(points)

    def whole(self, values: np.ndarray) -> np.ndarray | None:
        """Values of all vertices on rank 0, None elsewhere, from those of this rank, shape
        (n_local,) or (n_local, components); ghosts are left out."""
        parts = gather(self.comm, np.ascontiguousarray(values[: self._owned]))
        return None if parts is None else np.concatenate(parts)[self._order]

    def share(self, whole: np.ndarray | None) -> np.ndarray:
        """This rank's own values, from those of all vertices that rank 0 has."""
        parts = None
        if whole is not None:
            own = np.empty_like(whole)
            own[self._order] = whole
            parts = np.split(own, self._ends)
        return scatter(self.comm, parts)
