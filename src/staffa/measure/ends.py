"""Ends of the cracks of a network: a crack that has not grown ends where the case gives it."""

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from staffa.measure.network import Network
from staffa.measure.opening import EVENED, evened, outward

# Down to this damage a crack is fully broken. `measure.tip.falls` gives the distance from there to
# the end of the network.
WHOLE = 0.95
# A point farther from every tip than this times the tip's fall belongs to none.
NEAR = 1.5
# An end of the network with more damage is no crack tip: there the crack meets a face.
SOFT = 0.6


def with_ends_of_cracks(
    found: Network, *, tip: float, falls: tuple[float, float], ell: float
) -> Network:
    """Cut ends that have never grown back to the end of the given crack.

    The damage ahead of such an end falls faster than ahead of an end that has grown. Between the
    two limits, as ahead of a loaded end, the part that stays is in proportion.

    Parameters
    ----------
    found : the network.
    tip : damage down to which the network was followed.
    falls : distance over ell from damage WHOLE to the end of the network: the largest at a given
        end, and the smallest at an end that has grown.
    ell : regularization length (m).
    """
    whole = clipped(found, found.damage - WHOLE).points
    free = outward(found.points, found.elements).any(axis=1) & (found.damage <= SOFT)
    if not len(whole) or not free.any():
        return found
    ends, damage = found.points[free], found.damage[free]
    fall = cKDTree(whole).query(ends)[0]
    # If the ridge left the crack before the tip: the distance extrapolated to the tip.
    whole_fall = fall * (WHOLE - tip) / (WHOLE - damage)
    given, grown = falls
    left = fall * np.clip((whole_fall / ell - given) / (grown - given), 0, 1)
    if (left == fall).all():
        return found
    away, nearest = cKDTree(ends).query(found.points)
    soft = clipped(found, WHOLE - found.damage).points
    beyond = cKDTree(whole).query(found.points)[0] - cKDTree(soft).query(found.points)[0]
    room = left[nearest] - beyond
    room[(away > NEAR * fall[nearest]) & (room < 0)] = ell  # of no end
    return _moved(clipped(found, -room), clipped(found, room), ell)


def _moved(ahead: Network, kept: Network, ell: float) -> Network:
    """Return the kept part, with the volume that opens ahead of its ends, as an uncertainty too."""
    if not len(kept.points) or np.isnan(kept.opening).any():
        return kept
    corners = ahead.elements.shape[1]
    volumes = ahead.opening[ahead.elements] * ahead.sizes[:, None] / corners
    nearest = cKDTree(kept.points).query(ahead.points)[1][ahead.elements]
    gathered = np.bincount(nearest.ravel(), weights=volumes.ravel(), minlength=len(kept.points))
    more = evened(gathered[:, None], kept.points, kept.elements, kept.sizes, EVENED * ell)[:, 0]
    uncertainty = kept.uncertainty + np.abs(more)
    return replace(kept, opening=kept.opening + more, uncertainty=uncertainty)


def clipped(found: Network, values: np.ndarray) -> Network:
    """Return the part of a network where values at its points are positive.

    Quadrilaterals become triangles.

    Parameters
    ----------
    found : the network.
    values : at the points, shape (n,); linear in between.
    """
    import pyvista

    corners = found.elements.shape[1]
    dim = min(corners, 3)
    names = [name for name in ("damage", "opening", "uncertainty") if len(getattr(found, name))]
    if not len(found.elements):
        return replace(found, elements=found.elements[:, :dim])
    given = np.insert(found.elements, 0, corners, axis=1).ravel()
    mesh = pyvista.PolyData(found.points, **{"lines" if dim == 2 else "faces": given})
    for name in names:
        mesh[name] = getattr(found, name)
    mesh["values"] = values
    if dim == 3:
        mesh = mesh.triangulate()
    mesh = mesh.clip_scalar(scalars="values", value=0.0, invert=False)
    mesh = mesh if dim == 2 else mesh.triangulate()
    rows = np.asarray(mesh.lines if dim == 2 else mesh.faces).reshape(-1, dim + 1)
    points, none = np.asarray(mesh.points, dtype=float), np.zeros(0)
    columns = {name: np.asarray(mesh[name]) if len(points) else none for name in names}
    kept: dict[str, Any] = {"damage": none} | columns
    return replace(found, points=points, elements=rows[:, 1:], **kept)
