"""What holds the body, in numbers: the resultant force of each support."""

from staffa.backend.stack import MPI

import numpy as np

from staffa.backend.parallel import sum_over_ranks
from staffa.model.supports import Supports


def reactions(
    comm: MPI.Comm, supports: Supports, forces: np.ndarray, *, dim: int
) -> dict[str, tuple[float, ...]]:
    """The force that each held side exerts on the body: N, in 2-D per unit thickness (N/m).

    The sum of the energy's derivative in u over the components that a side prescribes. One that two
    sides prescribe, at a vertex they share, counts for the side whose displacement it follows, so
    that the sum over all sides is what the supports carry, and nothing counts twice. Collective.

    Parameters
    ----------
    forces : derivative of the energy in u, entries that this rank owns, in equilibrium.
    """
    names = list(dict.fromkeys(supports.sides))
    totals = np.zeros((len(names), dim))
    for side, (_, places) in zip(supports.sides, supports.displacements, strict=True):
        entries = supports.fixed[places]
        np.add.at(totals[names.index(side)], entries % dim, forces[entries])
    totals = sum_over_ranks(comm, totals)
    return {name: tuple(map(float, total)) for name, total in zip(names, totals, strict=True)}
