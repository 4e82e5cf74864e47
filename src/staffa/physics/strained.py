"""Elastic strain as an energy split takes it: energy, change of volume, principal strains."""

from dataclasses import dataclass
from typing import Any

from staffa.physics.material import PLANE_STRESS, SOLID, energy_density, lame


@dataclass(frozen=True, kw_only=True)
class Principal:
    """Principal strains of isotropic rock.

    Attributes
    ----------
    E : Young's modulus (Pa).
    nu : Poisson's ratio.
    strains : largest first; two in plane stress, else three.
    """

    E: Any
    nu: Any
    strains: tuple[Any, ...]


@dataclass(frozen=True, kw_only=True)
class Strained:
    """Elastic strain as a split takes it. All members are float, numpy or UFL.

    Attributes
    ----------
    psi : undamaged energy density (Pa).
    volume : change of volume, the strain across the plane included.
    K : bulk modulus (Pa); K/2 volume^2 is the least energy of a change of volume.
    principal : principal strains, of isotropic rock only; else None.
    faces : the strain of a crack's faces, for a split that needs it, in a body; else None.
    """

    psi: Any
    volume: Any
    K: Any
    principal: Principal | None = None
    faces: "Faces | None" = None

    @property
    def isochoric(self) -> Any:
        """Part of psi that no change of volume needs, psi - K/2 volume^2 >= 0 (Pa)."""
        return self.psi - self.K / 2 * self.volume**2


@dataclass(frozen=True, kw_only=True)
class Faces:
    """Strain at the two faces of a crack; see `Contact`.

    Attributes
    ----------
    broken : 1 in the broken layer of a crack, 0 beside it.
    normal : strain across the crack, n . e n with its unit normal n.
    unsheared : the strain without the shear along the faces.
    shear : size of that shear strain, less the slip of earlier steps.
    bound : largest shear stress (Pa) that friction carries; 0 without friction.
    free : 0 if friction carries any shear stress, else 1.
    """

    broken: Any
    normal: Any
    unsheared: Strained
    shear: Any = 0.0
    bound: Any = 0.0
    free: Any = 1.0


def positive(x: Any) -> Any:
    """Return the positive part of x."""
    return (abs(x) + x) / 2


def negative(x: Any) -> Any:
    """Return the negative part of x, counted positive: x = positive(x) - negative(x)."""
    return (abs(x) - x) / 2


def in_order(a: Any, b: Any, c: Any) -> tuple[Any, Any, Any]:
    """Return three numbers, largest first.

    Parameters
    ----------
    a : first number, at least `b`.
    b : second number.
    c : third number, of any size.
    """
    largest = (a + c + abs(a - c)) / 2
    least = (b + c - abs(b - c)) / 2
    return largest, a + b + c - largest - least, least


def isotropic_strain(
    total: Any, square: Any, principal: tuple[Any, ...], *, E: Any, nu: Any
) -> Strained:
    """Return a strain e of isotropic rock as a split takes it.

    Parameters
    ----------
    total : tr e; in plane stress of the plane alone.
    square : e : e; in plane stress of the plane alone.
    principal : principal strains, largest first; in plane stress the two of the plane.
    E : Young's modulus (Pa).
    nu : Poisson's ratio.
    """
    plane_stress = len(principal) == 2
    lambda_, mu = lame(E, nu, PLANE_STRESS if plane_stress else SOLID)
    return Strained(
        psi=energy_density(total, square, lambda_, mu),
        volume=total + across(principal, nu) if plane_stress else total,
        K=E / (3 * (1 - 2 * nu)),
        principal=Principal(E=E, nu=nu, strains=principal),
    )


def across(principal: tuple[Any, ...], nu: Any) -> Any:
    """Return the strain across the plane of undamaged rock in plane stress."""
    return -nu / (1 - nu) * sum(principal)


def of_principal(principal: tuple[Any, ...], *, E: Any, nu: Any) -> Strained:
    """Return the strain of isotropic rock with these principal strains, see `isotropic_strain`.

    Parameters
    ----------
    principal : principal strains, largest first: two in plane stress, else three.
    E : Young's modulus (Pa).
    nu : Poisson's ratio.
    """
    return isotropic_strain(sum(principal), sum(x**2 for x in principal), principal, E=E, nu=nu)
