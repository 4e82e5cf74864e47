"""Junctions and ends of a 2-D crack network: stubs are removed, gaps at junctions closed."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

from staffa.measure.network import Network, selected

# Largest gap (in ell) between the end of a ridge and the ridge that it would meet.
GAP = 1.5


def pruned(found: Network, crack: float, ell: float) -> Network:
    """Return the network without stubs.

    A stub leaves another branch and ends, and is shorter than ell or nowhere as damaged as a crack.

    Parameters
    ----------
    found : the network.
    crack : damage that a crack reaches somewhere.
    ell : regularization length (m).
    """
    while len(found.elements):
        degree = np.bincount(found.elements.ravel(), minlength=len(found.points))
        ends = degree[found.elements]
        free, forked = (ends == 1).any(axis=1), (ends > 2).any(axis=1)
        count = found.branches.max() + 1
        length = np.bincount(found.branches, weights=found.sizes, minlength=count)
        most = largest_damage(found, found.branches)
        stub = np.bincount(found.branches, weights=free, minlength=count) > 0
        stub &= np.bincount(found.branches, weights=forked, minlength=count) > 0
        stub &= (length < ell) | (most < crack)
        if not stub.any():
            break
        found = selected(found, found.elements[~stub[found.branches]])
    return found


def joined(found: Network, crack: float, ell: float) -> Network:
    """Join free ends to near branches across broken rock.

    Two near points are joined by a straight segment, several in their middle.

    Parameters
    ----------
    found : the network.
    crack : damage from which rock is broken.
    ell : regularization length (m).
    """
    degree = np.bincount(found.elements.ravel(), minlength=len(found.points))
    ends = np.flatnonzero((degree == 1) & (found.damage >= crack))
    if not len(ends):
        return found
    links = _links(found, ends, ell)
    if not len(links):
        return found
    n = len(found.points)
    graph = coo_array((np.ones(len(links)), links.T), shape=(n, n))
    label = connected_components(graph, directed=False)[1]
    points, elements = [found.points], [found.elements]
    for number in np.unique(label[links[:, 0]]):
        members = np.flatnonzero(label == number)
        if len(members) == 2:
            elements.append(members[None, :])
            continue
        middle = n + len(points) - 1
        points.append(found.points[members].mean(axis=0, keepdims=True))
        elements.append(np.column_stack([members, np.full(len(members), middle)]))
    more = len(points) - 1
    return Network(
        points=np.concatenate(points),
        elements=np.concatenate(elements),
        damage=np.append(found.damage, np.ones(more)),
    )


def _links(found: Network, ends: np.ndarray, ell: float) -> np.ndarray:
    """Pair each free end with the nearest point ahead that is not near along the crack, (k, 2)."""
    n, (i, j) = len(found.points), found.elements.T
    graph = coo_array((np.maximum(found.sizes, 1e-12 * ell), (i, j)), shape=(n, n)).tocsr()
    away = dijkstra(graph, directed=False, indices=ends, limit=3 * GAP * ell)
    tree = cKDTree(found.points)
    links = []
    for end, along in zip(ends, away, strict=True):
        behind = np.argmin(np.where(along > ell / 2, along, np.inf))
        forward = found.points[end] - found.points[behind]
        near = np.array(tree.query_ball_point(found.points[end], GAP * ell))
        near = near[~np.isfinite(along[near])]
        offset = found.points[near] - found.points[end]
        ahead = offset @ forward > 0
        if ahead.any():
            distance = np.linalg.norm(offset[ahead], axis=1)
            links.append((end, near[ahead][np.argmin(distance)]))
    return np.array(links, dtype=np.int64).reshape(-1, 2)


def largest_damage(found: Network, label: np.ndarray) -> np.ndarray:
    """Return the largest damage among the elements of each label.

    Parameters
    ----------
    found : the network.
    label : number from 0 for each element, shape (m,).
    """
    most = np.zeros(label.max() + 1)
    np.maximum.at(most, label, found.damage[found.elements].max(axis=1))
    return most
