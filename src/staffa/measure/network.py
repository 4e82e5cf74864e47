"""The crack network of a damage field: polylines in 2-D, triangles in 3-D, each point's opening."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.ndimage import distance_transform_edt, map_coordinates
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, dijkstra
from scipy.spatial import cKDTree

from staffa.measure.opening import opening, sliver
from staffa.measure.ridge import crest

# The Gaussian that takes the steps of a layer of cells out of a crack: fractions of ell.
SMOOTHING = 0.5
# A crest bends down by more than this over ell^2; that of a straight crack by 1.1 (AT1), smoothed.
SHARPEST = 0.2
# What is farther from a crack than so many ell is none of its opening.
REACH = 2.0
# By how much (radians) a crack turns between where it is broken and its tip.
TURN = 0.6
# Crests end this many ell at most before they would meet; a crest's end is bridged to another.
GAP = 1.5


@dataclass(frozen=True, kw_only=True)
class Network:
    """The cracks of one state.

    points: shape (n, 3). elements: the points of each segment, shape (m, 2), or of each triangle,
    shape (m, 3). damage, opening (m): at the points. The opening between points is linear, and
    so its integral over the network is the crack volume.
    """

    points: np.ndarray
    elements: np.ndarray
    damage: np.ndarray
    opening: np.ndarray

    @cached_property
    def sizes(self) -> np.ndarray:
        """Length of each segment (m), area of each triangle (m^2)."""
        return sizes(self.points, self.elements)

    @cached_property
    def cracks(self) -> np.ndarray:
        """To which crack each element belongs, all that is joined being one; the largest is 0."""
        return _parts(self.elements, self.sizes)

    @cached_property
    def branches(self) -> np.ndarray:
        """To which branch each segment belongs: from tip or junction to the next (2-D)."""
        return _branches(self.elements, len(self.points))

    @property
    def size(self) -> float:
        """Length of all (m), or area (m^2)."""
        return float(self.sizes.sum())

    @property
    def volume(self) -> float:
        """Integral of the opening: area in 2-D (m^2), volume in 3-D (m^3)."""
        return float(self.sizes @ self.opening[self.elements].mean(axis=1))


def network(
    points: np.ndarray,
    cells: np.ndarray,
    *,
    alpha: np.ndarray,
    u: np.ndarray,
    dim: int,
    h: float,
    ell: float,
    crack: float,
    tip: float,
) -> Network:
    """The network of the fields on a mesh.

    Parameters
    ----------
    points, cells : shape (n, 3); shape (m, vertices), in VTK's order. alpha, u : at the points,
        u of shape (n, 3). dim : 2 or 3. h, ell : cell edge, regularization length (m).
    crack : the damage that a crack reaches somewhere; tip : down to which it is followed.
    """
    found = _crest(points, cells, alpha, dim=dim, h=h, ell=ell, tip=tip)
    found = _steady(_clipped(found, tip, dim), crack)
    found = _kept(found, crack, ell)
    if dim == 2:
        found = _joined(_pruned(found, crack, ell), ell, crack)
    at, volumes = sliver(points, cells, u=u, alpha=alpha, dim=dim)
    if not len(found.points):
        return found
    drawn = (found.points, found.elements, found.sizes)
    reach = max(REACH * ell, 2 * h)
    return replace(found, opening=opening(at, volumes, *drawn, width=SMOOTHING * ell, reach=reach))


def sizes(points: np.ndarray, elements: np.ndarray) -> np.ndarray:
    """Length of each segment, area of each triangle, shape (m,)."""
    sides = points[elements[:, 1:]] - points[elements[:, :1]]
    if elements.shape[1] == 2:
        return np.linalg.norm(sides[:, 0], axis=1)
    return np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2


def normals(points: np.ndarray, elements: np.ndarray) -> np.ndarray:
    """A unit vector across each element, shape (m, 3)."""
    sides = points[elements[:, 1:]] - points[elements[:, :1]]
    other = sides[:, 1] if elements.shape[1] == 3 else np.array([0.0, 0.0, 1.0])
    across = np.cross(sides[:, 0], other)
    return across / np.maximum(np.linalg.norm(across, axis=1), np.finfo(float).tiny)[:, None]


def polylines(found: Network) -> list[np.ndarray]:
    """The points of each branch of a 2-D network, one after the other."""
    lines = []
    order = np.argsort(found.branches, kind="stable")
    starts = np.flatnonzero(np.diff(found.branches[order], prepend=-1))
    for members in np.split(order, starts[1:]) if len(order) else []:
        lines.append(_walk(found.elements[members]))
    return lines


def _walk(segments: np.ndarray) -> np.ndarray:
    """The points of a chain of segments in order, from an end of it; a ring closes on itself."""
    ways: dict[int, list[int]] = {}
    for number, segment in enumerate(segments.tolist()):
        for point in segment:
            ways.setdefault(point, []).append(number)
    at = min(ways, key=lambda point: (len(ways[point]), point))
    line, left = [at], set(range(len(segments)))
    while onward := [number for number in ways[at] if number in left]:
        left.remove(onward[0])
        i, j = segments[onward[0]].tolist()
        at = j if at == i else i
        line.append(at)
    return np.array(line)


def _crest(
    points: np.ndarray,
    cells: np.ndarray,
    alpha: np.ndarray,
    *,
    dim: int,
    h: float,
    ell: float,
    tip: float,
) -> Network:
    """The crest of the damage, with the damage on it; no opening yet."""
    origin, edge, field = _raster(points, cells, alpha, dim, h)
    found, elements = crest(
        field,
        sigma=max(SMOOTHING * ell / h, 1.0),
        lowest=tip / 2,  # smoothing lowers the damage: what is too much is clipped
        sharpest=SHARPEST * (h / ell) ** 2,
    )
    at = np.zeros((len(found), 3))
    at[:, :dim] = origin[:dim] + found * edge[:dim]
    damage = map_coordinates(field, found.T, order=1, mode="nearest")
    return Network(points=at, elements=elements, damage=damage, opening=np.zeros(len(at)))


def _raster(
    points: np.ndarray, cells: np.ndarray, alpha: np.ndarray, dim: int, h: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lower corner, edges and values of the damage on a raster over the body, edges about h.

    Outside of the body, in holes too, the value is that of the nearest point inside.
    """
    import pyvista

    lower, upper = points.min(axis=0), points.max(axis=0)
    counts = np.maximum(np.rint((upper - lower) / h).astype(int), 1)
    counts[dim:] = 0
    edge = (upper - lower) / np.maximum(counts, 1)
    image = pyvista.ImageData(dimensions=counts + 1, spacing=np.where(edge > 0, edge, 1.0))
    image.origin = lower
    kind = {(2, 3): 5, (2, 4): 9, (3, 4): 10, (3, 8): 12}[dim, cells.shape[1]]
    body = pyvista.UnstructuredGrid({kind: cells}, points)
    body["alpha"] = alpha
    probed = image.sample(body)
    shape = tuple(counts[:dim] + 1)
    field = np.asarray(probed["alpha"]).reshape(shape, order="F")
    inside = np.asarray(probed["vtkValidPointMask"]).reshape(shape, order="F").astype(bool)
    if not inside.all():
        nearest = distance_transform_edt(~inside, return_distances=False, return_indices=True)
        field = field[tuple(nearest)]
    return lower, edge, field


def _clipped(found: Network, tip: float, dim: int) -> Network:
    """What has more damage than a tip; triangles in 3-D."""
    import pyvista

    if not len(found.elements):
        return replace(found, elements=found.elements[:, :dim])
    given = np.insert(found.elements, 0, found.elements.shape[1], axis=1).ravel()
    mesh = pyvista.PolyData(found.points, **{"lines" if dim == 2 else "faces": given})
    mesh["damage"] = found.damage
    if dim == 3:
        mesh = mesh.triangulate()
    mesh = mesh.clip_scalar(scalars="damage", value=tip, invert=False)
    mesh = mesh if dim == 2 else mesh.triangulate()
    rows = np.asarray(mesh.lines if dim == 2 else mesh.faces).reshape(-1, dim + 1)
    points = np.asarray(mesh.points, dtype=float)
    return Network(
        points=points,
        elements=rows[:, 1:],
        damage=np.asarray(mesh["damage"]) if len(points) else np.zeros(0),
        opening=np.zeros(len(points)),
    )


def _steady(found: Network, crack: float) -> Network:
    """What is broken, and what goes on from it straight ahead.

    Around the end of a crack the damage falls alike in all directions, and has false crests there.
    """
    middles = found.points[found.elements].mean(axis=1)
    across = normals(found.points, found.elements)
    broken = found.damage[found.elements].mean(axis=1) >= crack
    if not broken.any():
        return _with(found, found.elements[broken])
    nearest = cKDTree(middles[broken]).query(middles)[1]
    ahead, straight = middles - middles[broken][nearest], across[broken][nearest]
    turned = np.abs(np.einsum("ij,ij->i", across, straight)) < np.cos(TURN)
    aside = np.abs(np.einsum("ij,ij->i", ahead, straight))
    aside = aside > np.sin(TURN) * np.linalg.norm(ahead, axis=1)
    return _with(found, found.elements[broken | ~(turned | aside)])


def _kept(found: Network, crack: float, ell: float) -> Network:
    """The cracks that are broken somewhere and longer (larger) than ell (ell^2)."""
    if not len(found.elements):
        return _with(found, found.elements)
    extent = np.bincount(found.cracks, weights=found.sizes)
    good = (_most(found, found.cracks) >= crack) & (extent >= ell ** (found.elements.shape[1] - 1))
    return _with(found, found.elements[good[found.cracks]])


def _pruned(found: Network, crack: float, ell: float) -> Network:
    """Without branches that leave another and end within ell, or are broken nowhere."""
    while len(found.elements):
        degree = np.bincount(found.elements.ravel(), minlength=len(found.points))
        ends = degree[found.elements]
        free, forked = (ends == 1).any(axis=1), (ends > 2).any(axis=1)
        count = found.branches.max() + 1
        length = np.bincount(found.branches, weights=found.sizes, minlength=count)
        most = _most(found, found.branches)
        stub = np.bincount(found.branches, weights=free, minlength=count) > 0
        stub &= np.bincount(found.branches, weights=forked, minlength=count) > 0
        stub &= (length < ell) | (most < crack)
        if not stub.any():
            break
        found = _with(found, found.elements[~stub[found.branches]])
    return found


def _joined(found: Network, ell: float, crack: float) -> Network:
    """With what is missing where cracks meet: free ends joined to what is near, across the broken.

    Two that are near are joined straight, several in their middle.
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
        opening=np.zeros(n + more),
    )


def _links(found: Network, ends: np.ndarray, ell: float) -> np.ndarray:
    """Each free end with the nearest point ahead that is not near along the crack, (k, 2)."""
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


def _most(found: Network, label: np.ndarray) -> np.ndarray:
    """The largest damage among the elements of each label."""
    most = np.zeros(label.max() + 1)
    np.maximum.at(most, label, found.damage[found.elements].max(axis=1))
    return most


def _with(found: Network, elements: np.ndarray) -> Network:
    """Only these elements, and the points that they use."""
    used, numbers = np.unique(elements, return_inverse=True)
    return Network(
        points=found.points[used],
        elements=numbers.reshape(elements.shape),
        damage=found.damage[used],
        opening=found.opening[used],
    )


def _parts(elements: np.ndarray, extents: np.ndarray) -> np.ndarray:
    """Number of the connected part of each element, the largest first."""
    if not len(elements):
        return np.zeros(0, dtype=np.int64)
    n = elements.max() + 1
    pairs = np.concatenate([elements[:, [k - 1, k]] for k in range(elements.shape[1])])
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(n, n))
    part = connected_components(graph, directed=False)[1][elements[:, 0]]
    order = np.argsort(-np.bincount(part, weights=extents), kind="stable")
    return np.argsort(order)[part]


def _branches(elements: np.ndarray, n_points: int) -> np.ndarray:
    """Segments joined over points that only two of them share."""
    m = len(elements)
    degree = np.bincount(elements.ravel(), minlength=n_points)
    order = np.argsort(elements.ravel(), kind="stable")
    through = degree[elements.ravel()[order]] == 2
    pairs = (order[through] // elements.shape[1]).reshape(-1, 2)
    graph = coo_array((np.ones(len(pairs)), pairs.T), shape=(m, m))
    return connected_components(graph, directed=False)[1].astype(np.int64)
