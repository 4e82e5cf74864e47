"""Flow whose permeability follows the cracks, and its shadow: the same flow without that."""

from dataclasses import dataclass, replace

import numpy as np

from staffa.records.circulation import Circulation
from staffa.reservoir.crack_permeability import CrackedCells, CrackedPermeability, CrackPermeability
from staffa.reservoir.simulator import Flow, Simulator


@dataclass(frozen=True, kw_only=True)
class CrackedFlow:
    """State of a reservoir with cracks at one time: all that it goes on from.

    Attributes
    ----------
    flow : the flow.
    shadow : the flow with the permeability before the first step; None if it is not computed.
    k_first : that permeability (m^2), shape (n_cells, 3); NaN until the first step.
    walls : displacement of the walls (m) before the first step, shape (n_rows,); NaN likewise.
    """

    flow: Flow
    shadow: Flow | None
    k_first: np.ndarray
    walls: np.ndarray

    def packed(self) -> np.ndarray:
        """Return all of it as one array, shape (n,)."""
        flows = [self.flow] if self.shadow is None else [self.flow, self.shadow]
        parts = [part for flow in flows for part in (flow.T, flow.p, flow.hidden)]
        return np.concatenate([self.k_first.ravel(), self.walls, *parts])


class FlowInCracks:
    """A pure function of a `CrackedFlow`, as a simulator is of a `Flow`.

    Parameters
    ----------
    simulator : the simulator.
    permeability : permeability from cracks.
    shadow : compute the flow without what happens to cracks, too.
    """

    def __init__(
        self, simulator: Simulator, permeability: CrackPermeability, *, shadow: bool
    ) -> None:
        self.simulator, self.permeability, self.shadow = simulator, permeability, shadow
        # Cracks of the first question, which are those at rest, also when it is asked again.
        self._at_rest: CrackedCells | None = None
        self._last: tuple[Flow, float, tuple[Flow, Circulation]] | None = None

    def start(self) -> CrackedFlow:
        """Return the state before the first step."""
        flow, grid = self.simulator.start(), self.permeability.model.grid
        return CrackedFlow(
            flow=flow,
            shadow=flow if self.shadow else None,
            k_first=np.full((grid.size, 3), np.nan),
            walls=np.full(self.permeability.n_rows, np.nan),
        )

    def unpacked(self, values: np.ndarray) -> CrackedFlow:
        """Return the state that was packed.

        Parameters
        ----------
        values : the array.
        """
        n, rows = self.permeability.model.grid.size, self.permeability.n_rows
        k_first, walls, rest = np.split(values, [3 * n, 3 * n + rows])
        flows = [
            Flow(T=T, p=p, hidden=hidden)
            for T, p, hidden in (
                np.split(part, [n, 2 * n]) for part in np.split(rest, 2 if self.shadow else 1)
            )
        ]
        return CrackedFlow(
            flow=flows[0],
            shadow=flows[1] if self.shadow else None,
            k_first=k_first.reshape(n, 3),
            walls=walls,
        )

    def of_cracks(self, state: CrackedFlow, cracks: CrackedCells) -> CrackedPermeability:
        """Return the permeability with cracks.

        Parameters
        ----------
        state : the flow, which knows where the walls were before the first step.
        cracks : the cracks.
        """
        return self.permeability(cracks, self._begun(state, cracks).walls)

    def advance(
        self, state: CrackedFlow, cracks: CrackedCells, duration: float
    ) -> tuple[CrackedFlow, Circulation, Circulation | None, int]:
        """Return the state after a time, both accounts of it, and the number of inner steps.

        Parameters
        ----------
        state : state to begin with.
        cracks : cracks through which water flows.
        duration : time to advance (s).

        Raises
        ------
        SolveError
            The simulator did not converge.
        StoppedError
            It does not answer any more.
        """
        state = self._begun(state, cracks)
        open_now = self.permeability(cracks, state.walls)
        flow, circulation, inner = self.simulator.advance(state.flow, open_now.k, duration)
        shadow, without = None, None
        if state.shadow is not None:
            shadow, without = self._in_the_shadow(state.shadow, state.k_first, duration)
        after = replace(state, flow=flow, shadow=shadow)
        return after, replace(circulation, cracks=open_now.account), without, inner

    def _begun(self, state: CrackedFlow, cracks: CrackedCells) -> CrackedFlow:
        """Return the state with what was before the first step."""
        if not np.isnan(state.k_first).any():
            return state
        if self._at_rest is None:
            self._at_rest = cracks
        walls = self._at_rest.walls
        return replace(state, k_first=self.permeability(self._at_rest, walls).k, walls=walls)

    def _in_the_shadow(
        self, flow: Flow, k: np.ndarray, duration: float
    ) -> tuple[Flow, Circulation]:
        """Advance the shadow; once, where the same step is asked for again with other cracks."""
        if self._last is not None:
            asked, took, answer = self._last
            if took == duration and np.array_equal(asked.hidden, flow.hidden):
                return answer
        after, circulation, _ = self.simulator.advance(flow, k, duration)
        self._last = (flow, duration, (after, circulation))
        return after, circulation
