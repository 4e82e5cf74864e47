"""Distance of the sharp tip of a crack beyond the damage that is counted."""

import numpy as np

# A growing crack is sharp up to a point at which the damage has fallen from 1 only a little. BEYOND
# is the distance, over ell, of this point from the last point of a given damage. It was measured
# on a known sharp crack: a long one, driven by the displacements of a moving tip (`make verify
# ONLY=surfing`). Between vertices h apart, the last vertex above the threshold lies h/2 before the
# threshold on average; this is added.
THRESHOLDS = (0.5, 0.6, 0.7, 0.8, 0.9, 0.95)
BEYOND = {
    "AT1": (0.15, 0.35, 0.55, 0.75, 0.97, 1.15),
    "AT2": (0.91, 1.25, 1.54, 1.80, 2.11, 2.35),
}
# The damage at which the crack network ends, so that its length is the surface energy over the
# effective Gc. Measured on the four cracks of the case `notched`, before and after some of them
# stopped (AT1: 0.99 to 1.00 of it, AT2: 0.97 to 1.00).
AT_TIP = {"AT1": 0.25, "AT2": 0.23}
# Distance (in ell) from a damage of 0.95 to that of a tip: at a given end that has not grown at
# most the first number, at an end that has grown at least the second. Measured on given cracks
# (AT1: 0.61 to 0.95, AT2: 0.74 to 1.17, on quadrilaterals, triangles and unstructured cells of
# ell/4 and ell/3), on those of `notched` (AT1: 1.15 to 1.50) and on the long one above (AT1: 1.67
# to 1.85, AT2: 1.6 to 1.9).
FALLS = {"AT1": (0.95, 1.15), "AT2": (1.17, 1.37)}


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


def reach(law: str, *, threshold: float, ell: float, h: float) -> float | None:
    """Return the distance (m) from the last vertex above the threshold to the sharp tip.

    None for a law that was not measured, or for a threshold outside the measured range.

    Parameters
    ----------
    law : name of the damage law.
    threshold : damage above which a vertex is cracked.
    ell : regularization length (m).
    h : mesh size (m).
    """
    if law not in BEYOND or not THRESHOLDS[0] <= threshold <= THRESHOLDS[-1]:
        return None
    return float(np.interp(threshold, THRESHOLDS, BEYOND[law])) * ell + h / 2
