"""Values of the fields at chosen points of the body."""

from collections.abc import Sequence

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
from dolfinx import geometry

from staffa.backend.parallel import sum_over_ranks
from staffa.errors import InputError
from staffa.model.domain import Domain
from staffa.model.fields import State
from staffa.records.manifest import Probe

# A point on a boundary may lie outside the mesh by round-off: by this fraction of a cell.
OUTSIDE = 1e-6


def located(domain: Domain, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the points that lie in this rank's own cells, and the cell of each.

    A point on the border of two ranks' cells is found by both, which agree on its values.

    Parameters
    ----------
    domain : the mesh.
    points : coordinates (m), shape (n, 3).

    Returns
    -------
    here : numbers of the points found, shape (k,).
    cells : local cell of each, shape (k,).
    """
    mesh, dim = domain.mesh, domain.dim
    own = np.arange(mesh.topology.index_map(dim).size_local, dtype=np.int32)
    tree = geometry.bb_tree(mesh, dim, padding=OUTSIDE * domain.h, entities=own)
    near = geometry.compute_collisions_points(tree, points)
    hit = geometry.compute_colliding_cells(mesh, near, points)
    here = np.flatnonzero(np.diff(hit.offsets))
    return here, hit.array[hit.offsets[:-1][here]]


class Probes:
    """Values of the fields at the points of probes, which are found once. Collective."""

    def __init__(self, domain: Domain, probes: Sequence[Probe]) -> None:
        """Find the points. Collective.

        Parameters
        ----------
        domain : the mesh.
        probes : the probes of the case.

        Raises
        ------
        InputError
            A point is in no cell.
        """
        self.comm, self.probes = domain.comm, tuple(probes)
        points = np.array([p for probe in probes for p in probe.points], dtype=float)
        self.points = np.pad(points.reshape(-1, domain.dim), ((0, 0), (0, 3 - domain.dim)))
        self.here, self.cells = located(domain, self.points)
        counts = np.bincount(self.here, minlength=len(self.points))
        self.seen = sum_over_ranks(self.comm, counts.astype(float))
        self._require_all()

    def _require_all(self) -> None:
        missing = np.flatnonzero(self.seen == 0)
        if not len(missing):
            return
        names = np.repeat([p.name for p in self.probes], [len(p.points) for p in self.probes])
        x, y, z = self.points[missing[0]]
        raise InputError(
            f"output.probes: '{names[missing[0]]}' has a point at ({x:g}, {y:g}, {z:g}), which is "
            f"in no cell of the mesh; move it into the body"
        )

    def __call__(self, state: State) -> tuple[tuple[float, ...], ...]:
        """Return T (K), the components of u (m), and alpha at each point of each probe. Collective.

        T is the change from the temperature without thermal strain.
        """
        dim = state.u.function_space.mesh.geometry.dim
        values = np.zeros((len(self.points), dim + 2))
        if len(self.here):
            at = self.points[self.here]
            found = [f.eval(at, self.cells) for f in (state.T, state.u, state.alpha)]
            values[self.here] = np.column_stack([f.reshape(len(at), -1) for f in found])
        values = sum_over_ranks(self.comm, values) / self.seen[:, None]
        return tuple(tuple(map(float, row)) for row in values)
