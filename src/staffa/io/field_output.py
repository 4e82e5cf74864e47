"""Brings distributed fields to rank 0 and into a file that ParaView reads."""

from collections.abc import Mapping
from pathlib import Path

from staffa.backend.stack import MPI

import numpy as np
from dolfinx import plot

from staffa.backend.parallel import gather, on_root
from staffa.io.vtkhdf import VERTICES, VtkMesh, write_vtkhdf
from staffa.model.fields import Spaces


class FieldWriter:
    """Writes fields on one mesh, whose points and cells are gathered once. Collective."""

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
        self,
        path: Path,
        at_vertices: Mapping[str, np.ndarray],
        in_cells: Mapping[str, np.ndarray] | None = None,
    ) -> None:
        """Write fields. Collective.

        Parameters
        ----------
        path : file to write.
        at_vertices : values at the vertices that this rank owns, shape (n, ...), by name.
        in_cells : values in the cells that this rank owns, shape (n, ...), by name.
        """
        parts = {name: gather(self.comm, values) for name, values in at_vertices.items()}
        cells = {name: gather(self.comm, values) for name, values in (in_cells or {}).items()}

        def put() -> None:
            assert self.grid is not None
            whole = {name: np.concatenate(part) for name, part in parts.items() if part}
            together = {name: np.concatenate(part) for name, part in cells.items() if part}
            write_vtkhdf(path, self.grid, whole, together)

        on_root(self.comm, put)
