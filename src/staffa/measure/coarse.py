"""Cracks in cells that are too long for them, and lengths by the toughness of each cell."""

from dataclasses import dataclass

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
from dolfinx import fem

from staffa.backend.parallel import best_candidate, sum_over_ranks
from staffa.model.domain import Domain, local_edges, middles
from staffa.records.step import Coarse

RESOLVED = 3.0  # cells in ell that resolve a crack
# Edges of one mesh scatter: in one of even edges ell/3 long hardly any cell is longer than this.
SCATTER = 1.25
MIDDLE = 0.5  # damage of a cell that is near the middle of a crack
LITTLE = 0.1  # of the cracks' length in such cells, of which nothing is said


@dataclass(frozen=True, kw_only=True)
class Local:
    """The cells of a mesh whose edges differ: of each that this rank owns the mean edge (m) and the
    discrete toughness over Gc, shape (n,)."""

    edge: np.ndarray
    toughness: np.ndarray


def local(domain: Domain, factor: float) -> Local | None:
    """Known numbers of each cell; None where one number is true of all.

    factor: the discrete toughness over Gc of cells of edge h; what is above 1 grows like the edge.
    """
    if not domain.graded:
        return None
    edge = local_edges(domain)
    return Local(edge=edge, toughness=1 + (factor - 1) * edge / domain.h)


def local_length(domain: Domain, spent: np.ndarray, cells: Local) -> float:
    """The length of cracks (m; in 3-D area), each cell's by its own toughness. Collective.

    spent: surface energy over Gc in each cell, shape (n,).
    """
    return sum_over_ranks(domain.comm, float((spent / cells.toughness).sum()))


def coarse(
    domain: Domain, alpha: fem.Function, spent: np.ndarray, cells: Local, ell: float
) -> Coarse | None:
    """The cracks in cells longer than ell/3; None if they are few. Collective.

    Of a crack's damage the half near its middle counts: beyond, cells may well get longer.
    """
    damage = alpha.x.array[alpha.function_space.dofmap.list[: len(spent)]].mean(axis=1)
    spent = np.where(damage > MIDDLE, spent, 0.0)
    here = np.where(cells.edge > SCATTER * ell / RESOLVED, spent, 0.0)
    sums = [spent.sum(), here.sum(), here @ cells.edge, here @ cells.toughness]
    total, much, edge, toughness = sum_over_ranks(domain.comm, np.array(sums))
    if much <= LITTLE * total or total <= 0:
        return None
    place, region = _worst(domain, here)
    return Coarse(
        share=float(much / total),
        edge=float(edge / much),
        toughness=float(toughness / much),
        place=place,
        region=region,
    )


def _worst(domain: Domain, here: np.ndarray) -> tuple[tuple[float, ...], str]:
    """The middle of the cell with most cracks, and its region."""
    mine = None
    if len(here) and here.max() > 0:
        cell = int(np.argmax(here))
        regions = [name for name, cells in domain.regions.items() if np.isin(cell, cells)]
        middle = middles(domain.mesh)[: domain.dim, cell]
        mine = (float(here[cell]), *middle.tolist(), *regions[:1])
    found = best_candidate(domain.comm, mine)
    assert found is not None, "some cell has cracks"
    dim = domain.dim
    return tuple(found[1 : 1 + dim]), str(found[1 + dim]) if len(found) > 1 + dim else ""
