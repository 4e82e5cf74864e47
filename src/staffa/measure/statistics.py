"""From points and edges to cracks: their tips, and the sections they cross."""

import numpy as np

from staffa.geometry.places import SAME
from staffa.records.step import CracksAtHeight, Tip


def cracks_on_line(
    x: np.ndarray, alpha: np.ndarray, *, height: float, threshold: float
) -> CracksAtHeight:
    """The cracks along a line: each run of neighboring samples with alpha > threshold is one.

    A run over more than half of the line is a damaged layer, and no crack.

    Parameters
    ----------
    x, alpha : coordinate along the line and damage of samples in any order, shape (n,).
    height : recorded with the result (m).
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
    """The deepest point of each crack, found from the deepest upwards.

    The crack set is a graph. Its points are met in order of falling depth; a point without a met
    neighbor starts a crack; where two cracks meet, the shallower one ends, and it counts if it is
    deeper than the meeting point by `prominence` or more (so that a rough edge makes no crack).
    Cracks that meet no other count if they are that long or longer.

    Parameters
    ----------
    points : shape (n, dim); depth : distance from the cooled face, shape (n,).
    edges : pairs of neighboring points, shape (m, 2).
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
    """Depth to which more than half of the body is cracked: a damaged layer, no crack yet.

    Parameters
    ----------
    cracked, points : number of cracked and of all points, by bins of depth of this width (m); the
        first bin is centered on the face.
    """
    whole = np.flatnonzero(2 * cracked <= points)
    bins = int(whole[0]) if len(whole) else len(points)
    return max(0.0, (bins - 0.5) * bin_depth)


def _neighbors(n: int, edges: np.ndarray) -> list[np.ndarray]:
    both = np.concatenate([edges, edges[:, ::-1]]) if len(edges) else np.zeros((0, 2), dtype=int)
    both = both[np.argsort(both[:, 0], kind="stable")]
    return np.split(both[:, 1], np.searchsorted(both[:, 0], np.arange(1, n)))
