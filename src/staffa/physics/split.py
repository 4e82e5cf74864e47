"""Energy splits: the part of the stiffness that a crack keeps in compression.

A split turns an elastic strain and the fraction g of the stiffness that damage leaves into an
energy density, psi(e, g). It is convex in e, and psi(e, 1) is the undamaged density. In plane
stress the strain across the plane is that of undamaged rock, where sigma_zz = 0: the rock beside a
crack constrains its layer. Were that strain free, a crack in compression would be squeezed out and
carry nothing.
"""

from typing import Any, Protocol

import numpy as np

from staffa.physics.material import SOLID, lame
from staffa.physics.strained import Strained, across, negative, of_principal, positive
from staffa.physics.strength_surface import StrengthSurface


class EnergySplit(Protocol):
    """Energy split between tension and compression.

    No base class is needed: a class with these three members is a split.
    """

    @property
    def name(self) -> str:
        """Name in case files, tables and records."""
        ...

    @property
    def isotropic(self) -> bool:
        """True if it needs E, nu and principal strains, which only isotropic rock has."""
        ...

    def density(self, e: Strained, g: Any) -> Any:
        """Return the energy density (Pa) of a strain with the fraction g of the stiffness."""
        ...


class NoSplit:
    """Split g psi: a crack in compression carries as little as an open one."""

    name, isotropic = "none", False

    def density(self, e: Strained, g: Any) -> Any:
        """Return the density, see `EnergySplit`."""
        return g * e.psi


class StarConvex:
    """Split g psi + (1 - g) (1 + gamma) K/2 <volume>_-^2 (Vicentini et al. 2024).

    Cracks keep the stiffness against compaction. gamma = 0 is the volumetric-deviatoric split
    (Amor et al. 2009); gamma > 0 makes cracks (1 + gamma) times as stiff against compaction. K is
    Reuss's bulk modulus, so that anisotropic rock may be split as well: what is left of psi cannot
    be negative at gamma = 0.
    """

    isotropic = False

    def __init__(self, gamma: float = 0.0, name: str = "volumetric-deviatoric") -> None:
        self.gamma, self.name = gamma, name

    def density(self, e: Strained, g: Any) -> Any:
        """Return the density, see `EnergySplit`."""
        kept = (1 + self.gamma) * e.K / 2 * negative(e.volume) ** 2
        return g * e.psi + (1 - g) * kept


class Spectral:
    """Split g (lambda/2 <tr e>_+^2 + mu sum <e_i>_+^2) + lambda/2 <tr e>_-^2 + mu sum <e_i>_-^2.

    Miehe et al. 2010. For nu >= 0.
    """

    name, isotropic = "spectral", True

    def density(self, e: Strained, g: Any) -> Any:
        """Return the density, see `EnergySplit`."""
        assert e.principal is not None
        lambda_, mu = lame(e.principal.E, e.principal.nu, SOLID)
        strains = e.principal.strains
        if len(strains) == 2:
            strains = (*strains, across(strains, e.principal.nu))
        total = sum(strains)
        pulled, pressed = positive(total) ** 2, negative(total) ** 2
        squares = sum(g * positive(x) ** 2 + negative(x) ** 2 for x in strains)
        return lambda_ / 2 * (g * pulled + pressed) + mu * squares


class NoTension:
    """Split g psi + (1 - g) psi_-, with the density psi_- of a rock without any tension.

    Freddi and Royer-Carfagni 2010; psi_-(e) is the least psi(e - p) over strains p >= 0 of cracks.
    With the principal strains in order, psi is a sum of three squares, each the energy of one
    principal stress after those of the smaller strains: psi_- has their negative parts. The rock is
    infinitely strong in compression. For nu >= 0.
    """

    name, isotropic = "no-tension", True

    def density(self, e: Strained, g: Any) -> Any:
        """Return the density, see `EnergySplit`; in plane stress that of the plane."""
        assert e.principal is not None
        E, nu = e.principal.E, e.principal.nu
        least, *others = reversed(e.principal.strains)
        kept = E / 2 * negative(least) ** 2
        kept += E / (2 * (1 - nu**2)) * negative(others[0] + nu * least) ** 2
        if len(others) == 2:
            M = E * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
            kept += M / 2 * negative(others[1] + nu / (1 - nu) * (others[0] + least)) ** 2
        return g * e.psi + (1 - g) * kept


class Contact:
    """Split for cracks whose faces touch and slide: g psi + (1 - g) (psi_- + friction), normal n.

    Beside a crack psi_- is that of `NoTension` for the strain without the shear along the faces:
    the least energy of stresses without tension of which n is a principal direction. In the broken
    layer it is E/2 <n . e n>_-^2, the least energy that closes the crack so far: such a layer is
    jagged, so that its strain is no simple shear, and all of it is free but the part that presses
    the faces through one another. Directional splits: Steinke and Kaliske 2019, Fei and Choo 2020.
    Rock far from cracks has the energy of `NoTension`; so have strains without `faces`.

    Friction carries the shear stress b at most; b is frozen. Its energy is the least over the new
    slip s of G/2 (c - s)^2 + b |s|, with c the shear strain since the last step: Huber's function
    of c, with the shear modulus G of the rock.
    """

    name, isotropic = "contact", True

    def __init__(self, friction: float = 0.0) -> None:
        self.friction, self.intact = friction, NoTension()

    def density(self, e: Strained, g: Any) -> Any:
        """Return the density, see `EnergySplit`."""
        if e.faces is None:
            return self.intact.density(e, g)
        assert e.principal is not None
        closed = e.principal.E / 2 * negative(e.faces.normal) ** 2
        beside = self.intact.density(e.faces.unsheared, 0.0)
        kept = e.faces.broken * closed + (1 - e.faces.broken) * beside
        if self.friction:
            stuck = e.faces.shear - self.slip(e)
            kept += shear_modulus(e) / 2 * stuck**2 + e.faces.bound * self.slip(e)
        return g * e.psi + (1 - g) * kept

    def slip(self, e: Strained) -> Any:
        """Return the size of the new slip strain: the part of the shear beyond the bound."""
        assert e.faces is not None
        return e.faces.free * positive(e.faces.shear - e.faces.bound / shear_modulus(e))

    def rubbed(self, e: Strained, g: Any) -> Any:
        """Return the work of friction in the new slip (J/m^3), a part of the density."""
        assert e.faces is not None
        return (1 - g) * e.faces.bound * self.slip(e)


def shear_modulus(e: Strained) -> Any:
    """Return G of isotropic rock (Pa)."""
    assert e.principal is not None
    return e.principal.E / (2 * (1 + e.principal.nu))


NO_SPLIT = NoSplit()
SPLITS: dict[str, EnergySplit] = {
    "none": NO_SPLIT,
    "volumetric-deviatoric": StarConvex(),
    "star-convex": StarConvex(gamma=5.0, name="star-convex"),
    "spectral": Spectral(),
    "no-tension": NoTension(),
    "contact": Contact(),
    StrengthSurface.name: StrengthSurface(),
}


def is_linear_in_g(split: EnergySplit, *, plane_stress: bool) -> bool:
    """Return True if the density is linear in g: AT1 and AT2 make it quadratic in alpha."""
    places = np.array([-1.0, -0.3, 0.2, 1.1])
    sets = np.meshgrid(*[places] * (2 if plane_stress else 3))
    principal = -np.sort(-np.stack([s.ravel() for s in sets]), axis=0)
    e = of_principal(tuple(principal), E=1.0, nu=0.25)
    densities = [np.asarray(split.density(e, g)) for g in (0.1, 0.5, 0.9)]
    bend = densities[0] - 2 * densities[1] + densities[2]
    return bool(np.abs(bend).max() < 1e-12)


def is_quadratic_in_strain(split: EnergySplit, *, plane_stress: bool) -> bool:
    """Return True if the stress of a damaged point is linear in the strain.

    The density then obeys the parallelogram law, psi(a + b) + psi(a - b) = 2 psi(a) + 2 psi(b).
    """
    n = 2 if plane_stress else 3
    one, other = np.random.default_rng(0).normal(size=(2, 20, n))

    def density(strains: np.ndarray) -> np.ndarray:
        principal = -np.sort(-strains, axis=1)
        return np.asarray(split.density(of_principal(tuple(principal.T), E=1.0, nu=0.25), 0.3))

    sides = 2 * density(one) + 2 * density(other)
    diagonals = density(one + other) + density(one - other)
    return bool(np.abs(diagonals - sides).max() < 1e-12 * np.abs(sides).max())


def driven_density(split: EnergySplit, e: Strained) -> Any:
    """Return the part of the density that drives damage in undamaged rock, d psi/d g (Pa)."""
    step = 1e-6
    return (split.density(e, 1.0) - split.density(e, 1.0 - step)) / step


def driven_share(split: EnergySplit, principal: tuple[float, ...], nu: float) -> float:
    """Return the part of a strain's energy that drives damage in undamaged rock: 1 without a split.

    Parameters
    ----------
    split : the energy split.
    principal : principal strains, largest first: two in plane stress, else three.
    nu : Poisson's ratio.
    """
    e = of_principal(principal, E=1.0, nu=nu)
    return float(driven_density(split, e) / e.psi)
