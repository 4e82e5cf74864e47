"""Output of a distributed state: gathered on rank 0, written to a file for ParaView."""

from collections.abc import Mapping
from pathlib import Path

from staffa.backend.stack import MPI

import numpy as np
from dolfinx import plot

from staffa.backend.parallel import gather, on_root
from staffa.io.vtkhdf import VERTICES, VtkMesh, write_vtkhdf
from staffa.model.fields import Spaces, State, at_vertices, owned


class FieldWriter:
    """Writer of states on one mesh, whose points and cells are gathered once. Collective."""

    def __init__(self, comm: MPI.Comm, spaces: Spaces) -> None:
        self.comm, self.spaces = comm, spaces
        index_map = spaces.alpha.dofmap.index_map
        cells, types, x = plot.vtk_mesh(spaces.alpha)
        kind = int(comm.allreduce(int(types[0]) if len(types) else 0, op=MPI.MAX))
        width = VERTICES[kind]
        local = cells.reshape(-1, width + 1)[:, 1:]
        everywhere = index_map.local_to_global(local.ravel().astype(np.int32)).reshape(-1, width)
        points = gather(comm, x[: index_map.size_local])
        connected = gather(comm, everywhere)
        self.grid = None
        if points is not None and connected is not None:
            self.grid = VtkMesh(
                points=np.concatenate(points), cells=np.concatenate(connected), type=kind
            )

    def write(
        self, path: Path, state: State, in_cells: Mapping[str, np.ndarray] | None = None
    ) -> None:
        """Write u (m, three components), alpha and T (K) of a state at the vertices. Collective.

        Parameters
        ----------
        path : the file.
        state : the fields.
        in_cells : values in the cells that this rank owns, shape (n_owned, ...), by name.
        """
        u = at_vertices(state.u, self.spaces)
        local = {
            "u": np.pad(u, ((0, 0), (0, 3 - u.shape[1]))),
            "alpha": owned(state.alpha).copy(),
            "T": owned(state.T).copy(),
        }
        parts = {name: gather(self.comm, values) for name, values in local.items()}
        cells = {name: gather(self.comm, values) for name, values in (in_cells or {}).items()}

        def put() -> None:
            assert self.grid is not None
            whole = {name: np.concatenate(part) for name, part in parts.items() if part}
            together = {name: np.concatenate(part) for name, part in cells.items() if part}
            write_vtkhdf(path, self.grid, whole, together)

        on_root(self.comm, put)
