"""Spacing doubling in a cooled half-space: spacing and length at which every other crack stops.

An array of parallel cracks at spacing p grows into a half-space whose face was cooled at once.
At length a every other crack stops. So a crack pattern that has reached the depth a has a spacing
between p(a), at which cracks stop, and 2 p(a), when they have stopped.

The table was computed for this project with sharp cracks (finite elements of a cell between
symmetry lines, growth at G = Gc until dG1/da1 = dG1/da2), in plane stress, with all lengths over
ell0 = Gc/(E (expansion dT)^2). It holds for any elastic half-space if ell0 is that of its thermal
stress: cracks in the half-space are loaded by the stress sigma(y) that they release, so that
K = sigma sqrt(p) f(geometry) without elastic constants, and G = K^2/E'. In plane stress sigma is
E expansion dT and E' is E. If both lateral strains are blocked, sigma is E expansion dT/(1 - nu)
and E' is E/(1 - nu^2), so that sigma^2/E' = (expansion dT)^2 E (1 + nu)/(1 - nu), and

    ell0 = Gc (1 - nu)/(E (1 + nu) (expansion dT)^2),

which is `scales.ell0` with the state of plane strain or of a solid. There it is exact for parallel
cracks. Cells are cut by cracks in all directions, which also release the other lateral stress.
"""

import numpy as np

# Spacing, and length at the doubling; both over ell0.
SPACING = (8.0, 16.0, 32.0, 64.0, 128.0, 256.0, 512.0, 1024.0, 2048.0)
LENGTH = (1.92, 6.52, 17.8, 45.1, 110.0, 259.0, 598.0, 1359.0, 3049.0)


def spacing_at(length: np.ndarray | float, ell0: float) -> np.ndarray:
    """Return the spacing (m) at which cracks of this length (m) double; NaN outside the table.

    Between two entries of the table the spacing is a power of the length.
    """
    with np.errstate(divide="ignore"):
        at = np.log(np.asarray(length) / ell0)
    known = np.interp(at, np.log(LENGTH), np.log(SPACING), left=np.nan, right=np.nan)
    return np.asarray(np.exp(known) * ell0)
