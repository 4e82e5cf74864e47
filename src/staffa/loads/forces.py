"""Forces on a body: weight, loads on its sides, prestress, pore pressure, and fluid in cracks.

Stresses count positive in tension, pressures where they press.
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
    """Force per area on one named side.

    Attributes
    ----------
    side : name of the side.
    force : traction at points and a time (Pa), shape (dim, n); None without one.
    pressure : pressure at points and a time (Pa), shape (n,); None without one.
    """

    side: str
    force: InSpaceAndTime | None = None
    pressure: InSpaceAndTime | None = None


@dataclass(frozen=True, kw_only=True)
class Forces:
    """All that acts on a body but displacements and temperatures.

    Attributes
    ----------
    gravity : acceleration (m/s^2), dim numbers; it acts on the rock's density.
    sides : force per area on each side that has one.
    prestress : stress at u = 0, T = 0 at points (Pa), shape (6, n), in the order xx, yy, zz, yz,
        xz, xy; in 2-D zz counts in plane strain, yz and xz never.
    pore_pressure : pressure in the pores at points (Pa), shape (n,), part of the prestress.
    biot : Biot's coefficient of pressure in pores, dimensionless.
    crack_pressure : pressure in all cracks at a time (s) (Pa).
    crack_volume : fluid volume in the cracks at a time (s) (m^3, in 2-D m^2), given in place of
        `crack_pressure`, which then follows.
    fluid : True if the source of the temperature also gives a fluid pressure of place and time,
        which acts in pores, by `biot`, and in cracks.
    fluid_sides : names of sides on which that pressure presses.
    balanced : True if that pressure acts by its change since t = 0, as no stress before the first
        step is given; False if it acts as a whole, beside `prestress`, a total stress.
    """

    gravity: tuple[float, ...] | None = None
    sides: tuple[Traction, ...] = ()
    prestress: InSpace | None = None
    pore_pressure: InSpace | None = None
    biot: float = 1.0
    crack_pressure: InTime | None = None
    crack_volume: InTime | None = None
    fluid: bool = False
    fluid_sides: tuple[str, ...] = ()
    balanced: bool = False

    @property
    def at_rest(self) -> bool:
        """Return whether there are no forces."""
        return self == Forces(biot=self.biot)

    @property
    def in_cracks(self) -> bool:
        """Return whether a fluid presses on the faces of cracks."""
        return self.crack_pressure is not None or self.crack_volume is not None
