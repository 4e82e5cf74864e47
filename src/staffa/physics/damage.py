"""Damage laws: degradation of the stiffness and local dissipation."""

from collections import ChainMap
from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from typing import Any, Protocol

import numpy as np


class DamageLaw(Protocol):
    """Damage law for E = int a(alpha) psi + Gc/(4 c_w) int (w(alpha)/ell + ell |grad alpha|^2).

    `a` falls from 1 at alpha = 0 to 0 at alpha = 1; `w` rises from 0 to 1; `c_w` is the integral of
    sqrt(w) over [0, 1]. Both functions take and return anything with arithmetic: float, numpy, UFL,
    sympy. No base class is needed: a class with these four members is a law.
    """

    @property
    def name(self) -> str:
        """Name in tables and records."""
        ...

    @property
    def c_w(self) -> float:
        """Integral of sqrt(w) over [0, 1]."""
        ...

    def a(self, alpha: Any) -> Any:
        """Return the fraction of the stiffness that damage leaves."""
        ...

    def w(self, alpha: Any) -> Any:
        """Return the local dissipation, in units of Gc/(4 c_w ell)."""
        ...


class AT1:
    """Law with w = alpha: an elastic phase up to a strength, then damage (Pham et al. 2011)."""

    name = "AT1"
    c_w = 2 / 3

    def a(self, alpha: Any) -> Any:
        """Return a(alpha) = (1 - alpha)^2."""
        return (1 - alpha) ** 2

    def w(self, alpha: Any) -> Any:
        """Return w(alpha) = alpha."""
        return alpha


class AT2:
    """Law with w = alpha^2: damage at any load.

    This is the paper's eq. (2), with v = 1 - alpha and ell = 2 epsilon.
    """

    name = "AT2"
    c_w = 1 / 2

    def a(self, alpha: Any) -> Any:
        """Return a(alpha) = (1 - alpha)^2."""
        return (1 - alpha) ** 2

    def w(self, alpha: Any) -> Any:
        """Return w(alpha) = alpha^2."""
        return alpha**2


# Coefficients a2 and a3 of the softening of a cohesive law (Wu 2017, with p = 2).
SOFTENING = {"linear": (-0.5, 0.0), "cornelissen": (1.3868, 0.6567)}


@dataclass(frozen=True, kw_only=True)
class Cohesive:
    """Law whose strength and softening do not depend on ell (Wu, J. Mech. Phys. Solids 103, 2017).

    1/a = 1 + a1 alpha (1 + a2 alpha (1 + a3 alpha))/(1 - alpha)^2 and w = 2 alpha - alpha^2: the
    stress across a crack falls with its opening, from the strength to 0.

    Attributes
    ----------
    a1 : 4 l_ch/(pi ell), with Irwin's length l_ch = E Gc/strength^2.
    softening : stress against opening, "linear" or "cornelissen" (as of concrete).
    name : name of the law.
    """

    a1: float
    softening: str = "linear"
    name: str = "cohesive"
    c_w = pi / 4

    @property
    def irwin_over_ell(self) -> float:
        """Irwin's length over ell."""
        return self.a1 * pi / 4

    def a(self, alpha: Any) -> Any:
        """Return a(alpha)."""
        a2, a3 = SOFTENING[self.softening]
        left = (1 - alpha) ** 2
        return left / (left + self.a1 * alpha * (1 + a2 * alpha * (1 + a3 * alpha)))

    def w(self, alpha: Any) -> Any:
        """Return w(alpha) = 2 alpha - alpha^2."""
        return alpha * (2 - alpha)


def irwin_length(*, E: float, Gc: float, strength: float) -> float:
    """Return l_ch = E Gc/strength^2 (m).

    Parameters
    ----------
    E : Young's modulus (Pa).
    Gc : fracture toughness (J/m^2).
    strength : stress that a bar bears (Pa).
    """
    return E * Gc / strength**2


def cohesive(*, irwin: float, ell: float, softening: str = "linear") -> Cohesive:
    """Return the cohesive law of Irwin's length (m) at an ell (m)."""
    return Cohesive(a1=4 * irwin / (pi * ell), softening=softening)


def longest_cohesive_ell(irwin: float, softening: str = "linear") -> float:
    """Return the largest ell (m) of a cohesive law: 8/(3 pi) of Irwin's length if linear.

    Above it, a is not convex at alpha = 0: a1 < 2 + a2 (Wu and Nguyen, J. Mech. Phys. Solids 119,
    20, 2018).

    Parameters
    ----------
    irwin : Irwin's length (m).
    softening : see `Cohesive`.
    """
    return 4 * irwin / (pi * (2 + SOFTENING[softening][0]))


def spreading_ell(irwin: float) -> float:
    """Return the ell (m) of a cohesive law from which damage spreads at held displacements.

    At the strength rock stores strength^2/(2 E) = Gc/(2 l_ch). Rock that is broken all over costs
    Gc/(4 c_w ell) = Gc/(pi ell), which is less above 2/pi of Irwin's length.

    Parameters
    ----------
    irwin : Irwin's length (m).
    """
    return 2 * irwin / pi


LAWS: dict[str, DamageLaw] = {"AT1": AT1(), "AT2": AT2()}
COHESIVE = "cohesive"
# All laws by their names. One stands for all cohesive laws: only its name and its type are used.
KNOWN: Mapping[str, DamageLaw] = ChainMap({COHESIVE: Cohesive(a1=2.0)}, LAWS)


def slope(function: Any, alpha: np.ndarray | float) -> np.ndarray:
    """Return the derivative of a law's function, exact to round-off by the complex step."""
    step = 1e-30
    found: np.ndarray = np.imag(function(np.asarray(alpha) + 1j * step)) / step
    return found


def has_threshold(law: DamageLaw) -> bool:
    """Return True if the law stays elastic up to a strength, w'(0) > 0: AT1 does, AT2 does not."""
    return bool(slope(law.w, 0.0) > 0)


def is_quadratic(law: DamageLaw) -> bool:
    """Return True if a and w are polynomials of degree two at most: third differences vanish."""
    weights = np.array([1.0, -3.0, 3.0, -1.0])
    places = (np.linspace(0, 1, 4), np.linspace(0.1, 0.7, 4), np.linspace(0.2, 0.95, 4))
    differences = [weights @ (f(x) + 0 * x) for f in (law.a, law.w) for x in places]
    return bool(np.abs(differences).max() < 1e-12)


def strength(law: DamageLaw, *, E: float, Gc: float, ell: float) -> float:
    """Return the largest stress that a bar of uniform damage carries.

    sigma^2 = max over alpha of (E Gc / (2 c_w ell)) w'(alpha) / S'(alpha), with S = 1/a:
    sqrt(3 Gc E/(8 ell)) for AT1, (3/16) sqrt(3 Gc E/ell) for AT2.

    Parameters
    ----------
    law : the damage law.
    E : Young's modulus (Pa), or scaled as the other numbers are.
    Gc : fracture toughness (J/m^2).
    ell : regularization length (m).
    """
    return float(np.sqrt(E * Gc / (2 * law.c_w * ell) * _resistance(law)[1].max()))


def damage_at_strength(law: DamageLaw) -> float:
    """Return the damage of a uniform bar at its largest stress: 0 for AT1, 1/4 for AT2."""
    alpha, resistance = _resistance(law)
    return float(alpha[resistance.argmax()])


def _resistance(law: DamageLaw) -> tuple[np.ndarray, np.ndarray]:
    """Return samples of the damage, and of w'(alpha)/S'(alpha) with S = 1/a (a squared stress)."""
    alpha = np.linspace(0.0, 0.999, 20_000)
    softening = -slope(law.a, alpha) / law.a(alpha) ** 2
    return alpha, slope(law.w, alpha) / softening


def effective_gc_factor(law: DamageLaw, *, h: float, ell: float) -> float:
    """Return 1 + h/(4 c_w ell), a first guess of effective Gc over Gc; a run measures it.

    Parameters
    ----------
    law : the damage law.
    h : mesh size (m).
    ell : regularization length (m).
    """
    return 1 + h / (4 * law.c_w * ell)
