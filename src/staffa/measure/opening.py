"""Openings of cracks at each point of their network.

The integral of the opening strain (see `model.openings`) over the body is the crack volume. Each
part of it belongs to the nearest point of the network.
"""

from itertools import combinations, product

import numpy as np
from scipy.sparse import coo_array, diags_array
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree

# Distance (in ell) from a crack at which its damage ends (AT1), or is 0.14 (AT2).
REACH = 2.0
EVENED = 0.5  # length (in ell) over which an opening is averaged
SHORTEST = 1e-3  # sides shorter than this, over the width, would only spoil the matrix


def cell_pieces(
    points: np.ndarray, cells: np.ndarray, strains: np.ndarray, dim: int
) -> tuple[np.ndarray, np.ndarray]:
    """Integrate strains over the parts of each cell in which the first strain is not 0.

    Parameters
    ----------
    points : coordinates of the mesh (m), shape (n, 3).
    cells : vertices of each cell in VTK's order, shape (m, vertices).
    strains : strains of each cell, shape (m, k).
    dim : 2 or 3.

    Returns
    -------
    places : positions of the parts (m), shape (p, 3).
    volumes : integrals, shape (p, k) (m^3; m^2 in 2-D).
    """
    open_ = strains[:, 0] != 0
    cells, strains = cells[open_], strains[open_]
    x = points[cells][..., :dim]
    places, volumes = [np.zeros((0, 3))], [np.zeros((0, strains.shape[1]))]
    for shape, slopes, weight in _rule(dim, cells.shape[1]):
        jacobian = np.einsum("mvi,vj->mij", x, slopes)
        volumes.append((weight * np.abs(np.linalg.det(jacobian)))[:, None] * strains)
        places.append(np.einsum("mvi,v->mi", points[cells], shape))
    return np.concatenate(places), np.concatenate(volumes)


def openings(
    places: np.ndarray,
    volumes: np.ndarray,
    points: np.ndarray,
    elements: np.ndarray,
    sizes: np.ndarray,
    *,
    h: float,
    ell: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the opening (m) at each point of a network, and its uncertainty (m), shape (n,) each.

    Each part of the volume goes to the nearest point, if it lies beside the crack and not beyond
    its end, where rock may be broken throughout. The uncertainty has two parts. First, the strain
    of intact rock need not be uniform across the band: the opening would change by the difference
    between the inner and the outer half, times 4 ell, if the strain at the band's edge held
    everywhere. Second, opening strain in rock that is not broken may be no opening.

    Parameters
    ----------
    places : positions of the parts (m), shape (p, 3).
    volumes : integrals over the parts, shape (p, 4): of the opening strain, of the strain of intact
        rock, of the opening strain's size in rock that is not broken, and of 1.
    points : points of the network (m), shape (n, 3).
    elements : points of each element, shape (m, 2 or 3).
    sizes : length or area of each element, shape (m,).
    h : mesh size (m).
    ell : regularization length (m).
    """
    distance, nearest = cKDTree(points).query(places, distance_upper_bound=REACH * ell + h)
    near = np.isfinite(distance)
    offset = places[near] - points[nearest[near]]
    near[near] = np.einsum("ij,ij->i", offset, outward(points, elements)[nearest[near]]) <= 0
    volumes, nearest = volumes[near], nearest[near]
    outer = (distance[near] > REACH / 2 * ell)[:, None]
    halves = np.hstack([np.where(outer, 0, volumes[:, [1, 3]]), volumes[:, [1, 3]] * outer])
    columns = np.hstack([volumes[:, [0, 2]], halves]).T
    gathered = [np.bincount(nearest, weights=column, minlength=len(points)) for column in columns]
    even = evened(np.stack(gathered, axis=1), points, elements, sizes, EVENED * ell)
    opening, soft, inner, inner_size, outer, outer_size = even.T
    known = np.minimum(inner_size, outer_size) > h
    uneven = inner / np.where(known, inner_size, 1) - outer / np.where(known, outer_size, 1)
    return opening, np.abs(soft) + 2 * REACH * ell * np.where(known, np.abs(uneven), 0)


def evened(
    gathered: np.ndarray, points: np.ndarray, elements: np.ndarray, sizes: np.ndarray, width: float
) -> np.ndarray:
    """Return values per size of the network, averaged over a width, shape (n, k).

    The result w solves (M + width^2 K) w = V, with the lumped mass M and the stiffness K of the
    network. The integral and a constant do not change. Points without a size have the value 0, also
    those of triangles whose area is nothing beside the square of the width.

    Parameters
    ----------
    gathered : V, the values that the points gathered, shape (n, k).
    points : points of the network (m), shape (n, 3).
    elements : points of each element, shape (m, 2 or 3).
    sizes : length or area of each element, shape (m,).
    width : length over which values are averaged (m).
    """
    n, corners = len(points), elements.shape[1]
    if corners == 3:  # the corners of a triangle without area may hang on nothing else
        wide = sizes > (SHORTEST * width) ** 2
        elements, sizes = elements[wide], sizes[wide]
    mass = np.bincount(elements.ravel(), weights=np.repeat(sizes / corners, corners), minlength=n)
    i, j = np.concatenate([elements[:, pair] for pair in combinations(range(corners), 2)]).T
    square = ((points[i] - points[j]) ** 2).sum(axis=1)
    # For segments the exact stiffness; for triangles that of equilateral ones, which is never < 0.
    share = {2: 1.0, 3: 2 / 3}[corners] * np.tile(sizes, len(i) // len(sizes))
    tie = share / np.maximum(square, (SHORTEST * width) ** 2)
    ties = coo_array((np.tile(tie, 2), (np.append(i, j), np.append(j, i))), shape=(n, n)).tocsr()
    stiffness = diags_array(ties.sum(axis=1)) - ties
    # A point of no element, or of one without size, has no mean: its value is 0.
    empty = mass == 0
    found = splu((diags_array(mass + empty) + width**2 * stiffness).tocsc()).solve(gathered)
    return np.where(empty[:, None], 0.0, found)


def outward(points: np.ndarray, elements: np.ndarray) -> np.ndarray:
    """Return the outward vectors at the ends or edges of a network; 0 elsewhere; shape (n, 3).

    A vector lies in the network and points out of it.

    Parameters
    ----------
    points : points of the network (m), shape (n, 3).
    elements : points of each element, shape (m, 2 or 3).
    """
    corners, m = elements.shape[1], len(elements)
    sides = np.concatenate([np.delete(elements, k, axis=1) for k in range(corners)])
    opposite = points[elements.T.ravel()]
    _, number, counts = np.unique(
        np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    free = counts[number.reshape(corners * m)] == 1
    sides, opposite = sides[free], opposite[free]
    out = points[sides[:, 0]] - opposite
    if corners == 3:
        along = points[sides[:, 1]] - points[sides[:, 0]]
        square = np.maximum(np.einsum("ij,ij->i", along, along), np.finfo(float).tiny)
        out -= (np.einsum("ij,ij->i", out, along) / square)[:, None] * along
    found = np.zeros_like(points)
    for column in sides.T:
        np.add.at(found, column, out)
    return found


def _rule(dim: int, width: int) -> list[tuple[np.ndarray, np.ndarray, float]]:
    """Return shape functions, their slopes (vertices, dim) and the weight at each quadrature point.

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
