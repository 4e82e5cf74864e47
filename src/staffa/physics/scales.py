"""Lengths, strengths and dimensionless numbers of a cooled body, known before a run."""

from math import inf, sqrt

from staffa.physics.damage import DamageLaw, has_threshold, strength
from staffa.physics.material import PLANE_STRESS


def severity(*, expansion: float, dT: float, E: float, L: float, Gc: float) -> float:
    """Return the severity expansion dT sqrt(E L/Gc): the paper's beta dT, 54 in its slab.

    Parameters
    ----------
    expansion : thermal expansion (1/K).
    dT : temperature drop (K).
    E : Young's modulus (Pa).
    L : depth of the body (m).
    Gc : fracture toughness (J/m^2).
    """
    return expansion * dT * sqrt(E * L / Gc)


def dT_of_severity(*, severity: float, expansion: float, E: float, L: float, Gc: float) -> float:
    """Return the temperature drop (K) that gives this severity.

    Parameters
    ----------
    severity : thermal stress number.
    expansion : thermal expansion (1/K).
    E : Young's modulus (Pa).
    L : depth of the body (m).
    Gc : fracture toughness (J/m^2).
    """
    return severity / (expansion * sqrt(E * L / Gc))


def lateral_modulus(E: float, nu: float, state: str) -> float:
    """Return the modulus M (Pa) with ell0 = Gc/(M (expansion dT)^2).

    M is E in plane stress, and E(1+nu)/(1-nu) if both lateral strains are blocked: the stress
    E expansion dT/(1-nu), released over the plane-strain modulus E/(1-nu^2).

    Parameters
    ----------
    E : Young's modulus (Pa).
    nu : Poisson's ratio.
    state : one of the states of `material`.
    """
    return E if state == PLANE_STRESS else E * (1 + nu) / (1 - nu)


def ell0(*, E: float, nu: float, Gc: float, expansion: float, dT: float, state: str) -> float:
    """Return the thermal fracture length (m), the unit of crack spacing and depth.

    Parameters
    ----------
    E : Young's modulus (Pa).
    nu : Poisson's ratio.
    Gc : fracture toughness (J/m^2).
    expansion : thermal expansion (1/K).
    dT : temperature drop (K).
    state : one of the states of `material`.
    """
    if dT == 0:
        return inf
    return Gc / (lateral_modulus(E, nu, state) * (expansion * dT) ** 2)


def critical_drop(
    law: DamageLaw, *, E: float, nu: float, Gc: float, expansion: float, ell: float, state: str
) -> float | None:
    """Return the critical temperature drop (K), at which damage starts; None without threshold.

    Plane stress: sigma_c/(E expansion). Both lateral strains blocked: the energy density
    E (expansion dT)^2/(1 - nu) reaches the threshold that the bar reaches at sigma_c^2/(2 E), so
    dT_c = sigma_c sqrt((1 - nu)/2)/(E expansion), which is sqrt(3 Gc (1-nu)/(16 E ell))/expansion
    for AT1.

    Parameters
    ----------
    law : the damage law.
    E : Young's modulus (Pa).
    nu : Poisson's ratio.
    Gc : fracture toughness (J/m^2).
    expansion : thermal expansion (1/K).
    ell : regularization length (m).
    state : one of the states of `material`.
    """
    if not has_threshold(law):
        return None
    drop = strength(law, E=E, Gc=Gc, ell=ell) / (E * expansion)
    return drop if state == PLANE_STRESS else drop * sqrt((1 - nu) / 2)


def diffusion_length(kappa: float, t: float) -> float:
    """Return sqrt(kappa t) (m)."""
    return sqrt(kappa * t)


def tau_of_time(t: float, *, kappa: float, L: float) -> float:
    """Return tau = 2 sqrt(kappa t)/L, so that T = -dT erfc(y/(tau L)) in a half-space.

    Parameters
    ----------
    t : time (s).
    kappa : diffusivity (m^2/s).
    L : depth of the body (m).
    """
    return 2 * sqrt(kappa * t) / L


def time_of_tau(tau: float, *, kappa: float, L: float) -> float:
    """Return the time (s) at which 2 sqrt(kappa t)/L = tau.

    Parameters
    ----------
    tau : dimensionless time.
    kappa : diffusivity (m^2/s).
    L : depth of the body (m).
    """
    return tau**2 * L**2 / (4 * kappa)
