"""Isotropic thermo-elasticity: energy density and stress of an elastic strain."""

from typing import Any

PLANE_STRESS, PLANE_STRAIN, SOLID = "plane stress", "plane strain", "solid"
# A body of revolution in its meridian plane (r, z); the third direction is around the axis.
AXIAL = "axisymmetric"


def lame(E: Any, nu: Any, state: str) -> tuple[Any, Any]:
    """Return coefficients lambda, mu such that psi = lambda/2 tr(e)^2 + mu e:e.

    In plane stress lambda is the reduced one, 2 lambda mu/(lambda + 2 mu) = E nu/(1 - nu^2), and e
    has only the in-plane components; otherwise e is the three-dimensional strain.

    Parameters
    ----------
    E : Young's modulus (Pa).
    nu : Poisson's ratio.
    state : one of the states of this module, as `PLANE_STRESS`.
    """
    mu = E / (2 * (1 + nu))
    if state == PLANE_STRESS:
        return E * nu / (1 - nu**2), mu
    return E * nu / ((1 + nu) * (1 - 2 * nu)), mu


def energy_density(trace: Any, square: Any, lambda_: Any, mu: Any) -> Any:
    """Return psi = lambda/2 tr(e)^2 + mu e:e (Pa).

    Parameters
    ----------
    trace : tr(e) of the elastic strain.
    square : e:e of the elastic strain.
    lambda_ : first coefficient of `lame` (Pa).
    mu : second coefficient of `lame` (Pa).
    """
    return lambda_ / 2 * trace**2 + mu * square
