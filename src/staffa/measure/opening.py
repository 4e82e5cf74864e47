"""How far cracks are open: the crack volume, -int u . grad alpha, and whose point's it is.

Across a crack alpha rises to 1 and falls again while u jumps by the opening w: the line integral of
-u . grad alpha across it is w . n (Bourdin, Chukwudozie, Yoshioka, SPE 159154, 2012).
"""

from itertools import product

import numpy as np
from scipy.spatial import cKDTree

# Points of the network that share a piece of volume: those farther away would get nothing.
NEIGHBORS = {2: 8, 3: 24}


def sliver(
    points: np.ndarray, cells: np.ndarray, *, u: np.ndarray, alpha: np.ndarray, dim: int
) -> tuple[np.ndarray, np.ndarray]:
    """Pieces of the crack volume -int u . grad alpha dx, cell by cell where alpha varies.

    Parameters
    ----------
    points, cells : shape (n, 3); shape (m, vertices), in VTK's order. u, alpha : at the points, of
        shape (n, 3) and (n,).

    Returns
    -------
    places : shape (k, 3). volumes : of the pieces, shape (k,); area in 2-D.
    """
    cells = cells[np.ptp(alpha[cells], axis=1) > 0]
    x = points[cells][..., :dim]
    places, volumes = [np.zeros((0, 3))], [np.zeros(0)]
    for shape, slopes, weight in _rule(dim, cells.shape[1]):
        jacobian = np.einsum("mvi,vj->mij", x, slopes)
        across = np.linalg.solve(
            np.swapaxes(jacobian, 1, 2), np.einsum("mv,vj->mj", alpha[cells], slopes)[..., None]
        )[..., 0]
        moved = np.einsum("mvi,v->mi", u[cells][..., :dim], shape)
        scale = weight * np.abs(np.linalg.det(jacobian))
        volumes.append(-scale * np.einsum("mi,mi->m", moved, across))
        places.append(np.einsum("mvi,v->mi", points[cells], shape))
    return np.concatenate(places), np.concatenate(volumes)


def shared(
    places: np.ndarray,
    volumes: np.ndarray,
    points: np.ndarray,
    sizes: np.ndarray,
    *,
    width: float,
    reach: float,
) -> np.ndarray:
    """The opening at each point of a network: its share of the volume around it over its size.

    A piece of volume goes to the points nearest to it, weighted by a Gaussian of the width along
    the crack, so that all that lies within reach is given away, and nothing twice.

    Parameters
    ----------
    places, volumes : the pieces. points, sizes : of the network, shape (n, 3) and (n,).
    """
    if not len(points):
        return np.zeros(0)
    dim = 3 if np.ptp(points[:, 2]) else 2
    count = min(NEIGHBORS[dim], len(points))
    distance, nearest = cKDTree(points).query(places, k=[*range(1, count + 1)])
    near = distance[:, 0] < reach
    distance, nearest = distance[near], nearest[near]
    beyond = distance**2 - distance[:, :1] ** 2  # the square of the way along the crack
    weight = sizes[nearest] * np.exp(-beyond / (2 * width**2))
    weight *= (volumes[near] / weight.sum(axis=1))[:, None]
    return np.bincount(nearest.ravel(), weights=weight.ravel(), minlength=len(points)) / sizes


def _rule(dim: int, width: int) -> list[tuple[np.ndarray, np.ndarray, float]]:
    """Shape functions, their slopes (vertices, dim) and the weight at each quadrature point.

    Exact for simplices; the Gauss rule of two points an axis for quadrilaterals and hexahedra.
    """
    if width == dim + 1:
        slopes = np.vstack([-np.ones(dim), np.eye(dim)])
        return [(np.full(width, 1 / width), slopes, {2: 1 / 2, 3: 1 / 6}[dim])]
    around = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])
    corners = around if dim == 2 else np.vstack([np.insert(around, 2, z, 1) for z in (-1, 1)])
    rule = []
    for xi in product((-(3**-0.5), 3**-0.5), repeat=dim):
        factors = (1 + corners * xi) / 2
        slopes = np.empty((width, dim))
        for k in range(dim):
            slopes[:, k] = corners[:, k] / 2 * np.delete(factors, k, axis=1).prod(axis=1)
        rule.append((factors.prod(axis=1), slopes, 1.0))
    return rule
