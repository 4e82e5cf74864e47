"""Cracks from points and edges: their tips, and their number on a line."""

import numpy as np

from staffa.geometry.places import SAME
from staffa.records.step import CracksAtHeight, Tip


def cracks_on_line(
    x: np.ndarray, alpha: np.ndarray, *, height: float, threshold: float
) -> CracksAtHeight:
    """Find the cracks along a line: each run of neighboring samples with alpha > threshold is one.

    A run over more than half of the line is a damaged layer, and no crack.

    Parameters
    ----------
    x : coordinate of the samples along the line, in any order (m), shape (n,).
    alpha : damage of the samples, shape (n,).
    height : depth of the line, recorded with the result (m).
    threshold : damage above which a sample is cracked.
    """
    order = np.argsort(x, kind="stable")
    x, cracked = x[order], (alpha[order] > threshold).astype(np.int8)
    jumps = np.diff(np.concatenate([[0], cracked, [0]]))
    starts, ends = np.flatnonzero(jumps == 1), np.flatnonzero(jumps == -1) - 1
    narrow = (
        x[ends] - x[starts] <= (1 + SAME) * np.ptp(x) / 2 if len(x) else np.zeros(0, dtype=bool)
    )
    positions = (x[starts[narrow]] + x[ends[narrow]]) / 2
    spacing = float(np.diff(positions).mean()) if len(positions) > 1 else None
    return CracksAtHeight(
        height=height,
        cracks=len(positions),
        spacing=spacing,
        positions=tuple(float(p) for p in positions),
    )


def tips(
    points: np.ndarray, depth: np.ndarray, edges: np.ndarray, *, prominence: float
) -> tuple[Tip, ...]:
    """Find the deepest point of each crack, in order from the deepest upwards.

    The crack set is a graph. Its points are visited in order of decreasing depth. A point without a
    visited neighbor starts a crack. If two cracks meet, the shallower one ends there, and it counts
    if it is deeper than the meeting point by `prominence` or more, so that a rough edge is no
    crack. A crack that meets no other counts if it is at least that long.

    Parameters
    ----------
    points : coordinates of the cracked points (m), shape (n, dim).
    depth : distance from the cooled face (m), shape (n,).
    edges : pairs of neighboring points, shape (m, 2).
    prominence : least length of a crack (m).
    """
    place = np.rint(np.column_stack([points, -depth]) / (SAME * prominence))
    order = np.lexsort(place.T)
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    neighbors = _neighbors(len(points), edges)
    crack = np.full(len(points), -1)  # for each point, one nearer to its crack's tip; a forest
    found: list[int] = []

    def root(i: int) -> int:
        while crack[i] != i:
            crack[i] = crack[crack[i]]
            i = int(crack[i])
        return i

    for i in order:
        crack[i] = i
        for j in neighbors[i]:
            if crack[j] < 0:
                continue
            deep, shallow = sorted((root(int(i)), root(int(j))), key=lambda k: rank[k])
            if deep != shallow:
                if depth[shallow] - depth[i] >= (1 - SAME) * prominence:
                    found.append(shallow)
                crack[shallow] = deep
    shallowest = np.full(len(points), np.inf)
    for i in range(len(points)):
        top = root(i)
        shallowest[top] = min(shallowest[top], depth[i])
    long = depth - shallowest >= (1 - SAME) * prominence
    found += [i for i in range(len(points)) if crack[i] == i and long[i]]
    found.sort(key=lambda k: tuple(points[k]))
    return tuple(
        Tip(position=tuple(float(c) for c in points[k]), depth=float(depth[k])) for k in found
    )


def layer_depth(cracked: np.ndarray, points: np.ndarray, *, bin_depth: float) -> float:
    """Return the depth (m) to which more than half of the body is cracked: the damaged layer.

    Parameters
    ----------
    cracked : number of cracked points in each bin of depth, shape (n,).
    points : number of all points in each bin, shape (n,).
    bin_depth : width of a bin (m); the first bin is centered on the face.
    """
    whole = np.flatnonzero(2 * cracked <= points)
    bins = int(whole[0]) if len(whole) else len(points)
    return max(0.0, (bins - 0.5) * bin_depth)


def _neighbors(n: int, edges: np.ndarray) -> list[np.ndarray]:
    both = np.concatenate([edges, edges[:, ::-1]]) if len(edges) else np.zeros((0, 2), dtype=int)
    both = both[np.argsort(both[:, 0], kind="stable")]
    return np.split(both[:, 1], np.searchsorted(both[:, 0], np.arange(1, n)))
