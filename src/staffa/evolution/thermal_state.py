"""Thermal state of a body, and the coupling of heat and mechanics as the time loop sees it."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from staffa.model.fields import State
from staffa.records.step import Heat


@dataclass(frozen=True, kw_only=True)
class ThermalState:
    """Temperature of the body at one time, and all else that its source goes on from.

    Attributes
    ----------
    T : temperature change (K) at the vertices, ghosts included, shape (n_local,).
    p : pressure (Pa) of the fluid in pores and cracks there, shape (n_local,); None without one.
    memory : numbers of the source itself, shape (n,), on rank 0 alone; empty elsewhere, and
        everywhere where T is all that it goes on from. It is put back, kept in checkpoints and
        handed on with T.
    """

    T: np.ndarray
    p: np.ndarray | None = None
    memory: np.ndarray = field(default_factory=lambda: np.zeros(0))

    def fields(self) -> dict[str, np.ndarray]:
        """Return the fields at the vertices by their names, shape (n_local,) each."""
        return {"T": self.T} if self.p is None else {"T": self.T, "p": self.p}

    def moved(self, transfer: Callable[[np.ndarray], np.ndarray]) -> "ThermalState":
        """Return the same on another mesh, by a transfer of values at vertices. Collective."""
        p = None if self.p is None else transfer(self.p)
        return replace(self, T=transfer(self.T), p=p)


@dataclass(frozen=True, kw_only=True)
class Cracks:
    """Damage and displacement that a source of temperatures may look at, and must not change.

    Attributes
    ----------
    alpha : damage at the vertices, ghosts included, shape (n_local,).
    u : displacement (m) at the nodes, ghosts included, shape (n_nodes * dim,), as computed last.
    volumes : function that returns the volume of open cracks in each cell that this rank owns
        (m^3; m^2 in 2-D), shape (n,), of the fields as they are. Collective.
    """

    alpha: np.ndarray
    u: np.ndarray
    volumes: Callable[[], np.ndarray]


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


class ThermalFields:
    """The thermal state that the body has now, changed in place.

    Parameters
    ----------
    state : fields of the system, with the temperature and the pressure.
    thermal : the state to begin with.
    """

    def __init__(self, state: State, thermal: ThermalState) -> None:
        self._T, self._p = state.T, state.p
        self.put(thermal)

    def read(self) -> ThermalState:
        """Return a copy of the current state."""
        p = self._p.x.array.copy() if self._has_pressure else None
        return ThermalState(T=self._T.x.array.copy(), p=p, memory=self._memory)

    def put(self, thermal: ThermalState) -> None:
        """Make a state the current one."""
        self._T.x.array[:] = thermal.T
        self._has_pressure = thermal.p is not None
        if thermal.p is not None:
            self._p.x.array[:] = thermal.p
        self._memory = thermal.memory.copy()
