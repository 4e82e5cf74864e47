"""Load of a rock from a reservoir simulator."""

from collections.abc import Callable
from dataclasses import dataclass
from hashlib import sha256

from staffa.records.reservoir_facts import CrackRule
from staffa.reservoir.simulator import ReservoirModel, Simulator


@dataclass(frozen=True, kw_only=True)
class Feedback:
    """Rock to reservoir: water flows in the cracks too.

    Attributes
    ----------
    rule : bounds of their openings, and the radius over which they are spread.
    agreement : largest difference between two temperatures in turn at the end of a step, over the
        span of the step; None: the flow of a step has the cracks that it began with.
    shadow : compute the flow without what happens to cracks, too.
    """

    rule: CrackRule
    agreement: float | None = 1e-3
    shadow: bool = True


@dataclass(frozen=True, kw_only=True)
class ReservoirLoad:
    """Temperature and pressure that a reservoir simulator computes.

    Attributes
    ----------
    model : the reservoir.
    open : function that starts the simulator; called on one rank alone.
    balance : largest difference of the heat that wells brought and that was stored, over the
        larger one, that is no fault of the simulator.
    feedback : rule by which cracks change the flow; None where they do not.
    """

    model: ReservoirModel
    open: Callable[[], Simulator]
    balance: float = 1e-7
    feedback: Feedback | None = None

    def identity(self) -> str:
        """Return a text by which a run that goes on knows the reservoir again."""
        model, told = self.model, sha256()
        for edges in model.grid.edges:
            told.update(edges.tobytes())
        for name in ("permeability", "porosity", "conductivity", "rho_c", "T", "p"):
            told.update(getattr(model, name).tobytes())
        rest = (
            model.water,
            tuple(model.wells),
            model.gravity,
            tuple(model.fractures),
            model.tolerance,
            *([self.feedback] if self.feedback else []),
        )
        told.update(repr(rest).encode())
        return told.hexdigest()
