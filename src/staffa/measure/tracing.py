"""From the fields on a mesh to the crack network: its crest, cleared of what is no crack."""

from dataclasses import replace

import numpy as np
from scipy.ndimage import map_coordinates
from scipy.spatial import cKDTree

from staffa.measure.ends import clipped, ended
from staffa.measure.junctions import joined, largest_damage, pruned
from staffa.measure.network import Network, normals, selected
from staffa.measure.opening import cell_pieces, openings
from staffa.measure.ridge import ridge
from staffa.measure.traced_body import Body

# The Gaussian that takes the steps of a layer of cells out of a crack: fractions of ell.
SMOOTHING = 0.5
# A crest bends down by more than this over ell^2; that of a straight crack by 1.1 (AT1), smoothed.
SHARPEST = 0.2
# By how much (radians) a crest may turn between where it is broken and its tip.
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
    """The network of the fields on a mesh, whatever the order of its points and cells.

    Parameters
    ----------
    points, cells : shape (n, 3); shape (m, vertices), in VTK's order. alpha : at the points.
        strains : of the cells, that of the opening and that of intact rock (see `model.openings`),
        shape (m, 2); None if they were not kept, and openings are nan. dim : 2 or 3. h, ell : cell
        edge, regularization length (m).
    crack : the damage that a crack reaches somewhere; tip : down to which it is followed.
        falls : see `ends.ended`; None where it is not known, and ends stay where they are.
    axial : True for the section of a body of revolution.
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
        return ended(found, tip=tip, falls=falls, ell=ell) if falls else found
    strains = strains[body.members]
    broken = alpha[body.cells].max(axis=1) >= crack
    soft = np.where(broken, 0.0, np.abs(strains[:, 0]))
    columns = np.column_stack([strains, soft, np.ones_like(soft)])
    volumes = cell_pieces(body.points, body.cells, columns, dim)
    opening, uncertainty = openings(
        *volumes, found.points, found.elements, found.sizes, h=h, ell=ell
    )
    found = replace(found, opening=opening, uncertainty=uncertainty, axial=axial)
    return ended(found, tip=tip, falls=falls, ell=ell) if falls else found


def _crest(body: Body, alpha: np.ndarray, *, ell: float, tip: float) -> Network:
    """The crest of the damage, with the damage on it."""
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
    good = (largest_damage(found, found.cracks) >= crack) & (
        extent >= ell ** (found.elements.shape[1] - 1)
    )
    return selected(found, found.elements[good[found.cracks]])
