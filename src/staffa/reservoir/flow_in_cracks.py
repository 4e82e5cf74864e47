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
    k_first : that permeability (m^2), shape (n_cells, 3).
    walls : displacement of the walls (m) before the first step, shape (n_rows,).
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
        self._last: tuple[Flow, float, tuple[Flow, Circulation]] | None = None

    def start(self) -> CrackedFlow:
        """Return the state before the first step, of a body without cracks; see `at_rest`."""
        flow, grid = self.simulator.start(), self.permeability.model.grid
        return CrackedFlow(
            flow=flow,
            shadow=flow if self.shadow else None,
            k_first=np.zeros((grid.size, 3)),
            walls=np.zeros(self.permeability.n_rows),
        )

    def at_rest(self, state: CrackedFlow, cracks: CrackedCells) -> CrackedFlow:
        """Return the state that openings count from.

        Parameters
        ----------
        state : the state before the first step.
        cracks : the cracks of the body at rest under its first loads.
        """
        return replace(state, k_first=self.permeability(cracks, cracks.walls).k, walls=cracks.walls)

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
        return self.permeability(cracks, state.walls)

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
        open_now = self.permeability(cracks, state.walls)
        flow, circulation, inner = self.simulator.advance(state.flow, open_now.k, duration)
        shadow, without = None, None
        if state.shadow is not None:
            shadow, without = self._in_the_shadow(state.shadow, state.k_first, duration)
        after = replace(state, flow=flow, shadow=shadow)
        return after, replace(circulation, cracks=open_now.account), without, inner

    def _in_the_shadow(
        self, flow: Flow, k: np.ndarray, duration: float
    ) -> tuple[Flow, Circulation]:
        """Advance the shadow; once, where the same step is asked for again with other cracks."""
        if self._last is not None:
            asked, took, answer = self._last
            if took == duration and _same(asked, flow):
                return answer
        after, circulation, _ = self.simulator.advance(flow, k, duration)
        self._last = (flow, duration, (after, circulation))
        return after, circulation


def _same(one: Flow, other: Flow) -> bool:
    pairs = ((one.hidden, other.hidden), (one.T, other.T), (one.p, other.p))
    return all(np.array_equal(mine, his) for mine, his in pairs)
