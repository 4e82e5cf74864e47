"""Cells that break with a crack on facets of the mesh: one layer, on one side of the crack."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from staffa.geometry.simplices import facets, keys


def cells_along_crack(cells: np.ndarray, crack: np.ndarray) -> np.ndarray:
    """Return the numbers of the cells that a crack breaks: all that touch it from one side.

    A vertex of a crack is inside it, and not on its rim, if the crack parts the cells around it.
    The cells at such vertices, walked through facets that are no crack, fall into its sides. The
    side with the fewest cells breaks; where cracks meet, as many as it takes for every facet to
    have a broken one. No cell is then left to hold the two sides together, be it by a vertex, and
    the layer is one cell thick. A facet that is all rim breaks one more cell.

    Parameters
    ----------
    cells : corners, shape (m, dim + 1).
    crack : corners of its facets, shape (k, dim).
    """
    near = np.flatnonzero(np.isin(cells, crack).any(axis=1))
    pairs, corners, cracked = _shared_facets(cells[near], crack)
    inner = _parted(cells[near], crack, pairs[~cracked], corners[~cracked])
    walked = ~cracked & np.isin(corners, inner).any(axis=1)
    side = _components(len(near), pairs[walked])
    beside, reached = pairs[cracked], np.isin(corners[cracked], inner).any(axis=1)
    at_inner = np.isin(cells[near], inner).any(axis=1)
    chosen = _cover(side[beside[reached]], np.bincount(side[at_inner], minlength=len(near)))
    broken = at_inner & np.isin(side, chosen)
    broken[beside[~reached, 0]] = True
    return near[broken]


def _shared_facets(cells: np.ndarray, crack: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the facets between two cells: the cells (k, 2), corners, True for those of a crack."""
    width = cells.shape[1]
    corners = facets(cells).reshape(-1, width - 1)
    number = keys(np.concatenate([corners, crack]))
    theirs, cracks = number[: len(corners)], number[len(corners) :]
    order = np.argsort(theirs, kind="stable")
    twice = np.flatnonzero(theirs[order][1:] == theirs[order][:-1])
    one, two = order[twice], order[twice + 1]
    pairs = np.column_stack([one, two]) // width
    return pairs, corners[one], np.isin(theirs[one], cracks)


def _parted(
    cells: np.ndarray, crack: np.ndarray, pairs: np.ndarray, corners: np.ndarray
) -> np.ndarray:
    """Return the crack's vertices around which no walk through these facets reaches all cells."""
    cell, place = np.nonzero(np.isin(cells, crack))
    vertex = cells[cell, place]
    n = int(cells.max()) + 1
    meeting = cell * n + vertex
    order = np.argsort(meeting)
    facet, place = np.nonzero(np.isin(corners, crack))
    at = corners[facet, place]
    wanted = pairs[facet] * n + at[:, None]
    group = _components(len(cell), order[np.searchsorted(meeting, wanted, sorter=order)])
    found = np.unique(np.column_stack([vertex, group]), axis=0)[:, 0]
    names, count = np.unique(found, return_counts=True)
    return names[count > 1]


def _components(n: int, links: np.ndarray) -> np.ndarray:
    one, two = links.T
    graph = coo_array((np.ones(len(one), dtype=bool), (one, two)), shape=(n, n))
    return np.asarray(connected_components(graph, directed=False)[1])


def _cover(beside: np.ndarray, weight: np.ndarray) -> list[int]:
    """Return as few sides as give one to each facet, the one with most facets first."""
    chosen: list[int] = []
    while len(beside):
        names, count = np.unique(beside, return_counts=True)
        best = max(zip(count, -weight[names], -names, strict=True))
        chosen.append(int(-best[2]))
        beside = beside[(beside != chosen[-1]).all(axis=1)]
    return chosen
