"""Ends of the cracks of a network: a crack that has not grown ends where it was given."""

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from staffa.measure.network import Network
from staffa.measure.opening import EVENED, evened, outward

# A crack is whole down to this damage. `measure.tip.falls` tells how far it falls from there.
WHOLE = 0.95
# What lies farther from each tip than this times its fall belongs to none.
NEAR = 1.5
# An end of the network with more damage is none of a crack: there it meets a face.
SOFT = 0.6


def ended(found: Network, *, tip: float, falls: tuple[float, float], ell: float) -> Network:
    """With ends that have never grown taken back to where the crack was given.

    The damage ahead of such an end falls faster than ahead of one that has grown. Between the two,
    as ahead of a loaded end, the part left is in proportion.

    Parameters
    ----------
    tip : the damage down to which the network was followed. falls : how far from what is whole
        that lies at a given end at most, and at a grown one at least, over ell. ell :
        regularization length (m).
    """
    whole = clipped(found, found.damage - WHOLE).points
    free = outward(found.points, found.elements).any(axis=1) & (found.damage <= SOFT)
    if not len(whole) or not free.any():
        return found
    ends, damage = found.points[free], found.damage[free]
    fall = cKDTree(whole).query(ends)[0]
    # Where the crest went astray before the tip, as far as it would have been.
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
    """The kept part, with the volume that opens ahead of its ends, where it is uncertain."""
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
    """The part where values at the points are positive.

    values: linear between points, shape (n,). Quadrilaterals become triangles.
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
