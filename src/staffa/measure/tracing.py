"""From the fields on a mesh to the crack network: its crest, cleared of what is no crack."""

from dataclasses import replace

import numpy as np
from scipy.ndimage import distance_transform_edt, map_coordinates
from scipy.spatial import cKDTree

from staffa.measure.junctions import joined, largest, pruned
from staffa.measure.network import Network, normals, selected
from staffa.measure.opening import opening, sliver
from staffa.measure.ridge import crest

# The Gaussian that takes the steps of a layer of cells out of a crack: fractions of ell.
SMOOTHING = 0.5
# A crest bends down by more than this over ell^2; that of a straight crack by 1.1 (AT1), smoothed.
SHARPEST = 0.2
# Farther from a crack than so many ell, alpha^4 is less than 0.01 (AT2) or 0.001 (AT1).
REACH = 1.25
# By how much (radians) a crest may turn between where it is broken and its tip.
TURN = 0.6


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
        found = joined(pruned(found, crack, ell), crack, ell)
    at, volumes = sliver(points, cells, u=u, alpha=alpha, dim=dim)
    if not len(found.points):
        return found
    drawn = (found.points, found.elements, found.sizes)
    reach = REACH * ell + h
    return replace(found, opening=opening(at, volumes, *drawn, width=SMOOTHING * ell, reach=reach))


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

    Around the end of a crack the damage falls alike in all directions: crests there go astray, or
    are false.
    """
    middles = found.points[found.elements].mean(axis=1)
    across = normals(found.points, found.elements)
    broken = found.damage[found.elements].mean(axis=1) >= crack
    if not broken.any():
        return selected(found, found.elements[broken])
    nearest = cKDTree(middles[broken]).query(middles)[1]
    ahead, straight = middles - middles[broken][nearest], across[broken][nearest]
    turned = np.abs(np.einsum("ij,ij->i", across, straight)) < np.cos(TURN)
    aside = np.abs(np.einsum("ij,ij->i", ahead, straight))
    aside = aside > np.sin(TURN) * np.linalg.norm(ahead, axis=1)
    found = selected(found, found.elements[broken | ~(turned | aside)])
    return _straightened(found, crack, middles[broken], across[broken])


def _straightened(found: Network, crack: float, middles: np.ndarray, across: np.ndarray) -> Network:
    """With the points that are not broken put straight ahead of the nearest broken element."""
    points, loose = found.points.copy(), found.damage < crack
    nearest = cKDTree(middles).query(points[loose])[1]
    aside = np.einsum("ij,ij->i", points[loose] - middles[nearest], across[nearest])
    points[loose] -= aside[:, None] * across[nearest]
    return replace(found, points=points)


def _kept(found: Network, crack: float, ell: float) -> Network:
    """The cracks that are broken somewhere and longer (larger) than ell (ell^2)."""
    if not len(found.elements):
        return selected(found, found.elements)
    extent = np.bincount(found.cracks, weights=found.sizes)
    good = (largest(found, found.cracks) >= crack) & (
        extent >= ell ** (found.elements.shape[1] - 1)
    )
    return selected(found, found.elements[good[found.cracks]])
