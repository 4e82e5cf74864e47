"""What the heat equation needs to know of a body: how it conducts, where heat enters and leaves."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from staffa.physics.temperature import Law

# Values at points x, shape (3, n), and a time t (s): shape (n,), or one value for all.
Values = Callable[[np.ndarray, float], np.ndarray | float]
# Values at points x and a time, where the surface has temperatures T (K), shape (n,).
SurfaceValues = Callable[[np.ndarray, float, np.ndarray], np.ndarray | float]
# Values at points alone, shape (3, n) -> (n,).
PointValues = Callable[[np.ndarray], np.ndarray]


def nothing(x: np.ndarray, t: float) -> float:
    """0, anywhere and ever."""
    return 0.0


def everywhere_one(x: np.ndarray) -> np.ndarray:
    """1 at every point."""
    return np.ones(x.shape[1])


@dataclass(frozen=True, kw_only=True)
class OfSurface:
    """A film coefficient (W/(m^2 K)) by the temperature of the surface behind it."""

    at: SurfaceValues


@dataclass(frozen=True, kw_only=True)
class Dirichlet:
    """A side at a prescribed temperature T (K)."""

    side: str
    T: Values


@dataclass(frozen=True, kw_only=True)
class Neumann:
    """A side through which heat enters at a prescribed flux q (W/m^2), negative where it leaves."""

    side: str
    q: Values


@dataclass(frozen=True, kw_only=True)
class Robin:
    """A side behind a film of coefficient h (W/(m^2 K)), beyond which there is a bath at T (K)."""

    side: str
    h: Values | OfSurface
    T: Values


@dataclass(frozen=True, kw_only=True)
class Insulating:
    """Cracks that hinder heat: in them this fraction of the conductivity is left."""

    residual: float


@dataclass(frozen=True, kw_only=True)
class FluidFilledCrack:
    """Cracks full of a fluid at T (K), each of whose two faces exchanges heat with it: a film of
    coefficient h (W/(m^2 K))."""

    h: Values | OfSurface
    T: Values


@dataclass(frozen=True, kw_only=True)
class Conductor:
    """How a rock conducts and stores heat: k, rho_c and factors on them as in `Conduction`."""

    k: tuple[tuple[float, ...], ...]
    rho_c: float
    k_factor: PointValues = everywhere_one
    rho_c_factor: PointValues = everywhere_one
    k_law: Law | None = None
    c_law: Law | None = None


@dataclass(frozen=True, kw_only=True)
class Conduction:
    """rho c dT/dt = div(k grad T) + source; sides are insulated where nothing else is said.

    k: conductivity (W/(m K)), a symmetric tensor as dim rows of dim numbers; rho_c: heat capacity
    a volume (J/(m^3 K)); k_factor, rho_c_factor: factors on them at points, evaluated in the middle
    of each cell; k_law, c_law: factors on them by temperature, None for no dependence on it (that
    of c with the place of each vertex); regions: the rock of the domain's regions that differs from
    these. initial: temperature (K) at points at t = 0; stress_free: the one without thermal strain,
    the initial one if None. source: heat made a volume and time (W/m^3). cracks: how they change
    the flow of heat; None for not at all.

    kinks: times (s), increasing, at which something prescribed changes its course: steps end there.
    tolerance: largest error of a time step of its own, over the largest change of temperature since
    t = 0 that there was at the start of the advance or in it. agreement: how well the temperature
    and the cracks that change it must agree at the end of a step, in the same measure; after so
    many passes at most.
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
