"""The load of a body that follows a reservoir simulator."""

from collections.abc import Callable
from dataclasses import dataclass

from staffa.reservoir.simulator import ReservoirModel, Simulator


@dataclass(frozen=True, kw_only=True)
class ReservoirLoad:
    """Temperature and pressure of a reservoir, as a problem's load.

    Attributes
    ----------
    model : rock, water and wells.
    open : starts the simulator; it is called on rank 0 alone.
    agreement : largest difference of two temperatures in turn, over the span of a step, with
        `feedback`.
    passes : the most passes within one step.
    feedback : True if the cracks change the permeability.
    """

    model: ReservoirModel
    open: Callable[[], Simulator]
    agreement: float
    passes: int = 20
    feedback: bool = False
