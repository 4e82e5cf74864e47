"""Load of a rock from a reservoir simulator."""

from collections.abc import Callable
from dataclasses import dataclass

from staffa.reservoir.simulator import ReservoirModel, Simulator


@dataclass(frozen=True, kw_only=True)
class ReservoirLoad:
    """Temperature and pressure that a reservoir simulator computes.

    Attributes
    ----------
    model : the reservoir.
    open : function that starts the simulator; called on one rank alone.
    balance : largest difference of the heat that wells brought and that was stored, over the
        larger one, that is no fault of the simulator.
    """

    model: ReservoirModel
    open: Callable[[], Simulator]
    balance: float = 1e-7
