"""The coupling of heat and mechanics: the temperature of a step, and how well it fits the cracks.

The time loop asks for what stands in `ThermalCoupling`, and for nothing else. A further source of
temperatures is a class with these members and a line in `coupling_of`.
"""

from dataclasses import dataclass, field
from functools import singledispatch
from typing import Any, Protocol

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
from dolfinx import fem

from staffa.backend.parallel import max_over_ranks
from staffa.heat.thermal_body import Conduction
from staffa.heat.transient import HeatEquation
from staffa.loads.closed_form import Load
from staffa.model.domain import Domain
from staffa.model.fields import Spaces, vertices
from staffa.records.step import Heat


@dataclass(frozen=True, kw_only=True)
class ThermalState:
    """Temperature of the body at one time, and all else that its source goes on from.

    Attributes
    ----------
    T : temperature change (K) at the vertices, ghosts included, shape (n_local,).
    memory : numbers of the source itself, shape (n,), on rank 0 alone; empty elsewhere, and
        everywhere where T is all that it goes on from. It is put back, kept in checkpoints and
        handed on with T.
    """

    T: np.ndarray
    memory: np.ndarray = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True, kw_only=True)
class Cracks:
    """Damage and displacement that a source of temperatures may look at, and must not change.

    Attributes
    ----------
    alpha : damage at the vertices, ghosts included, shape (n_local,).
    u : displacement (m) at the nodes, ghosts included, shape (n_nodes * dim,), as computed last.
    """

    alpha: np.ndarray
    u: np.ndarray


@dataclass(frozen=True, kw_only=True)
class Agreement:
    """When temperature and cracks, each a cause of the other, agree at the end of a step.

    Attributes
    ----------
    tolerance : largest difference between two temperatures in turn, over the span of the step.
    passes : the most passes within one step.
    key : key of the case file that sets the tolerance, named where they do not agree.
    """

    tolerance: float
    passes: int
    key: str = "heat.agreement"


class ThermalCoupling(Protocol):
    """Source of the temperature that mechanics sees. All of it is collective.

    The loop asks for any two times in order, and may ask again: with other cracks, for half a step,
    from an earlier state. All that an answer depends on is therefore in the arguments.
    """

    @property
    def agreement(self) -> Agreement | None:
        """The rule of agreement; None where the temperature does not depend on the cracks."""
        ...

    def start(self) -> ThermalState:
        """Return the state at t = 0."""
        ...

    def advance(
        self, before: ThermalState, cracks: Cracks, start: float, end: float
    ) -> tuple[ThermalState, Heat | None]:
        """Return the state at a later time, and the account of heat where there is one.

        Parameters
        ----------
        before : the state at the start.
        cracks : the cracks, frozen.
        start, end : the two times (s).

        Raises
        ------
        LoadError
            No temperature is known at the end. It is not tried again.
        SolveError
            It was not found. A shorter step is tried.
        """
        ...

    def span(self, thermal: ThermalState) -> float:
        """Return the largest change (K) since t = 0, which a difference is held against."""
        ...

    def unaccounted(self, before: ThermalState, after: ThermalState, heat: Heat) -> float:
        """Return the heat between two states that an account lacks, over the heat that moved."""
        ...

    def destroy(self) -> None:
        """Free what it owns."""
        ...


class ClosedForm:
    """A temperature that is known beforehand, and depends on place and time alone."""

    agreement = None

    def __init__(self, load: Load, domain: Domain, spaces: Spaces) -> None:
        self._load, self._comm, self._x = load, domain.comm, vertices(spaces.alpha).T

    def start(self) -> ThermalState:
        """See `ThermalCoupling`. A drop at t = 0 itself belongs to the first step."""
        return ThermalState(T=np.zeros(self._x.shape[1]))

    def advance(
        self, before: ThermalState, cracks: Cracks, start: float, end: float
    ) -> tuple[ThermalState, None]:
        """See `ThermalCoupling`."""
        return ThermalState(T=self._load.temperature(self._x, end)), None

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


def in_closed_form(load: object) -> bool:
    """Return True if a load is known by its values at points and times alone."""
    return coupling_of.dispatch(type(load)) is coupling_of.dispatch(object)


class ThermalFields:
    """The thermal state that the body has now, changed in place.

    Parameters
    ----------
    T : temperature change (K) of the system's state, at the vertices.
    thermal : the state to begin with.
    """

    def __init__(self, T: fem.Function, thermal: ThermalState) -> None:
        self._T = T
        self.put(thermal)

    def read(self) -> ThermalState:
        """Return a copy of the current state."""
        return ThermalState(T=self._T.x.array.copy(), memory=self._memory)

    def put(self, thermal: ThermalState) -> None:
        """Make a state the current one."""
        self._T.x.array[:] = thermal.T
        self._memory = thermal.memory.copy()
