"""Temperature and pressure of a reservoir simulator, brought from its cells to the rock."""

from collections.abc import Callable
from time import perf_counter

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np

from staffa.backend.parallel import max_over_ranks, on_root
from staffa.evolution.thermal_state import Cracks, ThermalState
from staffa.model.domain import Domain
from staffa.model.fields import Spaces, vertices
from staffa.records.step import Circulation, Heat
from staffa.reservoir.reservoir_load import ReservoirLoad
from staffa.reservoir.simulator import Flow, Simulator


class Circulated:
    """Temperature and pressure of circulating water: a `ThermalCoupling`, one way.

    Rank 0 owns the simulator, and the state that it goes on from. That state is the memory of a
    `ThermalState`: temperatures and pressures of the cells, then the simulator's hidden numbers.

    Attributes
    ----------
    simulator : name and version of the simulator.
    model : the reservoir.
    engine : the simulator itself, on rank 0; None elsewhere.
    """

    agreement = None

    def __init__(self, load: ReservoirLoad, domain: Domain, spaces: Spaces) -> None:
        """Start the simulator. Collective.

        Parameters
        ----------
        load : the reservoir and its simulator.
        domain, spaces : the body, and the spaces of its fields.
        """
        self.model, grid = load.model, load.model.grid
        self._comm, self._balance = domain.comm, load.balance
        self._weights = grid.weights(vertices(spaces.alpha))
        self._T_at_rest = self._weights @ load.model.T
        # In 2-D the heat of the body counts for a unit of thickness.
        self._thickness = float(np.ptp(grid.edges[2])) if grid.dim == 2 else 1.0
        self.engine: Simulator | None = None

        def begin() -> str:
            self.engine = load.open()
            self.engine.start()  # it tells its version
            return self.engine.name

        self.simulator = on_root(self._comm, begin)

    def start(self) -> ThermalState:
        """See `ThermalCoupling`."""

        def first(simulator: Simulator) -> tuple[Flow, Circulation, int]:
            return simulator.start(), Circulation(duration=0.0), 0

        thermal, _, _ = self._ask(first)
        return thermal

    def advance(
        self, before: ThermalState, cracks: Cracks, start: float, end: float
    ) -> tuple[ThermalState, Heat]:
        """See `ThermalCoupling`. Cracks do not change the flow.

        Raises
        ------
        SolveError
            The simulator did not converge.
        StoppedError
            The simulator ended, and ended again when it was started again.
        """
        began = perf_counter()
        thermal, circulation, inner = self._ask(
            lambda simulator: simulator.advance(self.flow(before), None, end - start)
        )
        wells = {name: well.heat / self._thickness for name, well in circulation.wells.items()}
        heat = Heat(
            stored=circulation.heat_stored / self._thickness,
            entered=wells,
            imbalance=circulation.imbalance,
            allowed=self._balance,
            substeps=inner,
            circulation=circulation,
            seconds=perf_counter() - began,
        )
        return thermal, heat

    def span(self, thermal: ThermalState) -> float:
        """See `ThermalCoupling`."""
        return max_over_ranks(self._comm, np.abs(thermal.T))

    def unaccounted(self, before: ThermalState, after: ThermalState, heat: Heat) -> float:
        """See `ThermalCoupling`: how far the rock's temperature is not the simulator's.

        The heat of the simulator is in its account.
        """
        T = on_root(self._comm, lambda: self.flow(after).T)
        apart = max_over_ranks(self._comm, np.abs(self._temperature(T) - after.T))
        return apart / (self.span(after) or 1.0)

    def destroy(self) -> None:
        """See `ThermalCoupling`: end the simulator."""
        if self.engine is not None:
            self.engine.close()

    def _ask(
        self, question: Callable[[Simulator], tuple[Flow, Circulation, int]]
    ) -> tuple[ThermalState, Circulation, int]:
        """Ask the simulator on rank 0, and tell all ranks the answer."""
        memory = [np.zeros(0)]

        def ask() -> tuple[np.ndarray, np.ndarray, Circulation, int]:
            assert self.engine is not None
            flow, circulation, inner = question(self.engine)
            memory.append(np.concatenate([flow.T, flow.p, flow.hidden]))
            return flow.T, flow.p, circulation, inner

        T, p, circulation, inner = on_root(self._comm, ask)
        thermal = ThermalState(
            T=self._temperature(T), p=np.asarray(self._weights @ p), memory=memory[-1]
        )
        return thermal, circulation, inner

    def _temperature(self, cells: np.ndarray) -> np.ndarray:
        """Return the temperature change (K) at the vertices from temperatures (K) of the cells."""
        return np.asarray(self._weights @ cells - self._T_at_rest)

    def flow(self, thermal: ThermalState) -> Flow:
        """Return the reservoir's state in a thermal state; on rank 0 alone."""
        n = self.model.grid.size
        T, p, hidden = np.split(thermal.memory, [n, 2 * n])
        return Flow(T=T, p=p, hidden=hidden)
