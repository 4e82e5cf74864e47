"""Elastic strain from displacement and temperature, as an energy split takes it."""

from dataclasses import dataclass
from math import pi

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import ufl
from dolfinx import fem

from staffa.model.axis import hoop_strain
from staffa.physics.elasticity import PAIRS
from staffa.physics.material import AXIAL, PLANE_STRAIN, PLANE_STRESS, SOLID, lame
from staffa.physics.strained import Strained, in_order, isotropic_strain

# Principal strains have no derivative where two are equal. In 2-D their difference is at least this
# fraction of the strain; in 3-D the angle that separates them is at least its square root, so that
# sums over them are off by this fraction.
APART = 1e-7
# A negligible squared strain.
NONE = 1e-30

# Positions of the in-plane components in Voigt's order.
IN_PLANE = [0, 1, 5]

type Coefficient = fem.Constant | fem.Function


@dataclass(frozen=True, kw_only=True)
class IsotropicRock:
    """Isotropic elasticity in forms.

    Attributes
    ----------
    E : Young's modulus (Pa): a constant, one a cell, or a function of temperature.
    nu : Poisson's ratio, likewise.
    state : one of the states of `physics.material`.
    """

    E: ufl.core.expr.Expr
    nu: ufl.core.expr.Expr
    state: str

    def strained(self, e: ufl.core.expr.Expr) -> Strained:
        """Return an elastic strain, 2 x 2 in plane stress, else 3 x 3, as a split takes it."""
        principal = principal_strains(e, self.state)
        return isotropic_strain(ufl.tr(e), ufl.inner(e, e), principal, E=self.E, nu=self.nu)

    def strain_of(self, stress: ufl.core.expr.Expr) -> ufl.core.expr.Expr:
        """Return the elastic strain of a stress (Pa), both 2 x 2 in plane stress, else 3 x 3."""
        identity = ufl.Identity(stress.ufl_shape[0])
        return ((1 + self.nu) * stress - self.nu * ufl.tr(stress) * identity) / self.E

    def opened(self, lost: ufl.core.expr.Expr, n: ufl.core.expr.Expr) -> ufl.core.expr.Expr:
        """Return the opening strain across n of a stress lost by rock (Pa), see `openings`."""
        lambda_, mu = lame(self.E, self.nu, self.state)
        return ufl.dot(n, _across(lost, n)) / (lambda_ + 2 * mu)


@dataclass(frozen=True, kw_only=True)
class AnisotropicRock:
    """Anisotropic elasticity in forms, one value a cell, in Voigt's order.

    Attributes
    ----------
    C : stiffness (Pa), 6 x 6; in plane stress that of the plane, 3 x 3.
    S : its inverse (1/Pa).
    swelling : change of volume over each stress component (1/Pa).
    K : Reuss's bulk modulus (Pa).
    """

    C: fem.Function
    S: fem.Function
    swelling: fem.Function
    K: fem.Function

    def strained(self, e: ufl.core.expr.Expr) -> Strained:
        """Return an elastic strain as a split takes it, see `IsotropicRock`."""
        strain = _voigt(e, 2)
        stress = ufl.dot(self.C, strain)
        volume = ufl.dot(self.swelling, stress)  # with the free strain across, in plane stress
        return Strained(psi=ufl.dot(strain, stress) / 2, volume=volume, K=self.K)

    def strain_of(self, stress: ufl.core.expr.Expr) -> ufl.core.expr.Expr:
        """Return the elastic strain of a stress (Pa), see `IsotropicRock`."""
        strain = ufl.dot(self.S, _voigt(stress, 1))
        places = _places(stress)
        number = {place: k for k, place in enumerate(places)}
        dim = stress.ufl_shape[0]

        def entry(i: int, j: int) -> ufl.core.expr.Expr:
            k = number[min(i, j), max(i, j)]
            return strain[k] if i == j else strain[k] / 2

        return ufl.as_tensor([[entry(i, j) for j in range(dim)] for i in range(dim)])

    def opened(self, lost: ufl.core.expr.Expr, n: ufl.core.expr.Expr) -> ufl.core.expr.Expr:
        """Return the opening strain across n of a lost stress (Pa), see `IsotropicRock`."""
        place = {ij: k for k, ij in enumerate(_places(lost))}

        def stiffness(i: int, j: int, k: int, m: int) -> ufl.core.expr.Expr:
            return self.C[place[min(i, j), max(i, j)], place[min(k, m), max(k, m)]]

        plane = range(n.ufl_shape[0])
        acoustic = ufl.as_matrix(
            [
                [
                    sum(n[j] * stiffness(i, j, k, m) * n[m] for j in plane for m in plane)
                    for k in plane
                ]
                for i in plane
            ]
        )
        return ufl.dot(n, ufl.dot(ufl.inv(acoustic), _across(lost, n)))


def _across(stress: ufl.core.expr.Expr, n: ufl.core.expr.Expr) -> ufl.core.expr.Expr:
    """Return the traction on a plane of normal n, which has as many components as the body."""
    plane = range(n.ufl_shape[0])
    return ufl.as_vector([sum(stress[i, j] * n[j] for j in plane) for i in plane])


def _places(e: ufl.core.expr.Expr) -> tuple[tuple[int, int], ...]:
    return PAIRS if e.ufl_shape[0] == 3 else tuple(PAIRS[k] for k in IN_PLANE)


def _voigt(e: ufl.core.expr.Expr, shear: int) -> ufl.core.expr.Expr:
    return ufl.as_vector([e[i, j] if i == j else shear * e[i, j] for i, j in _places(e)])


def reduced(C: np.ndarray, state: str) -> dict[str, np.ndarray]:
    """Return the numbers of `AnisotropicRock` for stiffnesses C (Pa), shape (n, 6, 6)."""
    S = np.linalg.inv(C)
    swelling = S[:, :3].sum(axis=1)
    K = 1 / swelling[:, :3].sum(axis=1)
    if state != PLANE_STRESS:
        return {"C": C, "S": S, "swelling": swelling, "K": K}
    plane = np.ix_(range(len(S)), IN_PLANE, IN_PLANE)
    S = S[plane]
    return {"C": np.linalg.inv(S), "S": S, "swelling": swelling[:, IN_PLANE], "K": K}


def embedded(e: ufl.core.expr.Expr, across: ufl.core.expr.Expr) -> ufl.core.expr.Expr:
    """Return a strain of the plane with the strain across it, 3 x 3."""
    zero = 0 * e[0, 0]
    return ufl.as_tensor([[e[0, 0], e[0, 1], zero], [e[1, 0], e[1, 1], zero], [zero, zero, across]])


def elastic_strain(u: fem.Function, free: ufl.core.expr.Expr, state: str) -> ufl.core.expr.Expr:
    """Return sym grad u less the free strain; 3 x 3, in plane stress 2 x 2.

    In plane strain the elastic strain across the plane is -free_zz (and so on). In plane stress
    only the 2 x 2 part of the plane counts; the rest is free. In a body of revolution the third
    direction is around the axis, where the strain is u_r/r.

    Parameters
    ----------
    u : displacement (m).
    free : strain that is free of stress, 3 x 3.
    state : one of the states of `physics.material`.
    """
    strain = ufl.sym(ufl.grad(u))
    if state == SOLID:
        return strain - free
    if state == PLANE_STRESS:
        return strain - ufl.as_tensor([[free[i, j] for j in range(2)] for i in range(2)])
    across = hoop_strain(u) if state == AXIAL else 0 * free[2, 2]
    return embedded(strain, across) - free


def principal_strains(e: ufl.core.expr.Expr, state: str) -> tuple[ufl.core.expr.Expr, ...]:
    """Return the eigenvalues, largest first: two in plane stress, else three.

    In plane strain and in a body of revolution the third direction is a principal one. In 3-D they
    follow from the angle of the deviator (Smith 1961).
    """
    if state == PLANE_STRESS:
        return _of_plane(e)
    if state in (PLANE_STRAIN, AXIAL):
        return in_order(*_of_plane(e), e[2, 2])
    middle = ufl.tr(e) / 3
    deviator = e - middle * ufl.Identity(3)
    size = ufl.sqrt(ufl.inner(deviator, deviator) / 6 + NONE)
    angle = ufl.acos((1 - APART) * ufl.det(deviator / size) / 2) / 3
    largest = middle + 2 * size * ufl.cos(angle)
    least = middle + 2 * size * ufl.cos(angle + 2 * pi / 3)
    return largest, 3 * middle - largest - least, least


def _of_plane(e: ufl.core.expr.Expr) -> tuple[ufl.core.expr.Expr, ufl.core.expr.Expr]:
    middle, half = (e[0, 0] + e[1, 1]) / 2, (e[0, 0] - e[1, 1]) / 2
    squares = e[0, 0] ** 2 + e[1, 1] ** 2 + 2 * e[0, 1] ** 2
    radius = ufl.sqrt(half**2 + e[0, 1] ** 2 + APART**2 * squares + NONE)
    return middle + radius, middle - radius
