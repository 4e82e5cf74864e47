"""Isotropic thermo-elasticity: energy density and stress of an elastic strain."""

from typing import Any

PLANE_STRESS, PLANE_STRAIN, SOLID = "plane stress", "plane strain", "solid"
# A body of revolution in the plane of r and z, the third direction being around the axis.
AXIAL = "axisymmetric"


def lame(E: Any, nu: Any, state: str) -> tuple[Any, Any]:
    """Coefficients lambda, mu such that psi = lambda/2 tr(e)^2 + mu e:e.

    In plane stress lambda is the reduced one, 2 lambda mu/(lambda + 2 mu) = E nu/(1 - nu^2), and e
    has only the in-plane components; otherwise e is the three-dimensional strain.
    """
    mu = E / (2 * (1 + nu))
    if state == PLANE_STRESS:
        return E * nu / (1 - nu**2), mu
    return E * nu / ((1 + nu) * (1 - 2 * nu)), mu


def energy_density(trace: Any, square: Any, lambda_: Any, mu: Any) -> Any:
    """psi = lambda/2 tr(e)^2 + mu e:e of an elastic strain with this trace and square e:e."""
    return lambda_ / 2 * trace**2 + mu * square
