"""Points at which bodies of a mesh hang together, though they share no facet: hinges."""

import numpy as np
import scipy

from staffa.geometry.simplices import Simplices, facets, keys


def hinges(mesh: Simplices) -> tuple[np.ndarray, int]:
    """Return points shared by bodies without a common facet (m), (k, dim), and the number of
    bodies."""
    width, n_cells = mesh.cells.shape[1], len(mesh.cells)
    every = keys(facets(mesh.cells).reshape(-1, mesh.dim))
    order = np.argsort(every, kind="stable")
    same = every[order[1:]] == every[order[:-1]]
    start, end = order[:-1][same] // width, order[1:][same] // width
    links = scipy.sparse.coo_array(
        (np.ones(len(start), dtype=bool), (start, end)), shape=(n_cells, n_cells)
    )
    number, body = scipy.sparse.csgraph.connected_components(links, directed=False)
    first, last = np.full(len(mesh.x), number), np.full(len(mesh.x), -1)
    np.minimum.at(first, mesh.cells, body[:, None])
    np.maximum.at(last, mesh.cells, body[:, None])
    return mesh.x[first < last], int(number)
