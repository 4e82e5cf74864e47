"""What pulls and presses on a body besides cold: its weight, its sides, its past, its pores, and
the fluid in its cracks. Tension counts positive, as stresses do; pressures do so where they press.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

# At points x, shape (3, n), and a time t (s): a value at each, shape (n,), or a vector, (dim, n).
InSpaceAndTime = Callable[[np.ndarray, float], np.ndarray]
InSpace = Callable[[np.ndarray], np.ndarray]
InTime = Callable[[float], float]


@dataclass(frozen=True, kw_only=True)
class Traction:
    """What acts on one named side: a force per area, shape (dim, n), and a pressure (Pa)."""

    side: str
    force: InSpaceAndTime | None = None
    pressure: InSpaceAndTime | None = None


@dataclass(frozen=True, kw_only=True)
class Forces:
    """All that acts on a body but displacements and temperatures.

    gravity: an acceleration (m/s^2), dim numbers; it acts on the rock's density. prestress: the
    stress (Pa) at u = 0, T = 0 at points, shape (6, n), in the order xx, yy, zz, yz, xz, xy; in 2-D
    zz counts in plane strain, yz and xz never. pore_pressure: (Pa) at points, shape (n,), with
    Biot's coefficient biot, part of the prestress. crack_pressure: (Pa) in all cracks, or
    crack_volume: what they hold (m^3, in 2-D m^2) at a time (s), by a pressure that is found.
    """

    gravity: tuple[float, ...] | None = None
    sides: tuple[Traction, ...] = ()
    prestress: InSpace | None = None
    pore_pressure: InSpace | None = None
    biot: float = 1.0
    crack_pressure: InTime | None = None
    crack_volume: InTime | None = None

    @property
    def at_rest(self) -> bool:
        """Whether nothing acts at all."""
        return self == Forces(biot=self.biot)

    @property
    def in_cracks(self) -> bool:
        """Whether a fluid presses on the faces of cracks."""
        return self.crack_pressure is not None or self.crack_volume is not None
