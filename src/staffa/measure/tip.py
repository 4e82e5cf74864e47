"""Distance of the sharp tip of a crack beyond the damage that is counted."""

import numpy as np

from staffa.physics.damage import Cohesive, DamageLaw

# A growing crack is sharp up to a point at which the damage has fallen from 1 only a little. The
# distance of this point from the last point of a given damage is BEYOND, in ell. It was measured
# on a known sharp crack: a long one, driven by the displacements of a moving tip (`make verify
# ONLY=surfing`). Between vertices h apart, the last vertex above the threshold lies h/2 before the
# threshold on average; this is added. Damage near 1 ends earlier on coarser cells: WITH_H, in h, is
# added too, where BEYOND is the limit of small h. Both are a straight line through five meshes of 3
# to 8 cells in ell; of lower damage the slopes were too small to count (AT1). AT2 and the cohesive
# law were measured on one mesh, of ell/4.
THRESHOLDS = (0.5, 0.6, 0.7, 0.8, 0.9, 0.95)
BEYOND = {
    "AT1": (0.15, 0.35, 0.55, 0.75, 0.92, 0.97),
    "AT2": (0.91, 1.25, 1.54, 1.80, 2.11, 2.35),
}
WITH_H = {"AT1": (0.0, 0.0, 0.0, 0.0, 0.37, 0.99)}
COARSEST = 1 / 3  # h over ell: coarser cells were not measured, and count as these
# The same of a cohesive law, by its softening and Irwin's length over ell (`make verify
# ONLY=cohesive-tip`): ahead of the open part lies one that still bears stress, which is longer the
# longer Irwin's length is.
BEYOND_COHESIVE = {
    "linear": {
        4 / 3: (0.125, 0.225, 0.375, 0.525, 0.725, 0.875),
        2.5: (0.225, 0.425, 0.625, 0.8725, 1.125, 1.375),
    },
}
# The damage at which the crack network ends, so that its length is the surface energy over the
# effective Gc. Measured on the four cracks of the case `notched`, before and after some of them
# stopped (AT1: 0.99 to 1.00 of it, AT2: 0.97 to 1.00). Of the cohesive law: on the crack of the
# moving tip, where the surface energy ends at 0.45 to 0.50 and the sharp tip lies at 0.40 to 0.43;
# a crack that a wedge drives is 0.998 of it.
AT_TIP = {"AT1": 0.25, "AT2": 0.23, "cohesive": 0.45}
# Distance (in ell) from a damage of 0.95 to that of a tip: at a given end that has not grown at
# most the first number, at an end that has grown at least the second. Measured on given cracks
# (AT1: 0.61 to 0.95, AT2: 0.74 to 1.17, on quadrilaterals, triangles and unstructured cells of
# ell/4 and ell/3), on those of `notched` (AT1: 1.15 to 1.50) and on the long one above (AT1: 1.67
# to 1.85, AT2: 1.6 to 1.9). Of the cohesive law: 0.42 to 0.65 at given ends, on the same cells of
# ell/3, and 0.85 to 1.3 at those of cracks that grew.
FALLS = {"AT1": (0.95, 1.15), "AT2": (1.17, 1.37), "cohesive": (0.65, 0.85)}


def falls(law: str) -> tuple[float, float] | None:
    """Return the fall lengths at given and at grown ends (see FALLS); None for another law."""
    return FALLS.get(law)


def damage_at_tip(law: str, *, threshold: float) -> float:
    """Return the damage down to which a crack network is followed; for another law, the threshold.

    Parameters
    ----------
    law : name of the damage law.
    threshold : damage above which a point is cracked.
    """
    return AT_TIP.get(law, threshold)


def tip_distances(law: str | DamageLaw, *, h: float) -> np.ndarray | None:
    """Return the distances of the sharp tip beyond each of THRESHOLDS, less h/2, over ell.

    None for a law that was not measured. A cohesive law takes those of Irwin's lengths beside its
    own, and None beyond the longest that was measured.

    Parameters
    ----------
    law : damage law, or its name if it is no cohesive one.
    h : mesh size over ell; a cohesive law does without.
    """
    if isinstance(law, str) or not isinstance(law, Cohesive):
        name = law if isinstance(law, str) else law.name
        if name not in BEYOND:
            return None
        return np.array(BEYOND[name]) + min(h, COARSEST) * np.array(WITH_H.get(name, 0.0))
    rows = BEYOND_COHESIVE.get(law.softening, {})
    if not rows or law.irwin_over_ell > max(rows) * (1 + 1e-9):
        return None
    at, columns = sorted(rows), np.array([rows[ratio] for ratio in sorted(rows)]).T
    return np.array([np.interp(law.irwin_over_ell, at, column) for column in columns])


def reach(law: str | DamageLaw, *, threshold: float, ell: float, h: float) -> float | None:
    """Return the distance (m) from the last vertex above the threshold to the sharp tip.

    None for a law that was not measured, or for a threshold outside the measured range.

    Parameters
    ----------
    law : see `tip_distances`.
    threshold : damage above which a vertex is cracked.
    ell : regularization length (m).
    h : mesh size (m).
    """
    distances = tip_distances(law, h=h / ell)
    if distances is None or not THRESHOLDS[0] <= threshold <= THRESHOLDS[-1]:
        return None
    return float(np.interp(threshold, THRESHOLDS, distances)) * ell + h / 2
