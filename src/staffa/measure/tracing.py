"""Crack network from the fields on a mesh: the ridge of the damage, without false parts."""

from dataclasses import replace

import numpy as np
from scipy.ndimage import map_coordinates
from scipy.spatial import cKDTree

from staffa.measure.ends import clipped, with_ends_of_cracks
from staffa.measure.junctions import joined, largest_damage, pruned
from staffa.measure.network import Network, normals, selected
from staffa.measure.opening import cell_pieces, openings
from staffa.measure.ridge import ridge
from staffa.measure.traced_body import Body

# Width (in ell) of the Gaussian that smooths the steps of a layer of cells out of a crack.
SMOOTHING = 0.5
# Least downward curvature of a ridge, times ell^2; a straight crack has 1.1 (AT1), smoothed.
SHARPEST = 0.2
# Largest turn (radians) of a ridge between its broken part and its tip.
TURN = 0.6


def network(
    points: np.ndarray,
    cells: np.ndarray,
    *,
    alpha: np.ndarray,
    strains: np.ndarray | None,
    dim: int,
    h: float,
    ell: float,
    crack: float,
    tip: float,
    falls: tuple[float, float] | None = None,
    axial: bool = False,
) -> Network:
    """Trace the crack network of the fields on a mesh, whatever the order of its points and cells.

    Parameters
    ----------
    points : coordinates (m), shape (n, 3).
    cells : vertices of each cell in VTK's order, shape (m, vertices).
    alpha : damage at the points, shape (n,).
    strains : opening strain and that of intact rock of each cell (see `model.openings`), shape
        (m, 2); None if they were not kept, and openings are nan.
    dim : 2 or 3.
    h : mesh size (m).
    ell : regularization length (m).
    crack : damage that a crack reaches somewhere.
    tip : damage down to which a crack is followed.
    falls : fall lengths, see `measure.tip.falls`; None if not known, and ends are not cut.
    axial : True for the meridian plane of a body of revolution.
    """
    body = Body(points, cells, dim=dim, h=h)
    alpha = alpha[body.vertices]
    found = _crest(body, alpha, ell=ell, tip=tip)
    found = _steady(clipped(found, found.damage - tip), crack)
    found = _kept(_within(found, body), crack, ell)
    if dim == 2:
        found = _within(joined(pruned(found, crack, ell), crack, ell), body)
    if strains is None or not len(found.points):
        unknown = np.full(len(found.points), np.nan)
        found = replace(found, opening=unknown, uncertainty=unknown, axial=axial)
        return with_ends_of_cracks(found, tip=tip, falls=falls, ell=ell) if falls else found
    strains = strains[body.members]
    broken = alpha[body.cells].max(axis=1) >= crack
    soft = np.where(broken, 0.0, np.abs(strains[:, 0]))
    columns = np.column_stack([strains, soft, np.ones_like(soft)])
    volumes = cell_pieces(body.points, body.cells, columns, dim)
    opening, uncertainty = openings(
        *volumes, found.points, found.elements, found.sizes, h=h, ell=ell
    )
    found = replace(found, opening=opening, uncertainty=uncertainty, axial=axial)
    return with_ends_of_cracks(found, tip=tip, falls=falls, ell=ell) if falls else found


def _crest(body: Body, alpha: np.ndarray, *, ell: float, tip: float) -> Network:
    """Return the ridge of the damage, with the damage on it."""
    origin, edge, field = body.raster(alpha)
    found, elements = ridge(
        field,
        sigma=max(SMOOTHING * ell / body.h, 1.0),
        lowest=tip / 2,  # smoothing lowers the damage: what is too much is clipped
        sharpest=SHARPEST * (body.h / ell) ** 2,
    )
    at = np.zeros((len(found), 3))
    at[:, : body.dim] = origin[: body.dim] + found * edge[: body.dim]
    damage = map_coordinates(field, found.T, order=1, mode="nearest")
    return Network(points=at, elements=elements, damage=damage)


def _within(found: Network, body: Body) -> Network:
    """Cut a network off at the holes and faces of the body."""
    _, outside = body.nearest(found.points[found.elements].mean(axis=1))
    found = selected(found, found.elements[~outside])
    return replace(found, points=body.nearest(found.points)[0])


def _steady(found: Network, crack: float) -> Network:
    """Return the broken part, and the parts that continue it straight ahead.

    Around the end of a crack the damage falls alike in all directions: ridges there turn away, or
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
    """Move the points that are not broken to straight ahead of the nearest broken element."""
    points, loose = found.points.copy(), found.damage < crack
    nearest = cKDTree(middles).query(points[loose])[1]
    aside = np.einsum("ij,ij->i", points[loose] - middles[nearest], across[nearest])
    points[loose] -= aside[:, None] * across[nearest]
    return replace(found, points=points)


def _kept(found: Network, crack: float, ell: float) -> Network:
    """Return the cracks that are broken somewhere and exceed ell (in 3-D ell^2)."""
    if not len(found.elements):
        return selected(found, found.elements)
    extent = np.bincount(found.cracks, weights=found.sizes)
    good = (largest_damage(found, found.cracks) >= crack) & (
        extent >= ell ** (found.elements.shape[1] - 1)
    )
    return selected(found, found.elements[good[found.cracks]])
