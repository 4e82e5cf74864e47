"""Elasticity as a stiffness tensor, 6 x 6, in Voigt's order xx, yy, zz, yz, xz, xy."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from staffa.errors import InputError

# Values at points: shape (3, n) -> (n,).
PointFunction = Callable[[np.ndarray], np.ndarray]
# A material property: one number for all rock, or one at each point.
Property = float | PointFunction

# Components of a symmetric tensor in Voigt's order.
PAIRS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
# Part of the largest entry by which a stiffness may miss symmetry, since numbers are rounded.
ROUND_OFF = 1e-9
# Determinant of a compliance, scaled to ones on its diagonal, that is zero within round-off.
SINGULAR = 1e-14


class Elasticity(Protocol):
    """Elastic law of a rock, point by point."""

    def stiffness(self, x: np.ndarray) -> np.ndarray:
        """Return C (Pa) along x, y, z at points x, shape (3, n): stress = C strain.

        Shear strains are doubled; C is symmetric and positive definite, shape (n, 6, 6).
        """
        ...


def along_xyz() -> np.ndarray:
    """Return the axes of the body as material axes."""
    return np.eye(3)


@dataclass(frozen=True, kw_only=True, eq=False)
class Isotropic:
    """Isotropic elasticity.

    Attributes
    ----------
    E : Young's modulus (Pa).
    nu : Poisson's ratio.
    """

    E: Property
    nu: Property

    def stiffness(self, x: np.ndarray) -> np.ndarray:
        """Return C at points, see `Elasticity`."""
        E, nu = values(self.E, x), values(self.nu, x)
        return inverse(compliance((E, E, E), (nu, nu, nu), (E / (2 * (1 + nu)),) * 3))


@dataclass(frozen=True, kw_only=True, eq=False)
class TransverselyIsotropic:
    """Elasticity that is isotropic in a plane, such as bedding, and different across it.

    Attributes
    ----------
    E : Young's modulus in the plane (Pa).
    nu : Poisson's ratio in the plane.
    E_axis : Young's modulus along the axis, the third material axis (Pa).
    nu_axis : contraction in the plane over extension along the axis, in tension along the axis.
    G_axis : shear modulus between axis and plane (Pa).
    axes : material axes along x, y, z, one a row, shape (3, 3).
    """

    E: Property
    nu: Property
    E_axis: Property
    nu_axis: Property
    G_axis: Property
    axes: np.ndarray = field(default_factory=along_xyz)

    def stiffness(self, x: np.ndarray) -> np.ndarray:
        """Return C at points, see `Elasticity`."""
        E, nu, E_axis = values(self.E, x), values(self.nu, x), values(self.E_axis, x)
        across = values(self.nu_axis, x) * E / E_axis
        G, G_axis = E / (2 * (1 + nu)), values(self.G_axis, x)
        S = compliance((E, E, E_axis), (nu, across, across), (G_axis, G_axis, G))
        return turned(inverse(S), self.axes)


@dataclass(frozen=True, kw_only=True, eq=False)
class Orthotropic:
    """Elasticity with different moduli along three perpendicular axes, which shear does not couple.

    Attributes
    ----------
    E : Young's moduli E1, E2, E3 along the axes (Pa).
    nu : Poisson's ratios nu12, nu23, nu13; nu_ij is the contraction along j over the extension
        along i, in tension along i.
    G : shear moduli G12, G23, G13 (Pa).
    axes : material axes along x, y, z, one a row, shape (3, 3).
    """

    E: tuple[Property, Property, Property]
    nu: tuple[Property, Property, Property]
    G: tuple[Property, Property, Property]
    axes: np.ndarray = field(default_factory=along_xyz)

    def stiffness(self, x: np.ndarray) -> np.ndarray:
        """Return C at points, see `Elasticity`."""
        E1, E2, E3 = (values(E, x) for E in self.E)
        nu12, nu23, nu13 = (values(nu, x) for nu in self.nu)
        G12, G23, G13 = (values(G, x) for G in self.G)
        S = compliance((E1, E2, E3), (nu12, nu23, nu13), (G23, G13, G12))
        return turned(inverse(S), self.axes)


@dataclass(frozen=True, kw_only=True, eq=False)
class Full:
    """General elasticity.

    Attributes
    ----------
    C : stiffness tensor along the material axes (Pa), shape (6, 6); see `Elasticity`.
    axes : material axes along x, y, z, one a row, shape (3, 3).
    """

    C: np.ndarray
    axes: np.ndarray = field(default_factory=along_xyz)

    def stiffness(self, x: np.ndarray) -> np.ndarray:
        """Return C at points, see `Elasticity`."""
        one = turned(np.asarray(self.C, dtype=float)[None], self.axes)
        return np.broadcast_to(one, (x.shape[1], 6, 6))


def values(given: Property, x: np.ndarray) -> np.ndarray:
    """Return a property at points, shape (3, n) -> (n,)."""
    return given(x) if callable(given) else np.full(x.shape[1], float(given))


def compliance(
    E: tuple[np.ndarray, ...], nu: tuple[np.ndarray, ...], G: tuple[np.ndarray, ...]
) -> np.ndarray:
    """Return S with strain = S stress along material axes that shear does not couple; (n, 6, 6).

    Parameters
    ----------
    E : E1, E2, E3 (Pa), each of shape (n,).
    nu : nu12, nu23, nu13, each of shape (n,).
    G : G23, G13, G12 (Pa), each of shape (n,).
    """
    S = np.zeros((len(E[0]), 6, 6))
    for i in range(3):
        S[:, i, i], S[:, i + 3, i + 3] = 1 / E[i], 1 / G[i]
    for (i, j), ratio in zip(((0, 1), (1, 2), (0, 2)), nu, strict=True):
        S[:, i, j] = S[:, j, i] = -ratio / E[i]
    return S


def inverse(S: np.ndarray) -> np.ndarray:
    """Return the stiffness of a compliance, exactly symmetric; NaN if there is none."""
    scale = np.sqrt(np.abs(np.diagonal(S, axis1=1, axis2=2)))
    singular = ~(np.abs(np.linalg.det(S / (scale[:, :, None] * scale[:, None, :]))) > SINGULAR)
    C = np.linalg.inv(np.where(singular[:, None, None], np.eye(6), S))
    C[singular] = np.nan
    return np.asarray((C + C.swapaxes(1, 2)) / 2)


def strain_rotation(axes: np.ndarray) -> np.ndarray:
    """Return the matrix, (6, 6), from strains along x, y, z to those along axes (shear doubled).

    The matrix of Bond (Proc. Phys. Soc. B 56, 1, 1943), column by column from e' = Q e Q^T. The
    axes are the rows of Q.
    """
    M = np.empty((6, 6))
    for column, (i, j) in enumerate(PAIRS):
        e = np.zeros((3, 3))
        e[i, j] += 0.5
        e[j, i] += 0.5
        seen = axes @ e @ axes.T
        M[:, column] = [seen[k, m] if k == m else 2 * seen[k, m] for k, m in PAIRS]
    return M


def turned(C: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Rotate a stiffness from the axes, one a row, to x, y, z; energies do not change."""
    M = strain_rotation(axes)
    return np.asarray(M.T @ C @ M)


def checked(C: np.ndarray) -> np.ndarray:
    """Return the stiffnesses, shape (n, 6, 6), if each is symmetric and positive definite.

    Raises
    ------
    InputError
        One is not: some strain would have no energy, or release energy.
    """
    uneven = np.abs(C - C.swapaxes(1, 2)).max(axis=0, initial=0.0)
    if uneven.max() > ROUND_OFF * np.abs(C).max(initial=0.0):
        i, j = np.unravel_index(np.argmax(uneven), (6, 6))
        raise InputError(
            f"the stiffness is not symmetric: its entries {i + 1},{j + 1} and {j + 1},{i + 1} "
            f"differ by {uneven[i, j]:.3g}; give both the same"
        )
    least = float(np.linalg.eigvalsh(C).min(initial=np.inf)) if np.all(np.isfinite(C)) else np.nan
    if not least > 0:
        what = f"its smallest eigenvalue is {least:.3g}" if least < 0 else "it has no finite one"
        raise InputError(
            f"the stiffness is not positive definite ({what}): there are strains that it does not "
            f"resist; take smaller Poisson's ratios, or smaller entries off the diagonal"
        )
    return C


def isotropic_average(C: np.ndarray) -> tuple[float, float]:
    """Return E (Pa) and nu of the isotropic rock nearest to a stiffness, (6, 6): Voigt's average.

    Its bulk and shear moduli are those of C averaged over all directions (Hill, Proc. Phys. Soc. A
    65, 349, 1952, eqs. 3 and 4).
    """
    direct, coupled = np.trace(C[:3, :3]), C[0, 1] + C[1, 2] + C[0, 2]
    K = (direct + 2 * coupled) / 9
    G = (direct - coupled + 3 * np.trace(C[3:, 3:])) / 15
    return float(9 * K * G / (3 * K + G)), float((3 * K - 2 * G) / (2 * (3 * K + G)))


def effective_nu(C: np.ndarray) -> np.ndarray:
    """Return Poisson's ratio of isotropic rock with equivalent moduli, shape (n, 6, 6) -> (n,).

    The bulk modulus is Reuss's, so that the ratio nears 1/2 only if every change of volume is
    stiff; the shear modulus is Voigt's.
    """
    K = 1 / np.linalg.inv(C)[:, :3, :3].sum(axis=(1, 2))
    direct = np.trace(C[:, :3, :3], axis1=1, axis2=2)
    coupled = C[:, 0, 1] + C[:, 1, 2] + C[:, 0, 2]
    G = (direct - coupled + 3 * np.trace(C[:, 3:, 3:], axis1=1, axis2=2)) / 15
    nu: np.ndarray = (3 * K - 2 * G) / (2 * (3 * K + G))
    return nu
