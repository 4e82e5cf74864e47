"""Source of the temperature at the next time: a closed form, or the heat equation."""

from typing import Protocol

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np

from staffa.heat.thermal_body import Conduction
from staffa.heat.transient import HeatEquation
from staffa.loads.closed_form import Load
from staffa.model.domain import Domain
from staffa.model.fields import Spaces, vertices
from staffa.records.step import Heat


class Cooling(Protocol):
    """Temperature changes (K) at the vertices from time to time, ghosts included. Collective."""

    @property
    def feels_cracks(self) -> bool:
        """True if the temperature depends on the damage."""
        ...

    def start(self) -> np.ndarray:
        """Return the temperature change at t = 0, shape (n_local,)."""
        ...

    def advance(
        self, before: np.ndarray, alpha: np.ndarray, start: float, end: float
    ) -> tuple[np.ndarray, Heat | None]:
        """Return the temperature change at a later time, and the heat balance; it changes nothing.

        Parameters
        ----------
        before : temperature change at the start (K), shape (n_local,).
        alpha : damage, shape (n_local,).
        start : time at the start (s).
        end : time at the end (s).
        """
        ...

    def destroy(self) -> None:
        """Free the PETSc objects."""
        ...


class ClosedForm:
    """Temperature in closed form, which depends on position and time alone."""

    feels_cracks = False

    def __init__(self, load: Load, spaces: Spaces) -> None:
        self._load, self._x = load, vertices(spaces.alpha).T

    def start(self) -> np.ndarray:
        """Return 0: a change at t = 0 belongs to the first step."""
        return np.zeros(self._x.shape[1])

    def advance(
        self, before: np.ndarray, alpha: np.ndarray, start: float, end: float
    ) -> tuple[np.ndarray, None]:
        """Return the temperature change at `end`; before, alpha and start do not matter."""
        return self._load.temperature(self._x, end), None

    def destroy(self) -> None:
        """Free nothing."""


def cooling(load: Load | Conduction, domain: Domain, spaces: Spaces) -> Cooling:
    """Return the source of the temperature for a problem's load. Collective.

    Parameters
    ----------
    load : closed form, or heat equation.
    domain : the mesh.
    spaces : the function spaces.
    """
    if isinstance(load, Conduction):
        return HeatEquation(domain, spaces, load)
    return ClosedForm(load, spaces)
