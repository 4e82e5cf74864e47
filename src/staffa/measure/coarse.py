"""Cracks in mesh cells too large for ell, and crack lengths by each cell's effective Gc."""

from dataclasses import dataclass

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
from dolfinx import fem

from staffa.backend.parallel import best_candidate, sum_over_ranks
from staffa.model.domain import Domain, local_edges, middles
from staffa.records.step import Coarse

RESOLVED = 3.0  # cells in ell that resolve a crack
# Edges of a mesh scatter: on a uniform mesh of size ell/3 hardly any cell exceeds this factor.
SCATTER = 1.25
MIDDLE = 0.5  # damage of a cell that is near the middle of a crack
LITTLE = 0.1  # part of the crack length in such cells up to which nothing is reported


@dataclass(frozen=True, kw_only=True)
class Local:
    """Mesh size and effective Gc of each cell that this rank owns, on a mesh of unequal cells.

    Attributes
    ----------
    edge : mean edge length of each cell (m), shape (n,); where a mesh follows the cracks, in
        proportion to it, and h of the finest cells.
    toughness : effective Gc over Gc of each cell, shape (n,).
    """

    edge: np.ndarray
    toughness: np.ndarray


def local(domain: Domain, factor: float) -> Local | None:
    """Return mesh size and effective Gc of each cell, or None if they are the same in all cells.

    Parameters
    ----------
    domain : the mesh.
    factor : effective Gc over Gc on cells of edge h; the excess over 1 grows in proportion to the
        edge.
    """
    if not domain.graded:
        return None
    edge = local_edges(domain)
    if domain.source:  # h is no mean edge there: the finest cells of a block have edges of 0.8 h
        edge *= domain.h / domain.source.finest
    return Local(edge=edge, toughness=1 + (factor - 1) * edge / domain.h)


def local_length(domain: Domain, spent: np.ndarray, cells: Local) -> float:
    """Return the crack length (m; in 3-D area, m^2) by each cell's effective Gc. Collective.

    Parameters
    ----------
    domain : the mesh.
    spent : surface energy over Gc in each cell, shape (n,) (m; m^2 in 3-D).
    cells : effective Gc of each cell.
    """
    return sum_over_ranks(domain.comm, float((spent / cells.toughness).sum()))


def coarse(
    domain: Domain, alpha: fem.Function, spent: np.ndarray, cells: Local, ell: float
) -> Coarse | None:
    """Return the record of cracks in cells larger than ell/3, or None if they are few. Collective.

    Only the half of the damage near the middle of a crack counts: beyond it cells may be larger.

    Parameters
    ----------
    domain : the mesh.
    alpha : the damage.
    spent : surface energy over Gc in each cell, shape (n,) (m; m^2 in 3-D).
    cells : mesh size and effective Gc of each cell.
    ell : regularization length (m).
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
    """Return the center of the cell with the longest cracks, and its region."""
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
