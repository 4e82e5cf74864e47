"""Sources of the temperature, coupled to mechanics, and the choice of one for a problem.

The time loop asks for what stands in `ThermalCoupling`, and for nothing else. A further source of
temperatures is a class with these members and a line in `coupling_of`.
"""

from functools import singledispatch
from typing import Any

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np

from staffa.backend.parallel import max_over_ranks
from staffa.evolution.circulated import Circulated
from staffa.evolution.thermal_state import Agreement as Agreement
from staffa.evolution.thermal_state import Cracks as Cracks
from staffa.evolution.thermal_state import ThermalCoupling as ThermalCoupling
from staffa.evolution.thermal_state import ThermalFields as ThermalFields
from staffa.evolution.thermal_state import ThermalState as ThermalState
from staffa.heat.thermal_body import Conduction
from staffa.heat.transient import HeatEquation
from staffa.loads.closed_form import Load, pressure_of
from staffa.model.domain import Domain
from staffa.model.fields import Spaces, vertices
from staffa.records.step import Heat
from staffa.reservoir.reservoir_load import ReservoirLoad


class ClosedForm:
    """A temperature that is known beforehand, and depends on place and time alone."""

    agreement = None

    def __init__(self, load: Load, domain: Domain, spaces: Spaces) -> None:
        self._load, self._comm, self._x = load, domain.comm, vertices(spaces.alpha).T

    def start(self) -> ThermalState:
        """See `ThermalCoupling`. A drop at t = 0 itself belongs to the first step."""
        return ThermalState(T=np.zeros(self._x.shape[1]), p=self._pressure(0.0))

    def advance(
        self, before: ThermalState, cracks: Cracks, start: float, end: float
    ) -> tuple[ThermalState, None]:
        """See `ThermalCoupling`."""
        return ThermalState(T=self._load.temperature(self._x, end), p=self._pressure(end)), None

    def _pressure(self, t: float) -> np.ndarray | None:
        pressure = pressure_of(self._load)
        return None if pressure is None else pressure(self._x, t)

    def span(self, thermal: ThermalState) -> float:
        """See `ThermalCoupling`."""
        return max_over_ranks(self._comm, np.abs(thermal.T))

    def unaccounted(self, before: ThermalState, after: ThermalState, heat: Heat) -> float:
        """See `ThermalCoupling`: it keeps no account."""
        return 0.0

    def destroy(self) -> None:
        """See `ThermalCoupling`: it owns nothing."""


class Conducted:
    """The temperature of the heat equation; cracks may insulate, or carry a fluid."""

    def __init__(self, conduction: Conduction, domain: Domain, spaces: Spaces) -> None:
        self._equation = HeatEquation(domain, spaces, conduction)
        rule = Agreement(tolerance=conduction.agreement, passes=conduction.passes)
        self.agreement = rule if self._equation.feels_cracks else None

    def start(self) -> ThermalState:
        """See `ThermalCoupling`."""
        return ThermalState(T=self._equation.start())

    def advance(
        self, before: ThermalState, cracks: Cracks, start: float, end: float
    ) -> tuple[ThermalState, Heat]:
        """See `ThermalCoupling`."""
        T, heat = self._equation.advance(before.T, cracks.alpha, start, end)
        return ThermalState(T=T), heat

    def span(self, thermal: ThermalState) -> float:
        """See `ThermalCoupling`."""
        return self._equation.span(thermal.T)

    def unaccounted(self, before: ThermalState, after: ThermalState, heat: Heat) -> float:
        """See `ThermalCoupling`."""
        return self._equation.unaccounted(before.T, after.T, heat)

    def destroy(self) -> None:
        """See `ThermalCoupling`."""
        self._equation.destroy()


@singledispatch
def coupling_of(load: Any, domain: Domain, spaces: Spaces) -> ThermalCoupling:
    """Build the coupling that a problem's load stands for, by the load's class. Collective.

    What is not registered is a load in closed form.

    Parameters
    ----------
    load : source of the temperature, as in `Problem.load`.
    domain, spaces : the body, and the spaces of its fields.
    """
    return ClosedForm(load, domain, spaces)


@coupling_of.register
def _(load: Conduction, domain: Domain, spaces: Spaces) -> ThermalCoupling:
    return Conducted(load, domain, spaces)


@coupling_of.register
def _(load: ReservoirLoad, domain: Domain, spaces: Spaces) -> ThermalCoupling:
    return Circulated(load, domain, spaces)


def in_closed_form(load: object) -> bool:
    """Return True if a load is known by its values at points and times alone."""
    return coupling_of.dispatch(type(load)) is coupling_of.dispatch(object)
