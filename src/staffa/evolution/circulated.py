"""Temperature and pressure of a reservoir simulator, brought from its cells to the rock."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from time import perf_counter

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np

from staffa.backend.parallel import max_over_ranks, on_root
from staffa.evolution.cracks_in_cells import CracksInCells
from staffa.evolution.thermal_state import Agreement, Cracks, ThermalState
from staffa.model.domain import Domain
from staffa.model.fields import Spaces, vertices
from staffa.records.step import Circulation, Heat
from staffa.reservoir.crack_permeability import CrackPermeability
from staffa.reservoir.flow_in_cracks import FlowInCracks
from staffa.reservoir.permeability import largest_along
from staffa.reservoir.reservoir_load import ReservoirLoad
from staffa.reservoir.simulator import Flow, Simulator

PASSES = 20  # of temperature and cracks within a step, before it is cut in two


@dataclass(frozen=True, kw_only=True)
class _Answer:
    """State after a question to the simulator, its accounts, and the number of inner steps."""

    T: np.ndarray
    p: np.ndarray
    memory: np.ndarray
    circulation: Circulation
    shadow: Circulation | None = None
    inner: int = 0


class Circulated:
    """Temperature and pressure of circulating water: a `ThermalCoupling`.

    Rank 0 owns the simulator, and the state that it goes on from. That state is the memory of a
    `ThermalState`: temperatures and pressures of the cells and the simulator's hidden numbers, and
    where water flows in cracks a packed `CrackedFlow`.

    Attributes
    ----------
    simulator : name and version of the simulator.
    model : the reservoir.
    feedback : rule by which cracks change the flow; None where they do not.
    agreement : rule by which temperature and cracks agree.
    engine : the simulator itself, on rank 0; None elsewhere.
    """

    def __init__(self, load: ReservoirLoad, domain: Domain, spaces: Spaces) -> None:
        """Start the simulator. Collective.

        Parameters
        ----------
        load : the reservoir and its simulator.
        domain, spaces : the body, and the spaces of its fields.
        """
        self.model, grid = load.model, load.model.grid
        self.feedback, self.agreement = load.feedback, _agreement(load)
        self._comm, self._balance = domain.comm, load.balance
        self._weights = grid.weights(vertices(spaces.alpha))
        self._T_at_rest = self._weights @ load.model.T
        # In 2-D the heat of the body counts for a unit of thickness.
        self._thickness = float(np.ptp(grid.edges[2])) if grid.dim == 2 else 1.0
        self._cells: CracksInCells | None = None
        if load.feedback is not None:
            self._cells = CracksInCells(domain, spaces, grid, load.model.fractures)
        self.engine: Simulator | None = None
        self._cracked: FlowInCracks | None = None

        def begin() -> str:
            rule = load.feedback.rule if load.feedback else None
            permeability = CrackPermeability(load.model, rule) if rule else None
            self.engine = load.open()
            self.engine.start()  # it tells its version
            if load.feedback is not None and permeability is not None:
                shadow = load.feedback.shadow
                self._cracked = FlowInCracks(self.engine, permeability, shadow=shadow)
            return self.engine.name

        self.simulator = on_root(self._comm, begin)

    def start(self) -> ThermalState:
        """See `ThermalCoupling`."""

        def first() -> _Answer:
            assert self.engine is not None
            flow = self.engine.start()
            memory = self._cracked.start().packed() if self._cracked else _packed(flow)
            return _Answer(T=flow.T, p=flow.p, memory=memory, circulation=Circulation(duration=0.0))

        thermal, _ = self._told(first)
        return thermal

    def at_rest(self, thermal: ThermalState, cracks: Cracks) -> ThermalState:
        """Return the first state with the cracks that openings count from. Collective.

        Parameters
        ----------
        thermal : the state before the first step.
        cracks : the cracks of the body at rest under its first loads.
        """
        if self._cells is None:
            return thermal
        in_cells, memory = self._cells(cracks), [thermal.memory]

        def count_from() -> None:
            assert self._cracked is not None
            state = self._cracked.unpacked(thermal.memory)
            memory.append(self._cracked.at_rest(state, in_cells).packed())

        on_root(self._comm, count_from)
        return replace(thermal, memory=memory[-1])

    def advance(
        self, before: ThermalState, cracks: Cracks, start: float, end: float
    ) -> tuple[ThermalState, Heat]:
        """See `ThermalCoupling`.

        Raises
        ------
        SolveError
            The simulator did not converge.
        StoppedError
            The simulator ended, and ended again when it was started again.
        """
        began = perf_counter()
        in_cells = self._cells(cracks) if self._cells else None

        def ask() -> _Answer:
            assert self.engine is not None
            if self._cracked is None or in_cells is None:
                flow, account, inner = self.engine.advance(self.flow(before), None, end - start)
                return _Answer(
                    T=flow.T, p=flow.p, memory=_packed(flow), circulation=account, inner=inner
                )
            state = self._cracked.unpacked(before.memory)
            after, account, shadow, inner = self._cracked.advance(state, in_cells, end - start)
            return _Answer(
                T=after.flow.T, p=after.flow.p, memory=after.packed(), circulation=account,
                shadow=shadow, inner=inner,
            )  # fmt: skip

        thermal, told = self._told(ask)
        wells = {name: well.heat / self._thickness for name, well in told.circulation.wells.items()}
        heat = Heat(
            stored=told.circulation.heat_stored / self._thickness,
            entered=wells,
            imbalance=told.circulation.imbalance,
            allowed=self._balance,
            substeps=told.inner,
            circulation=told.circulation,
            shadow=told.shadow,
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

    def flow(self, thermal: ThermalState) -> Flow:
        """Return the reservoir's state in a thermal state; on rank 0 alone."""
        if self._cracked is not None:
            return self._cracked.unpacked(thermal.memory).flow
        n = self.model.grid.size
        T, p, hidden = np.split(thermal.memory, [n, 2 * n])
        return Flow(T=T, p=p, hidden=hidden)

    def cell_fields(self, thermal: ThermalState, cracks: Cracks) -> dict[str, np.ndarray]:
        """Return the fields of the reservoir's cells by their names, shape (n_cells,) each; on
        rank 0, empty elsewhere. Collective.

        Parameters
        ----------
        thermal : the thermal state.
        cracks : the cracks at the same time.
        """
        in_cells = self._cells(cracks) if self._cells else None
        found: dict[str, np.ndarray] = {}

        def read() -> None:
            flow = self.flow(thermal)
            found.update({"T": flow.T, "p": flow.p, "k": largest_along(self.model.permeability)})
            if self._cracked is not None and in_cells is not None:
                state = self._cracked.unpacked(thermal.memory)
                cracked = self._cracked.of_cracks(state, in_cells)
                found.update({"k": largest_along(cracked.k), "w": cracked.w, "A": cracked.A})

        on_root(self._comm, read)
        return found

    def _told(self, ask: Callable[[], _Answer]) -> tuple[ThermalState, _Answer]:
        """Ask the simulator on rank 0, and tell all ranks the answer, but for the memory."""
        memory = [np.zeros(0)]

        def answer() -> _Answer:
            found = ask()
            memory.append(found.memory)
            return replace(found, memory=np.zeros(0))

        told = on_root(self._comm, answer)
        thermal = ThermalState(
            T=self._temperature(told.T), p=np.asarray(self._weights @ told.p), memory=memory[-1]
        )
        return thermal, told

    def _temperature(self, cells: np.ndarray) -> np.ndarray:
        """Return the temperature change (K) at the vertices from temperatures (K) of the cells."""
        return np.asarray(self._weights @ cells - self._T_at_rest)


def _agreement(load: ReservoirLoad) -> Agreement | None:
    if load.feedback is None or load.feedback.agreement is None:
        return None
    return Agreement(tolerance=load.feedback.agreement, passes=PASSES, key="reservoir.agreement")


def _packed(flow: Flow) -> np.ndarray:
    return np.concatenate([flow.T, flow.p, flow.hidden])
