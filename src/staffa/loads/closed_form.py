"""Temperatures known in closed form: of a face that is cooled by dT, and any other."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import pi, sqrt
from typing import Any, Protocol

import numpy as np
import scipy

from staffa.loads.forces import InSpaceAndTime


class Load(Protocol):
    """A temperature field known beforehand.

    A user's own load is any object with this one method. It may have a second one, `pressure`, with
    the same arguments: that of a fluid in pores and cracks (Pa), see `pressure_of`.
    """

    def temperature(self, x: np.ndarray, t: float) -> np.ndarray:
        """Return the temperature change (K), shape (n,), at points x, shape (3, n), and time t."""
        ...


class CoupledLoad(Protocol):
    """A source of temperatures whose values are not known beforehand, so that it must name itself.

    A user's own is any object whose class `evolution.coupling.coupling_of` knows.
    """

    def identity(self) -> str | float | Sequence[float]:
        """Return a short text, or numbers, by which a run that goes on knows it again."""
        ...


def pressure_of(load: Any) -> InSpaceAndTime | None:
    """Return the pressure (Pa) that a load gives beside the temperature; None without one.

    Parameters
    ----------
    load : any load.
    """
    found = getattr(load, "pressure", None)
    return found if callable(found) else None


@dataclass(frozen=True, kw_only=True)
class Face:
    """Plane x[axis] = position at the boundary of a body.

    Attributes
    ----------
    axis : the axis, 0, 1 or 2.
    position : coordinate of the plane along the axis (m).
    inward : direction into the body along the axis, +1 or -1.
    """

    axis: int
    position: float
    inward: int

    def depth(self, x: np.ndarray) -> np.ndarray:
        """Return the distance (m) from the face of the points x, shape (3, n)."""
        return np.asarray(self.inward * (x[self.axis] - self.position))


class NoLoad:
    """T = 0 always: for cases driven by prescribed displacements."""

    def temperature(self, x: np.ndarray, t: float) -> np.ndarray:
        """Return zeros, shape (n,)."""
        return np.zeros(x.shape[1])


@dataclass(frozen=True, kw_only=True)
class HalfSpace:
    """T = -dT erfc(y/(2 sqrt(kappa t))): the face drops at once, the body is infinitely deep.

    Attributes
    ----------
    dT : temperature drop of the face (K).
    kappa : diffusivity (m^2/s).
    face : the cooled face; y is the depth below it (m).
    """

    dT: float
    kappa: float
    face: Face

    def temperature(self, x: np.ndarray, t: float) -> np.ndarray:
        """See `Load`."""
        y = self.face.depth(x)
        if t == 0:
            return np.where(y <= 0, -self.dT, 0.0)
        return np.asarray(-self.dT * scipy.special.erfc(y / (2 * sqrt(self.kappa * t))))


@dataclass(frozen=True, kw_only=True)
class Slab:
    """The face drops at once, the side at depth L is insulated.

    Late: T = -dT (1 - sum 4/(m pi) exp(-m^2 pi^2 Fo/4) sin(m pi y/(2 L))) over odd m, Fo =
    kappa t/L^2. Early: the same field as alternating images of the half-space solution. Carslaw
    and Jaeger, Conduction of Heat in Solids, 3.3 and 3.4.

    Attributes
    ----------
    dT : temperature drop of the face (K).
    kappa : diffusivity (m^2/s).
    face : the cooled face; y is the depth below it (m).
    L : depth of the insulated side below the face (m).
    """

    dT: float
    kappa: float
    face: Face
    L: float

    def temperature(self, x: np.ndarray, t: float) -> np.ndarray:
        """See `Load`."""
        y = self.face.depth(x)
        if t == 0:
            return np.where(y <= 0, -self.dT, 0.0)
        fourier = self.kappa * t / self.L**2
        return -self.dT * (self._series(y, fourier) if fourier > 0.2 else self._images(y, t))

    def _series(self, y: np.ndarray, fourier: float) -> np.ndarray:
        odd = np.arange(1, 20, 2)[:, None]  # the last term is below 1e-70 at Fo = 0.2
        amplitude = 4 / (odd * pi) * np.exp(-(odd**2) * pi**2 / 4 * fourier)
        return np.asarray(
            1 - (amplitude * np.sin(odd * pi * y[None, :] / (2 * self.L))).sum(axis=0)
        )

    def _images(self, y: np.ndarray, t: float) -> np.ndarray:
        scale = 2 * sqrt(self.kappa * t)
        images = np.zeros_like(y)
        for n in range(6):  # at Fo = 0.2 the sixth image is below erfc(11) < 1e-50
            near, far = 2 * n * self.L + y, 2 * (n + 1) * self.L - y
            both = scipy.special.erfc(near / scale) + scipy.special.erfc(far / scale)
            images += (-1) ** n * both
        return images


@dataclass(frozen=True, kw_only=True)
class Convective:
    """Half-space whose face loses heat to a bath dT colder; h = Bi/L is film over conductivity.

    T = -dT (erfc(eta) - exp(h y + h^2 kappa t) erfc(eta + h sqrt(kappa t))), eta = y/(2 sqrt(kappa
    t)); the second term written with erfcx, which does not overflow.

    Attributes
    ----------
    dT : temperature of the rock over that of the bath (K).
    kappa : diffusivity (m^2/s).
    face : the cooled face; y is the depth below it (m).
    h : film coefficient over conductivity (1/m).
    """

    dT: float
    kappa: float
    face: Face
    h: float

    def temperature(self, x: np.ndarray, t: float) -> np.ndarray:
        """See `Load`."""
        y = self.face.depth(x)
        if t == 0:
            return np.zeros_like(y)
        eta = y / (2 * sqrt(self.kappa * t))
        film = np.exp(-(eta**2)) * scipy.special.erfcx(eta + self.h * sqrt(self.kappa * t))
        return np.asarray(-self.dT * (scipy.special.erfc(eta) - film))


@dataclass(frozen=True, kw_only=True)
class AnyTemperature:
    """Temperature change of place and time alone, such as a formula: it may warm as well as cool.

    Attributes
    ----------
    change : temperature change at points and a time (K), shape (n,).
    """

    change: InSpaceAndTime

    def temperature(self, x: np.ndarray, t: float) -> np.ndarray:
        """See `Load`."""
        return np.array(self.change(x, t), dtype=float)


@dataclass(frozen=True, kw_only=True)
class CooledFace:
    """Cooling in closed form, as a case gives it.

    Parameters
    ----------
    dT
        Temperature drop of the face, or of the fluid beyond it (K).
    kappa
        Diffusivity (m^2/s).
    face
        The face.
    L
        Depth of the body (m).
    biot
        h L/k of a convective face; None if the case gives none.
    """

    dT: float
    kappa: float
    face: Face
    L: float
    biot: float | None = None


def _convective(cooled: CooledFace) -> Load:
    assert cooled.biot is not None  # a rule of cases
    h = cooled.biot / cooled.L
    return Convective(dT=cooled.dT, kappa=cooled.kappa, face=cooled.face, h=h)


# Closed forms by the name that a case gives as `temperature.profile`. Each only cools: the default
# split of a case relies on that.
PROFILES: dict[str, Callable[[CooledFace], Load]] = {
    "half-space": lambda c: HalfSpace(dT=c.dT, kappa=c.kappa, face=c.face),
    "slab": lambda c: Slab(dT=c.dT, kappa=c.kappa, face=c.face, L=c.L),
    "convective": _convective,
}
