"""Order of values at nodes or in cells that does not depend on the partition."""

from staffa.backend.stack import MPI

import basix
import numpy as np
from dolfinx import fem

from staffa.backend.parallel import gather, scatter
from staffa.model.fields import vertices


class Numbering:
    """Map between the nodes (or cells) of each rank and those of the whole mesh on rank 0.

    Vertices are in the order in which the mesh was made (DOLFINx's `input_global_indices`),
    midpoints of edges are ordered by the two ends in that order, and cells by their vertices. So
    any number of ranks can read what another number wrote. All methods are collective.
    """

    def __init__(self, comm: MPI.Comm, space: fem.FunctionSpace) -> None:
        """Find the order of a space: linear or quadratic scalars, or constants in cells."""
        self.comm = comm
        points = vertices(space)
        self._owned = space.dofmap.index_map.size_local
        of_cells = space.dofmap.list.shape[1] == 1
        places = gather(comm, (_corners(space) if of_cells else _ends(space))[: self._owned])
        if places is not None:
            self._order = np.lexsort(np.concatenate(places).T)
            self._ends = np.cumsum([len(part) for part in places])[:-1]
        self.points = self.whole(points)

    def whole(self, values: np.ndarray) -> np.ndarray | None:
        """Return all values on rank 0, None elsewhere.

        Parameters
        ----------
        values : values of this rank, shape (n_local,) or (n_local, components); ghosts are left
            out.
        """
        parts = gather(self.comm, np.ascontiguousarray(values[: self._owned]))
        return None if parts is None else np.concatenate(parts)[self._order]

    def share(self, whole: np.ndarray | None) -> np.ndarray:
        """Return this rank's own values, from all values on rank 0."""
        parts = None
        if whole is not None:
            own = np.empty_like(whole)
            own[self._order] = whole
            parts = np.split(own, self._ends)
        return scatter(self.comm, parts)


def _corners(space: fem.FunctionSpace) -> np.ndarray:
    """Return the vertices of each cell in the order in which the mesh was made, sorted; (n, k)."""
    geometry = space.mesh.geometry
    return np.sort(geometry.input_global_indices[geometry.dofmaps[0]], axis=1)


def _ends(space: fem.FunctionSpace) -> np.ndarray:
    """Return the ends of each node's edge in the order of the mesh, ghosts included, shape (n, 2).

    For a vertex both are the vertex.
    """
    geometry, cells, element = space.mesh.geometry, space.dofmap.list, space.element.basix_element
    known = geometry.input_global_indices[geometry.dofmaps[0]]
    ends = np.zeros((len(vertices(space)), 2), dtype=np.int64)
    for entities, nodes in zip(
        basix.topology(element.cell_type)[:2], element.entity_dofs[:2], strict=True
    ):
        for corners, node in zip(entities, nodes, strict=True):
            for number in node:
                pair = known[:, [corners[0], corners[-1]]]
                ends[cells[:, number]] = np.sort(pair, axis=1)
    return ends
