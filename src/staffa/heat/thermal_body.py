"""Thermal properties and boundary conditions of a body."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from staffa.physics.temperature import Law

# Values at points x, shape (3, n), and a time t (s): shape (n,), or one value for all.
Values = Callable[[np.ndarray, float], np.ndarray | float]
# Values at points x and a time, for surface temperatures T (K), shape (n,).
SurfaceValues = Callable[[np.ndarray, float, np.ndarray], np.ndarray | float]
# Values at points alone, shape (3, n) -> (n,).
PointValues = Callable[[np.ndarray], np.ndarray]


def nothing(x: np.ndarray, t: float) -> float:
    """Return 0, at all points and times."""
    return 0.0


def everywhere_one(x: np.ndarray) -> np.ndarray:
    """Return 1 at every point."""
    return np.ones(x.shape[1])


@dataclass(frozen=True, kw_only=True)
class OfSurface:
    """Heat transfer coefficient that depends on the surface temperature.

    Attributes
    ----------
    at : function of points, time (s) and surface temperatures (K) that returns it (W/(m^2 K)).
    """

    at: SurfaceValues


@dataclass(frozen=True, kw_only=True)
class Dirichlet:
    """Boundary at a prescribed temperature.

    Attributes
    ----------
    side : name of the boundary.
    T : temperature (K).
    """

    side: str
    T: Values


@dataclass(frozen=True, kw_only=True)
class Neumann:
    """Boundary with a prescribed heat flux.

    Attributes
    ----------
    side : name of the boundary.
    q : flux into the body (W/m^2), negative if heat leaves.
    """

    side: str
    q: Values


@dataclass(frozen=True, kw_only=True)
class Robin:
    """Boundary with a convective condition.

    Attributes
    ----------
    side : name of the boundary.
    h : heat transfer coefficient (W/(m^2 K)).
    T : temperature of the fluid beyond it (K).
    """

    side: str
    h: Values | OfSurface
    T: Values


@dataclass(frozen=True, kw_only=True)
class Insulating:
    """Cracks that insulate.

    Attributes
    ----------
    residual : fraction of the conductivity left in them.
    """

    residual: float


@dataclass(frozen=True, kw_only=True)
class FluidFilledCrack:
    """Cracks full of a fluid that exchanges heat with both crack faces.

    Attributes
    ----------
    h : heat transfer coefficient of each face (W/(m^2 K)).
    T : temperature of the fluid (K).
    """

    h: Values | OfSurface
    T: Values


@dataclass(frozen=True, kw_only=True)
class Conductor:
    """Thermal properties of one rock.

    Attributes
    ----------
    k : conductivity (W/(m K)), a symmetric tensor as dim rows of dim numbers.
    rho_c : heat capacity per volume (J/(m^3 K)).
    k_factor, rho_c_factor : factors on them at points, evaluated at the center of each cell.
    k_law, c_law : factors on them by temperature; None for none.
    """

    k: tuple[tuple[float, ...], ...]
    rho_c: float
    k_factor: PointValues = everywhere_one
    rho_c_factor: PointValues = everywhere_one
    k_law: Law | None = None
    c_law: Law | None = None


@dataclass(frozen=True, kw_only=True)
class Conduction:
    """Heat equation rho c dT/dt = div(k grad T) + source; boundaries are insulated by default.

    Attributes
    ----------
    k : conductivity (W/(m K)), a symmetric tensor as dim rows of dim numbers.
    rho_c : heat capacity per volume (J/(m^3 K)).
    initial : temperature at t = 0 (K), a function of points.
    stress_free : stress-free temperature (K), a function of points; None for the initial one.
    k_factor : factor on k at points, evaluated at the center of each cell.
    rho_c_factor : factor on rho_c, likewise.
    k_law : factor on k by temperature; None for none.
    c_law : factor on rho_c by temperature, with the position of each vertex; None for none.
    regions : rocks of the domain's regions that differ from these.
    sides : boundary conditions.
    source : heat per volume and time (W/m^3).
    cracks : thermal effect of cracks; None for none.
    kinks : breakpoints in time (s), increasing: steps end there.
    tolerance : largest error of a substep, over the largest change of temperature since t = 0.
    agreement : largest difference of the temperature in staggered iterations that agree, likewise.
    passes : largest number of staggered iterations.
    """

    k: tuple[tuple[float, ...], ...]
    rho_c: float
    initial: PointValues
    stress_free: PointValues | None = None
    k_factor: PointValues = everywhere_one
    rho_c_factor: PointValues = everywhere_one
    k_law: Law | None = None
    c_law: Law | None = None
    regions: Mapping[str, Conductor] = field(default_factory=dict)
    sides: tuple[Dirichlet | Neumann | Robin, ...] = ()
    source: Values = nothing
    cracks: Insulating | FluidFilledCrack | None = None
    kinks: tuple[float, ...] = ()
    tolerance: float = 1e-4
    agreement: float = 1e-3
    passes: int = 50

    @property
    def linear(self) -> bool:
        """True if nothing in it depends on temperature."""
        rocks: tuple[Conduction | Conductor, ...] = (self, *self.regions.values())
        laws = any(rock.k_law or rock.c_law for rock in rocks)
        surfaces = [getattr(where, "h", None) for where in (*self.sides, self.cracks)]
        return not laws and not any(isinstance(h, OfSurface) for h in surfaces)
