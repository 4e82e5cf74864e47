"""Where the temperature of the next time comes from: a closed form, or the heat equation."""

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
    """Temperature changes (K) at the vertices, ghosts included, from time to time. Collective."""

    @property
    def feels_cracks(self) -> bool:
        """Whether the temperature depends on the damage."""
        ...

    def start(self) -> np.ndarray:
        """The temperature change at t = 0, shape (n_local,)."""
        ...

    def advance(
        self, before: np.ndarray, alpha: np.ndarray, start: float, end: float
    ) -> tuple[np.ndarray, Heat | None]:
        """The temperature change at a later time (s), and what the heat equation did; pure."""
        ...

    def destroy(self) -> None:
        """Free the PETSc objects."""
        ...


class ClosedForm:
    """A temperature that is known beforehand, and depends on the time alone."""

    feels_cracks = False

    def __init__(self, load: Load, spaces: Spaces) -> None:
        self._load, self._x = load, vertices(spaces.alpha).T

    def start(self) -> np.ndarray:
        """See `Cooling`: what happens at t = 0 itself belongs to the first step."""
        return np.zeros(self._x.shape[1])

    def advance(
        self, before: np.ndarray, alpha: np.ndarray, start: float, end: float
    ) -> tuple[np.ndarray, None]:
        """See `Cooling`."""
        return self._load.temperature(self._x, end), None

    def destroy(self) -> None:
        """Nothing to free."""


def cooling(load: Load | Conduction, domain: Domain, spaces: Spaces) -> Cooling:
    """What a problem's load stands for on these spaces. Collective."""
    if isinstance(load, Conduction):
        return HeatEquation(domain, spaces, load)
    return ClosedForm(load, spaces)
