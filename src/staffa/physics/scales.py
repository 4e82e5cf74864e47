"""The lengths, strengths and numbers that tell beforehand what a cooled body will do."""

from math import inf, sqrt

from staffa.physics.damage import DamageLaw, has_threshold, strength
from staffa.physics.material import PLANE_STRESS


def severity(*, expansion: float, dT: float, E: float, L: float, Gc: float) -> float:
    """Thermal stress number expansion dT sqrt(E L/Gc): the paper's beta dT, 54 in its slab."""
    return expansion * dT * sqrt(E * L / Gc)


def dT_of_severity(*, severity: float, expansion: float, E: float, L: float, Gc: float) -> float:
    """Temperature drop (K) that gives this severity."""
    return severity / (expansion * sqrt(E * L / Gc))


def lateral_modulus(E: float, nu: float, state: str) -> float:
    """Modulus M with ell0 = Gc/(M (expansion dT)^2): E in plane stress, E(1+nu)/(1-nu) if both
    lateral strains are blocked (the stress E expansion dT/(1-nu) released over the plane-strain
    modulus E/(1-nu^2))."""
    return E if state == PLANE_STRESS else E * (1 + nu) / (1 - nu)


def ell0(*, E: float, nu: float, Gc: float, expansion: float, dT: float, state: str) -> float:
    """Length at which thermal stress and toughness balance (m): the unit of spacing and depth."""
    if dT == 0:
        return inf
    return Gc / (lateral_modulus(E, nu, state) * (expansion * dT) ** 2)


def critical_drop(
    law: DamageLaw, *, E: float, nu: float, Gc: float, expansion: float, ell: float, state: str
) -> float | None:
    """Temperature drop dT_c at which damage starts (K), or None for a law without threshold.

    Plane stress: sigma_c/(E expansion). Both lateral strains blocked: the energy density
    E (expansion dT)^2/(1 - nu) reaches the threshold that the bar reaches at sigma_c^2/(2 E), so
    dT_c = sigma_c sqrt((1 - nu)/2)/(E expansion), which is sqrt(3 Gc (1-nu)/(16 E ell))/expansion
    for AT1.
    """
    if not has_threshold(law):
        return None
    drop = strength(law, E=E, Gc=Gc, ell=ell) / (E * expansion)
    return drop if state == PLANE_STRESS else drop * sqrt((1 - nu) / 2)


def diffusion_length(kappa: float, t: float) -> float:
    """sqrt(kappa t) (m)."""
    return sqrt(kappa * t)


def tau_of_time(t: float, *, kappa: float, L: float) -> float:
    """tau = 2 sqrt(kappa t)/L, so that T = -dT erfc(y/(tau L)) in a half-space."""
    return 2 * sqrt(kappa * t) / L


def time_of_tau(tau: float, *, kappa: float, L: float) -> float:
    """Time (s) at which 2 sqrt(kappa t)/L = tau."""
    return tau**2 * L**2 / (4 * kappa)
