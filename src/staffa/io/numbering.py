"""Values at vertices, or of cells, in an order that no partition changes."""

from staffa.stack import MPI

import numpy as np
from dolfinx import fem

from staffa.fields import vertices
from staffa.parallel import gather, scatter


class Numbering:
    """The way from the vertices (or cells) of each rank to those of the whole mesh, on rank 0, and
    back.

    The same mesh on other ranks has the same order, so that what some ranks wrote any others read:
    that in which its vertices were made (DOLFINx's `input_global_indices`), and of cells that of
    their sorted vertices. Everything is collective.
    """

    def __init__(self, comm: MPI.Comm, space: fem.FunctionSpace) -> None:
        """space: linear scalar elements, or constants in cells, scalar or not."""
        self.comm = comm
        geometry = space.mesh.geometry
        corners = geometry.input_global_indices[geometry.dofmaps[0]]
        self._owned = space.dofmap.index_map.size_local
        if space.dofmap.list.shape[1] == 1:
            numbers = np.sort(corners, axis=1)
        else:
            numbers = np.zeros((len(vertices(space)), 1), dtype=np.int64)
            numbers[space.dofmap.list.ravel(), 0] = corners.ravel()
        places = gather(comm, numbers[: self._owned])
        if places is not None:
            self._order = np.lexsort(np.concatenate(places).T)
            self._ends = np.cumsum([len(part) for part in places])[:-1]
        self.points = self.whole(vertices(space))

    def whole(self, values: np.ndarray) -> np.ndarray | None:
        """All values on rank 0, None elsewhere, from those of this rank, shape (n_local,)
        or (n_local, components); ghosts are left out."""
        parts = gather(self.comm, np.ascontiguousarray(values[: self._owned]))
        return None if parts is None else np.concatenate(parts)[self._order]

    def share(self, whole: np.ndarray | None) -> np.ndarray:
        """This rank's own values, from all that rank 0 has."""
        parts = None
        if whole is not None:
            own = np.empty_like(whole)
            own[self._order] = whole
            parts = np.split(own, self._ends)
        return scatter(self.comm, parts)
