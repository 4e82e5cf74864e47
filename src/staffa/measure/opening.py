"""How far cracks are open: the crack volume, int alpha^4 div u, and its share of each point.

Across a crack alpha rises to 1 and falls again while u jumps by w: the line integral of alpha div u
across it is the opening, w . n; by parts it is that of -u . grad alpha (Bourdin, Chukwudozie,
Yoshioka, SPE 159154, 2012), with the mouths of cracks on the surface. So is that of any power of
alpha; but beside the crack u strains too. In cooled rock that is 10 to 20 % of the volume; with
alpha^4, which is narrower, 1 %.
"""

from itertools import combinations, product

import numpy as np
from scipy.sparse import coo_array, diags_array
from scipy.sparse.linalg import spsolve
from scipy.spatial import cKDTree

from staffa.measure.network import normals

SHARPENED = 4
SHORTEST = 1e-3  # sides shorter than this, over the width, would only spoil the matrix


def sliver(
    points: np.ndarray, cells: np.ndarray, *, u: np.ndarray, alpha: np.ndarray, dim: int
) -> tuple[np.ndarray, np.ndarray]:
    """Pieces of the crack volume int alpha^4 div u dx, cell by cell where there is damage.

    Parameters
    ----------
    points, cells : shape (n, 3); shape (m, vertices), in VTK's order. u, alpha : at the points, of
        shape (n, 3) and (n,).

    Returns
    -------
    places : shape (k, 3). volumes : of the pieces, shape (k,); area in 2-D.
    """
    cells, sharp = cells[alpha[cells].max(axis=1) > 0], alpha**SHARPENED
    x = points[cells][..., :dim]
    places, volumes = [np.zeros((0, 3))], [np.zeros(0)]
    for shape, slopes, weight in _rule(dim, cells.shape[1]):
        jacobian = np.einsum("mvi,vj->mij", x, slopes)
        gradient = np.linalg.solve(
            np.swapaxes(jacobian, 1, 2), np.einsum("mvi,vj->mji", u[cells][..., :dim], slopes)
        )
        scale = weight * np.abs(np.linalg.det(jacobian))
        volumes.append(scale * (sharp[cells] @ shape) * np.einsum("mii->m", gradient))
        places.append(np.einsum("mvi,v->mi", points[cells], shape))
    return np.concatenate(places), np.concatenate(volumes)


def opening(
    places: np.ndarray,
    volumes: np.ndarray,
    points: np.ndarray,
    elements: np.ndarray,
    sizes: np.ndarray,
    *,
    width: float,
    reach: float,
) -> np.ndarray:
    """The opening (m) at each point of a network, whose integral is the volume within reach of it.

    Each piece of volume goes to the point nearest to it, V_i, if it is beside the crack and not
    beyond its end, where the rock may be broken all over. The opening is (M + width^2 K) w = V,
    with the lumped mass M and the stiffness K of the network: even over the width, without a
    change of the integral or of a constant.

    Parameters
    ----------
    places, volumes : the pieces. points, elements, sizes : of the network, (n, 3), (m, 2 or 3) and
        (m,).
    """
    n, corners = len(points), elements.shape[1]
    distance, nearest = cKDTree(points).query(places, distance_upper_bound=reach)
    near = np.isfinite(distance)
    near[near] = _beside(places[near], points[nearest[near]], points, elements) <= width
    gathered = np.bincount(nearest[near], weights=volumes[near], minlength=n)
    mass = np.bincount(elements.ravel(), weights=np.repeat(sizes / corners, corners), minlength=n)
    i, j = np.concatenate([elements[:, pair] for pair in combinations(range(corners), 2)]).T
    square = ((points[i] - points[j]) ** 2).sum(axis=1)
    # For segments the stiffness itself; for triangles that of equilateral ones, never negative.
    share = {2: 1.0, 3: 2 / 3}[corners] * np.tile(sizes, len(i) // len(sizes))
    tie = share / np.maximum(square, (SHORTEST * width) ** 2)
    ties = coo_array((np.tile(tie, 2), (np.append(i, j), np.append(j, i))), shape=(n, n)).tocsr()
    stiffness = diags_array(ties.sum(axis=1)) - ties
    return spsolve((diags_array(mass) + width**2 * stiffness).tocsc(), gathered)


def _beside(
    places: np.ndarray, nearest: np.ndarray, points: np.ndarray, elements: np.ndarray
) -> np.ndarray:
    """How far along the crack the places are from the points nearest to them."""
    element = cKDTree(points[elements].mean(axis=1)).query(places)[1]
    across = normals(points, elements)[element]
    offset = places - nearest
    return np.linalg.norm(offset - np.einsum("ij,ij->i", offset, across)[:, None] * across, axis=1)


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
