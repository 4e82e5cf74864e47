"""Reactions: the resultant force of each support."""

from staffa.backend.stack import MPI

import numpy as np

from staffa.backend.parallel import sum_over_ranks
from staffa.model.supports import Supports


def reactions(
    comm: MPI.Comm, supports: Supports, forces: np.ndarray, *, dim: int
) -> dict[str, tuple[float, ...]]:
    """Return the force that each support exerts on the body (N; N/m in 2-D). Collective.

    It is the sum of the energy's derivative in u over the components that a boundary prescribes. A
    component that two boundaries prescribe, at a common vertex, counts for the boundary whose value
    it follows. So the sum over all boundaries is the total force of the supports.

    Parameters
    ----------
    comm : communicator of the mesh.
    supports : the supports.
    forces : derivative of the energy in u in equilibrium, entries that this rank owns, shape (n,).
    dim : 2 or 3.
    """
    names = list(dict.fromkeys(supports.sides))
    totals = np.zeros((len(names), dim))
    for side, (_, places) in zip(supports.sides, supports.displacements, strict=True):
        entries = supports.fixed[places]
        np.add.at(totals[names.index(side)], entries % dim, forces[entries])
    totals = sum_over_ranks(comm, totals)
    return {name: tuple(map(float, total)) for name, total in zip(names, totals, strict=True)}
