"""Where the sharp tip of a smeared crack lies: how far beyond the damage that is counted."""

import numpy as np

# A crack that grows is sharp up to a point at which the damage has fallen from 1 only a little. How
# far this lies beyond the last point of a given damage, over ell, as measured on a known sharp
# crack: a long one, moved by the displacements of a tip that travels (`make verify
# ONLY=surfing`). Between vertices h apart the last one above the threshold falls short of the
# threshold by h/2 on average, which comes on top.
THRESHOLDS = (0.5, 0.6, 0.7, 0.8, 0.9, 0.95)
BEYOND = {
    "AT1": (0.15, 0.35, 0.55, 0.75, 0.97, 1.15),
    "AT2": (0.91, 1.25, 1.54, 1.80, 2.11, 2.35),
}
# The damage at which the crack network ends, so that its length is the surface energy over the
# discrete toughness: as measured on the four cracks of the case `notched`, before and after some of
# them stopped (AT1: 0.99 to 1.00 of it, AT2: 0.97 to 1.00).
AT_TIP = {"AT1": 0.25, "AT2": 0.23}
# From a damage of 0.95 to that of a tip it is so many ell: at an end that was given and has not
# grown no more than the first, at one that has grown no less than the second. As measured on given
# cracks (AT1: 0.61 to 0.95, AT2: 0.74 to 1.17, on quadrilaterals, triangles and unstructured cells
# of ell/4 and ell/3), on those of `notched` (AT1: 1.15 to 1.50) and on the long one above (AT1:
# 1.67 to 1.85, AT2: 1.6 to 1.9).
FALLS = {"AT1": (0.95, 1.15), "AT2": (1.17, 1.37)}


def falls(law: str) -> tuple[float, float] | None:
    """Fall of the damage at given and at grown ends (see FALLS); None of your own law."""
    return FALLS.get(law)


def damage_at_tip(law: str, *, threshold: float) -> float:
    """The damage down to which a crack network is followed; of a law of your own, the threshold."""
    return AT_TIP.get(law, threshold)


def reach(law: str, *, threshold: float, ell: float, h: float) -> float | None:
    """Distance (m) from the last vertex with more damage than the threshold to the sharp tip.

    None for a law of your own, or for a threshold outside of what was measured.
    """
    if law not in BEYOND or not THRESHOLDS[0] <= threshold <= THRESHOLDS[-1]:
        return None
    return float(np.interp(threshold, THRESHOLDS, BEYOND[law])) * ell + h / 2
