"""Closed forms of the heat that water takes from the walls of a fracture."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

NODES = 24  # of the contour of the inversion; more of them do not help in double precision
DEEP = 10.0  # diffusion lengths, at which an insulated boundary has no effect


@dataclass(frozen=True, kw_only=True)
class FractureHeat:
    """Water along a fracture, and conduction in the rock at a right angle to it.

    Heat balance of the water that meets one wall: W dT/dx + C dT/dt = k dT/dy at y = 0. With s of
    the Laplace transform, r = sqrt(s/kappa) and an insulated boundary at y = D, the drop over its
    largest value is exp(-x (C s + k r tanh(r D))/W) cosh(r (D - y))/cosh(r D)/s (Gringarten et al.
    1975). With no boundary it is erfc((k x/W + y)/(2 sqrt(kappa tau))) (Lauwerier 1955). The time
    tau = t - C x/W counts from when the water comes.

    Attributes
    ----------
    carried : W, heat that the water of one wall carries, per kelvin and width (W/(m K)).
    stored : C, heat capacity of half of the fracture, per area (J/(m^2 K)).
    k : conductivity of the rock (W/(m K)).
    rho_c : heat capacity of the rock per volume (J/(m^3 K)).
    depth : D, distance from the fracture to the insulated boundary (m); infinite for none.
    """

    carried: float
    stored: float
    k: float
    rho_c: float
    depth: float = np.inf

    def drop(self, x: np.ndarray, y: np.ndarray, t: float) -> np.ndarray:
        """Return the temperature drop over its largest value, 0 to 1, shape (n,).

        Parameters
        ----------
        x : distances along the fracture from the inlet (m), shape (n,).
        y : distances from the fracture (m), shape (n,).
        t : time (s).
        """
        return self._at(x, y, t, integrated=False)

    def integral(self, x: float, t: float) -> float:
        """Return the integral of the drop of the water at one place, from 0 to t (s).

        Parameters
        ----------
        x : distance along the fracture from the inlet (m).
        t : time (s).
        """
        return float(self._at(np.array([x]), np.zeros(1), t, integrated=True)[0])

    def _at(self, x: np.ndarray, y: np.ndarray, t: float, *, integrated: bool) -> np.ndarray:
        late = t - self.stored * x / self.carried
        come = late > 0
        found = np.zeros(len(x))
        if come.any():
            deep = self.depth > DEEP * np.sqrt(self.k / self.rho_c * t)
            law = self._unbounded if deep else self._bounded
            found[come] = law(x[come], y[come], late[come], integrated)
        return found

    def _unbounded(
        self, x: np.ndarray, y: np.ndarray, t: np.ndarray, integrated: bool
    ) -> np.ndarray:
        way = (self.k * x / self.carried + y) / np.sqrt(4 * self.k / self.rho_c)
        found = scipy.special.erfc(way / np.sqrt(t))
        if integrated:
            found = (t + 2 * way**2) * found
            found -= 2 * way * np.sqrt(t / np.pi) * np.exp(-(way**2) / t)
        return np.asarray(found)

    def _bounded(self, x: np.ndarray, y: np.ndarray, t: np.ndarray, integrated: bool) -> np.ndarray:
        x, y = x[:, None], y[:, None]

        def transform(s: np.ndarray) -> np.ndarray:
            r = np.sqrt(s * self.rho_c / self.k)
            # Of hyperbolic functions, in exponentials that do not overflow.
            twice = np.exp(-2 * r * self.depth)
            tanh = (1 - twice) / (1 + twice)
            away = np.exp(-r * y) * (1 + np.exp(-2 * r * (self.depth - y))) / (1 + twice)
            along = np.exp(-x * self.k * r * tanh / self.carried)
            return np.asarray(along * away / s ** (1 + integrated))

        return inverse_laplace(transform, t)


def inverse_laplace(transform: Callable[[np.ndarray], np.ndarray], t: np.ndarray) -> np.ndarray:
    """Return the function of time of which the Laplace transform is given, shape (n,).

    It is a sum over the fixed contour of Talbot, as Abate and Valko (2004) choose it.

    Parameters
    ----------
    transform : function of complex s, shape (n, nodes) -> (n, nodes); a row for each time.
    t : times (s), positive, shape (n,).
    """
    angle = np.pi * np.arange(1, NODES) / NODES
    cotangent = 1 / np.tan(angle)
    scale = 0.4 * NODES
    places = np.concatenate([[scale], scale * angle * (cotangent + 1j)])
    slope = 1 + 1j * (angle + (angle * cotangent - 1) * cotangent)
    weights = 0.4 * np.exp(places) * np.concatenate([[0.5], slope])
    values = transform(places / t[:, None])
    return np.asarray((weights * values).sum(axis=1).real / t)
