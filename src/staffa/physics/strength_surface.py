"""Energy of rock whose strengths under other stresses than tension in one direction are given."""

from copy import copy
from math import inf, isinf, sqrt
from typing import Any

from staffa.physics.strained import Strained, negative

# Least hardening of cracks that open in two directions at once: the corner of the surface is round,
# and the stiffness positive. Equal strengths come out 0.5 % apart.
ROUND = 0.02


class StrengthSurface:
    """Energy psi(e, g), least over inelastic strains, of rock with a convex strength surface.

    Damage adds compliance: psi(., g) is the conjugate of psi*(s) + t R(s), with the elastic energy
    psi* of a stress s, t = (1 + residual)/g - 1, and R(s) = j(s)^2/(2 E), the stress j of a bar as
    strong as s. A bar has psi = g E/2 e^2, as without a split, and damage starts where j is the
    strength, whatever the stress. See docs/theory/energy.md.

    j^2 = (1 - m) j_+^2 + m s_eq^2 with von Mises's stress s_eq, m = 1/compressive^2, and j_+ of
    stresses without pressure: 1/2 j_+^2 = max over openings p >= 0 of s . p - ((sum p)^2 +
    hardening p . p)/(2 (1 + hardening)), which is Rankine's largest stress where hardening is 0.

    For nu >= 0.

    Parameters
    ----------
    biaxial : strength under two equal tensions, over that of a bar; see `least_biaxial`.
    compressive : strength of a bar that is pressed, over that of one that is pulled; infinite for
        rock that pressure does not break.

    Attributes
    ----------
    residual : fraction of the stiffness that is added to g everywhere, see `beside`.
    """

    name, isotropic = "strength-surface", True

    def __init__(self, biaxial: float = 1.0, compressive: float = inf) -> None:
        self.sheared = _squared_inverse(compressive)
        share = (biaxial**-2 - self.sheared) / (1 - self.sheared)
        self.hardening = max(2 * (share - 1) / (2 - share), ROUND)
        self.residual: Any = 0.0

    def beside(self, residual: Any) -> "StrengthSurface":
        """Return this energy for rock where g is 1 + residual without damage.

        Parameters
        ----------
        residual : fraction of the stiffness that is added to g everywhere.
        """
        found = copy(self)
        found.residual = residual
        return found

    def density(self, e: Strained, g: Any) -> Any:
        """Return the density, see `EnergySplit`; in plane stress without any stress across."""
        assert e.principal is not None
        strains, hardening, n = e.principal.strains, self.hardening, len(e.principal.strains)
        softened = (1 + self.residual) / g - 1
        lambda_, mu = self._intact(e, softened)
        c = softened * (1 - self.sheared) * (1 + hardening) / e.principal.E
        total = sum(strains)
        # As if cracks of all directions were open.
        bulk, uneven = n * lambda_ + 2 * mu, sum((x - total / n) ** 2 for x in strains)
        psi = bulk / (1 + bulk * c / (n + hardening)) * total**2 / (2 * n)
        psi += mu / (1 + 2 * mu * c / hardening) * uneven
        # Without those that pressure keeps shut: elimination of one opening after the other.
        own, other = 1 + hardening + c * (lambda_ + 2 * mu), 1 + c * lambda_
        before = 0.0
        for k, x in enumerate(strains):
            stress = lambda_ * total + 2 * mu * x
            pivot = own + (k - 1) * other
            shut = negative(stress - other / pivot * before)
            psi += c / 2 * shut**2 * pivot / ((own - other) * (own + k * other))
            before += stress
        return psi

    def _intact(self, e: Strained, softened: Any) -> tuple[Any, Any]:
        """Return coefficients lambda, mu of rock that shear softens and whose cracks are shut."""
        assert e.principal is not None
        E, nu = e.principal.E, e.principal.nu
        mu = E / (2 * (1 + nu) + 3 * softened * self.sheared)
        lambda_ = e.K - 2 * mu / 3
        if len(e.principal.strains) == 2:
            lambda_ = 2 * lambda_ * mu / (lambda_ + 2 * mu)
        return lambda_, mu


def _squared_inverse(ratio: float) -> float:
    return 0.0 if isinf(ratio) else 1 / ratio**2


def least_biaxial(compressive: float) -> float:
    """Return what `biaxial` must exceed: two tensions would else break the rock independently.

    Parameters
    ----------
    compressive : see `StrengthSurface`.
    """
    return 1 / sqrt(2 - _squared_inverse(compressive))
