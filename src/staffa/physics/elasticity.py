"""Elasticity of every class as a stiffness: 6 x 6, in Voigt's order xx, yy, zz, yz, xz, xy."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from staffa.errors import InputError

# Values at points: shape (3, n) -> (n,).
PointFunction = Callable[[np.ndarray], np.ndarray]
# A number of the rock: one for all of it, or one at each point.
Property = float | PointFunction

# Which components stand where.
PAIRS = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
# Part of the largest entry by which a stiffness may miss symmetry, as written numbers do.
ROUND_OFF = 1e-9
# Determinant of a compliance with ones on its diagonal that is zero but for rounding.
SINGULAR = 1e-14


class Elasticity(Protocol):
    """How a rock answers strains, place by place."""

    def stiffness(self, x: np.ndarray) -> np.ndarray:
        """C (Pa) along x, y, z, at points x, shape (3, n): stress = C strain, with shear strains
        doubled; symmetric and positive definite; shape (n, 6, 6)."""
        ...


def along_xyz() -> np.ndarray:
    """Material axes that are those of the body."""
    return np.eye(3)


@dataclass(frozen=True, kw_only=True, eq=False)
class Isotropic:
    """The same in all directions: Young's modulus E (Pa) and Poisson's ratio nu."""

    E: Property
    nu: Property

    def stiffness(self, x: np.ndarray) -> np.ndarray:
        """See `Elasticity`."""
        E, nu = values(self.E, x), values(self.nu, x)
        return inverse(compliance((E, E, E), (nu, nu, nu), (E / (2 * (1 + nu)),) * 3))


@dataclass(frozen=True, kw_only=True, eq=False)
class TransverselyIsotropic:
    """The same in all directions of a plane, such as bedding, and another across it.

    E, nu: of the plane of isotropy. E_axis: Young's modulus along the axis, the third material one;
    nu_axis: contraction in the plane over the stretch along the axis that a pull along it gives;
    G_axis: shear modulus between the axis and the plane (moduli in Pa). axes: rows are the material
    axes along x, y, z.
    """

    E: Property
    nu: Property
    E_axis: Property
    nu_axis: Property
    G_axis: Property
    axes: np.ndarray = field(default_factory=along_xyz)

    def stiffness(self, x: np.ndarray) -> np.ndarray:
        """See `Elasticity`."""
        E, nu, E_axis = values(self.E, x), values(self.nu, x), values(self.E_axis, x)
        across = values(self.nu_axis, x) * E / E_axis
        G, G_axis = E / (2 * (1 + nu)), values(self.G_axis, x)
        S = compliance((E, E, E_axis), (nu, across, across), (G_axis, G_axis, G))
        return turned(inverse(S), self.axes)


@dataclass(frozen=True, kw_only=True, eq=False)
class Orthotropic:
    """Another along each of three perpendicular axes, which shear does not couple.

    E: along each axis (Pa); nu: nu12, nu23, nu13, where nu_ij is the contraction along j over the
    stretch along i that a pull along i gives; G: G12, G23, G13 (Pa). axes: rows are the material
    axes along x, y, z.
    """

    E: tuple[Property, Property, Property]
    nu: tuple[Property, Property, Property]
    G: tuple[Property, Property, Property]
    axes: np.ndarray = field(default_factory=along_xyz)

    def stiffness(self, x: np.ndarray) -> np.ndarray:
        """See `Elasticity`."""
        E1, E2, E3 = (values(E, x) for E in self.E)
        nu12, nu23, nu13 = (values(nu, x) for nu in self.nu)
        G12, G23, G13 = (values(G, x) for G in self.G)
        S = compliance((E1, E2, E3), (nu12, nu23, nu13), (G23, G13, G12))
        return turned(inverse(S), self.axes)


@dataclass(frozen=True, kw_only=True, eq=False)
class Full:
    """Any elasticity there is: C (Pa) along the material axes, shape (6, 6); see `Elasticity`."""

    C: np.ndarray
    axes: np.ndarray = field(default_factory=along_xyz)

    def stiffness(self, x: np.ndarray) -> np.ndarray:
        """See `Elasticity`."""
        one = turned(np.asarray(self.C, dtype=float)[None], self.axes)
        return np.broadcast_to(one, (x.shape[1], 6, 6))


def values(given: Property, x: np.ndarray) -> np.ndarray:
    """A property at points, shape (3, n) -> (n,)."""
    return given(x) if callable(given) else np.full(x.shape[1], float(given))


def compliance(
    E: tuple[np.ndarray, ...], nu: tuple[np.ndarray, ...], G: tuple[np.ndarray, ...]
) -> np.ndarray:
    """S with strain = S stress along material axes that shear does not couple; shape (n, 6, 6).

    Parameters
    ----------
    E, nu, G : E1, E2, E3; nu12, nu23, nu13; G23, G13, G12, each of shape (n,).
    """
    S = np.zeros((len(E[0]), 6, 6))
    for i in range(3):
        S[:, i, i], S[:, i + 3, i + 3] = 1 / E[i], 1 / G[i]
    for (i, j), ratio in zip(((0, 1), (1, 2), (0, 2)), nu, strict=True):
        S[:, i, j] = S[:, j, i] = -ratio / E[i]
    return S


def inverse(S: np.ndarray) -> np.ndarray:
    """The stiffness of a compliance, symmetric to the last digit; where it has none, NaN."""
    scale = np.sqrt(np.abs(np.diagonal(S, axis1=1, axis2=2)))
    singular = ~(np.abs(np.linalg.det(S / (scale[:, :, None] * scale[:, None, :]))) > SINGULAR)
    C = np.linalg.inv(np.where(singular[:, None, None], np.eye(6), S))
    C[singular] = np.nan
    return np.asarray((C + C.swapaxes(1, 2)) / 2)


def strain_rotation(axes: np.ndarray) -> np.ndarray:
    """Strains (shear doubled) along x, y, z -> along the axes, its rows; shape (6, 6).

    The matrix of Bond (Proc. Phys. Soc. B 56, 1, 1943), column by column from e' = Q e Q^T.
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
    """A stiffness along x, y, z from one along the axes, its rows: energies stay what they are."""
    M = strain_rotation(axes)
    return np.asarray(M.T @ C @ M)


def checked(C: np.ndarray) -> np.ndarray:
    """Stiffnesses, shape (n, 6, 6), if each is symmetric and positive definite.

    Raises
    ------
    InputError
        One of them is not: a strain would cost nothing, or release energy.
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
    """E and nu of the isotropic rock that is nearest to a stiffness, shape (6, 6): Voigt's average.

    Its moduli of compression and shear are those of C averaged over all directions (Hill, Proc.
    Phys. Soc. A 65, 349, 1952, eqs. 3 and 4).
    """
    direct, coupled = np.trace(C[:3, :3]), C[0, 1] + C[1, 2] + C[0, 2]
    K = (direct + 2 * coupled) / 9
    G = (direct - coupled + 3 * np.trace(C[3:, 3:])) / 15
    return float(9 * K * G / (3 * K + G)), float((3 * K - 2 * G) / (2 * (3 * K + G)))


def effective_nu(C: np.ndarray) -> np.ndarray:
    """Poisson's ratio of isotropic rock whose volume and shape resist as those of stiffnesses do,
    shape (n, 6, 6) -> (n,): the volume by Reuss's modulus, so that it nears 1/2 only where no
    strain changes the volume at little cost; the shape by Voigt's."""
    K = 1 / np.linalg.inv(C)[:, :3, :3].sum(axis=(1, 2))
    direct = np.trace(C[:, :3, :3], axis1=1, axis2=2)
    coupled = C[:, 0, 1] + C[:, 1, 2] + C[:, 0, 2]
    G = (direct - coupled + 3 * np.trace(C[:, 3:, 3:], axis1=1, axis2=2)) / 15
    nu: np.ndarray = (3 * K - 2 * G) / (2 * (3 * K + G))
    return nu
