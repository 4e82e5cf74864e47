"""Temperature from one time to another: pure, so that a step can be repeated or returned to.

TR-BDF2 (Bank et al. 1985) as a diagonally implicit Runge-Kutta method of three stages, the first
of them explicit (Hosea and Shampine, Appl. Numer. Math. 20, 21, 1996): second order, L-stable, one
matrix for both implicit stages, and an embedded method of third order that estimates the error. The
last stage is the new temperature, so the heat that enters is known to the last digit: stage by
stage, with the weights of the method. PETSc's TS has such methods, but it keeps a state, and gives
access neither to the stages nor to integrals over a step.
"""

from collections import defaultdict
from dataclasses import replace
from math import ceil
from time import perf_counter

from staffa.backend.stack import PETSc

import numpy as np
from dolfinx import fem

from staffa.backend.parallel import any_over_ranks, max_over_ranks, sum_over_ranks
from staffa.backend.petsc_options import HEAT, apply, petsc_errors
from staffa.backend.petsc_status import how_it_ended
from staffa.backend.vectors import readable, writable
from staffa.errors import SolveError
from staffa.heat.nonlinear import NonlinearSteps
from staffa.heat.operators import HeatExchange, HeatOperators
from staffa.heat.thermal_body import Conduction
from staffa.heat.tr_bdf2 import EMBEDDED, GAMMA, WEIGHTS, D, Tried, W, by_cause
from staffa.model.domain import Domain
from staffa.model.fields import Spaces, owned
from staffa.records.step import Heat

# A substep is as long as its error allows, times the first number; its length changes by a factor
# between the other two.
SAFETY, LEAST, MOST = 0.9, 0.1, 4.0
# A change of a temperature by less than this part of it is round-off.
UNCHANGED = 1e-7
# At one temperature the flows between vertices cancel, except for round-off: over the tolerance of
# the audit, less than this fraction of the flow from each vertex alone.
CANCELED = 1e-9


class HeatEquation:
    """Heat equation of a body, built once. It owns its PETSc objects. Collective."""

    def __init__(self, domain: Domain, spaces: Spaces, conduction: Conduction) -> None:
        self.comm = domain.comm
        self.conduction = conduction
        self.operators = HeatOperators(domain, spaces, conduction)
        self.operators.feel(np.zeros_like(fem.Function(spaces.alpha).x.array))
        self._initial, self._stress_free = self.operators.initial, self.operators.stress_free
        self._T = fem.Function(spaces.alpha)
        self._free = np.ones(len(self._initial))
        self._free[self.operators.held] = 0.0
        self._matrix = self.operators.matrix.duplicate()
        self._matrix.setOption(PETSc.Mat.Option.SPD, True)
        first = self._matrix.getOwnershipRange()[0]
        self._rows = (self.operators.held + first).astype(PETSc.IntType)
        self._diagonal, self._rhs = (self._matrix.createVecRight() for _ in range(2))
        self._solution = self._rhs.duplicate()
        self._pivot = max_over_ranks(self.comm, self.operators.capacity)
        self._made_for: tuple[float, np.ndarray] | None = None
        self._ksp = PETSc.KSP().create(self.comm)
        self._ksp.setOptionsPrefix("heat_")
        apply("heat_", HEAT)
        self._ksp.setOperators(self._matrix)
        self._ksp.setFromOptions()
        self._nonlinear = None if conduction.linear else NonlinearSteps(self.operators)

    @property
    def feels_cracks(self) -> bool:
        """True if the damage changes the flow of heat."""
        return self.conduction.cracks is not None

    def start(self) -> np.ndarray:
        """Return the temperature change (K) from the stress-free state at t = 0, with ghosts."""
        return self._with_ghosts(self._initial - self._stress_free)

    def span(self, T: np.ndarray) -> float:
        """Return the largest change (K) of a temperature since t = 0; T as `start` returns it."""
        mine = T[: len(self._initial)] + self._stress_free - self._initial
        return max_over_ranks(self.comm, np.abs(mine))

    def advance(
        self, before: np.ndarray, alpha: np.ndarray, start: float, end: float
    ) -> tuple[np.ndarray, Heat]:
        """Return the temperature change (K) after a step with frozen cracks, and the heat balance.

        Parameters
        ----------
        before : temperature change at the start (K), at the vertices, ghosts included, shape
            (n_local,).
        alpha : damage at the vertices, ghosts included, shape (n_local,).
        start : time at the start (s).
        end : time at the end (s).

        Raises
        ------
        SolveError
            A linear solver failed, or the substeps became too short.
        """
        began_at = perf_counter()
        if self.operators.feel(alpha):
            self._made_for = None
        T = before[: len(self._initial)] + self._stress_free
        began, entered, substeps = T, defaultdict[str, float](float), 0
        largest, time = self._change(T), start
        for stop in (*(t for t in self.conduction.kinks if start < t < end), end):
            T, largest, steps = self._march(T, time, stop, largest, entered)
            time, substeps = stop, substeps + steps
        heat = self._account(began, T, entered, substeps, end - start)
        return self._with_ghosts(T - self._stress_free), replace(
            heat, seconds=perf_counter() - began_at
        )

    def _march(
        self, T: np.ndarray, time: float, end: float, largest: float, entered: dict[str, float]
    ) -> tuple[np.ndarray, float, int]:
        """Take substeps between two times without a breakpoint.

        `largest` is the largest change of temperature so far (K). Return the temperature, that
        change and the number of substeps; heat that entered is added to `entered`.
        """
        length, substeps = end - time, 0
        while time < end:
            tried = self._try(T, time, length, largest)
            if tried.error <= 1:
                T, substeps = tried.T, substeps + 1
                time = end if length == end - time else time + length
                largest = max(largest, self._change(T))
                for name, amount in tried.entered.items():
                    entered[name] += amount
            change = SAFETY * max(tried.error, 1e-9) ** (-1 / 3)
            length = _fitting(length * min(max(change, LEAST), MOST), end - time)
            if time < end and not time + length > time:
                raise SolveError(
                    "the heat equation takes ever shorter steps: something prescribed in it is not "
                    "smooth; smooth it, or take a larger heat.tolerance"
                )
        return T, largest, substeps

    def _change(self, T: np.ndarray) -> float:
        """Return the largest change (K) since t = 0, or its round-off if there is none."""
        changed = max_over_ranks(self.comm, np.abs(T - self._initial))
        return max(changed, UNCHANGED * max_over_ranks(self.comm, np.abs(T)))

    def _try(self, T: np.ndarray, time: float, length: float, largest: float = 0.0) -> Tried:
        """Try one substep of any length (s); `largest` is the change of temperature before (K)."""
        if self._nonlinear:
            tried = self._nonlinear.tried(T, time, length, max(largest, self._change(T)))
            return replace(tried, error=self._over_allowed(tried.error, tried.T, largest))
        at, held = self.operators, self.operators.held
        times = (time, time + GAMMA * length, time + length)
        prescribed = [at.held_values(t) for t in times]
        started = T.copy()
        started[held] = prescribed[0]  # a jump at the start
        gain, entering = self._rates(started, at.exchanges(times[0]))
        rate = gain / at.capacity
        rate[held] = (prescribed[1] - prescribed[0]) / (GAMMA * length)
        rates, sides = [rate], [self._by_cause(rate, gain, entering)]
        for i, weights in ((1, [D]), (2, [W, W])):
            base = started + length * np.einsum("i,ij", weights, rates)
            exchanges = at.exchanges(times[i])
            rate = self._stage(base, prescribed[i], exchanges, length)
            rates.append(rate)
            stage = base + D * length * rate
            sides.append(self._by_cause(rate, *self._rates(stage, exchanges)))
        new = started + length * np.einsum("i,ij", WEIGHTS, rates)
        new[held] = prescribed[2]
        entered = defaultdict[str, float](float)
        for weight, amounts in zip(WEIGHTS.tolist(), sides, strict=True):
            for name, amount in amounts.items():
                entered[name] += length * weight * amount
        for name, part in at.held_by_side():
            entries = held[part]
            entered[name] += float(at.capacity[entries] @ (started - T)[entries])
        return Tried(T=new, error=self._error(new, rates, length, largest), entered=entered)

    def _rates(
        self, T: np.ndarray, exchanges: list[HeatExchange]
    ) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Return the heat that vertices gain in total (W), and from each cause but neighbors."""
        entering = {e.name: e.entering(T) for e in exchanges}
        gained = np.sum(list(entering.values()), axis=0)
        return gained + self.operators.conducted(T), entering

    def _by_cause(
        self, rate: np.ndarray, gain: np.ndarray, entering: dict[str, np.ndarray]
    ) -> dict[str, float]:
        """Return the heat that enters the body (W), see `tr_bdf2.by_cause`."""
        held = self.operators.held
        return by_cause(self.operators, self.operators.capacity[held] * rate[held], gain, entering)

    def _stage(
        self, base: np.ndarray, held: np.ndarray, exchanges: list[HeatExchange], length: float
    ) -> np.ndarray:
        """Return the rate (K/s) k with C k = F(base + D length k), and as prescribed in `held`."""
        at, scale = self.operators, D * length
        self._make(scale, np.sum([e.coefficient for e in exchanges], axis=0))
        moved = base.copy()
        moved[at.held] = held
        gain, _ = self._rates(moved, exchanges)
        rate = self._solve(gain)
        rate[at.held] = (held - base[at.held]) / scale
        return rate

    def _make(self, scale: float, coefficient: np.ndarray) -> None:
        """Fill the matrix C + scale (coefficient + K), if it has changed."""
        if self._made_for is not None:
            before, films = self._made_for
            other = before != scale or not np.array_equal(films, coefficient)
            if not any_over_ranks(self.comm, other):
                return
        at = self.operators
        at.matrix.copy(self._matrix, PETSc.Mat.Structure.SAME_NONZERO_PATTERN)
        self._matrix.scale(scale)
        writable(self._diagonal)[:] = at.capacity + scale * coefficient
        self._matrix.setDiagonal(self._diagonal, PETSc.InsertMode.ADD_VALUES)
        self._matrix.zeroRowsColumns(self._rows, diag=self._pivot)
        self._made_for = (scale, coefficient)

    def _solve(self, gain: np.ndarray) -> np.ndarray:
        writable(self._rhs)[:] = gain * self._free
        size = self._rhs.norm()
        if size == 0:
            return np.zeros_like(gain)
        size = 2.0 ** np.round(np.log2(size))  # PETSc takes a residual of 1e-50 for none
        self._rhs.scale(1 / size)
        with petsc_errors("the heat equation was not solved", self._ksp.comm):
            self._ksp.solve(self._rhs, self._solution)
        end = how_it_ended(self._ksp)
        if not end.converged:
            raise SolveError(
                f"the heat equation was not solved by its linear solver: {end.sentence}; take "
                f"shorter time steps"
            )
        return np.asarray(size * readable(self._solution))

    def _error(
        self, new: np.ndarray, rates: list[np.ndarray], length: float, largest: float
    ) -> float:
        """Return the error of a substep over the allowed one.

        It is smoothed as Hosea and Shampine do: for a stiff equation the embedded method alone is
        useless.
        """
        difference = length * np.einsum("i,ij", WEIGHTS - EMBEDDED, rates)
        error = max_over_ranks(self.comm, np.abs(self._solve(self.operators.capacity * difference)))
        return self._over_allowed(error, new, largest)

    def _over_allowed(self, error: float, new: np.ndarray, largest: float) -> float:
        """Return an error (K) over the allowed one."""
        allowed = self.conduction.tolerance * max(largest, self._change(new))
        return error / allowed if allowed > 0 else (0.0 if np.isfinite(error) else np.inf)

    def _gained(self, before: np.ndarray, after: np.ndarray, *, sizes: bool = False) -> float:
        """Return the heat that the body gains on this rank (J); with `sizes` that of absolutes."""
        if self._nonlinear:
            gained = self._nonlinear.gained(before, after)
            return float((np.abs(gained) if sizes else gained).sum())
        change = after - before
        return float(self.operators.capacity @ (np.abs(change) if sizes else change))

    def _account(
        self,
        began: np.ndarray,
        T: np.ndarray,
        entered: dict[str, float],
        substeps: int,
        length: float,
    ) -> Heat:
        """Return the heat balance of a step, over all ranks.

        The difference of heat stored and heat entered is relative to the heat that crossed the
        boundary, or to the heat stored since t = 0 if that is more: near a steady state hardly any
        heat crosses.
        """
        self.operators.matrix.getDiagonal(self._diagonal)
        names, capacity = sorted(entered), self.operators.capacity
        mine = [
            self._gained(began, T),
            self._gained(self._initial, T, sizes=True),
            capacity @ np.abs(T),
            length * float(readable(self._diagonal) @ np.abs(T)),
            *(entered[name] for name in names),
        ]
        stored, since, content, flows, *parts = sum_over_ranks(self.comm, np.array(mine)).tolist()
        scale = max(abs(stored), sum(map(abs, parts)), since, UNCHANGED * content, CANCELED * flows)
        return Heat(
            stored=stored,
            entered=dict(zip(names, parts, strict=True)),
            imbalance=abs(stored - sum(parts)) / scale if scale else 0.0,
            substeps=substeps,
        )

    def unaccounted(self, before: np.ndarray, after: np.ndarray, heat: Heat) -> float:
        """Return the gained heat that a balance does not explain, over the heat that crossed.

        Parameters
        ----------
        before : temperature change at the start (K), ghosts included, shape (n_local,).
        after : temperature change at the end (K), ghosts included, shape (n_local,).
        heat : the heat balance, see `advance`.
        """
        n = len(self._initial)
        T, capacity = after[:n] + self._stress_free, self.operators.capacity
        gained = capacity @ (after - before)[:n]
        if self._nonlinear:
            gained = self._gained(before[:n] + self._stress_free, T)
        mine = [
            gained,
            self._gained(self._initial, T, sizes=True),
            capacity @ np.abs(T),
        ]
        gained, since, content = sum_over_ranks(self.comm, np.array(mine)).tolist()
        crossed = sum(map(abs, heat.entered.values()))
        scale = max(abs(heat.stored), crossed, since, UNCHANGED * content)
        return float(abs(gained - heat.stored) / scale if scale else abs(gained))

    def _with_ghosts(self, T: np.ndarray) -> np.ndarray:
        owned(self._T)[:] = T
        self._T.x.scatter_forward()
        return np.asarray(self._T.x.array.copy())

    def destroy(self) -> None:
        """Free the PETSc objects."""
        for thing in (self._ksp, self._matrix, self._diagonal, self._rhs, self._solution):
            thing.destroy()
        if self._nonlinear:
            self._nonlinear.destroy()
        self.operators.destroy()


def _fitting(length: float, left: float) -> float:
    """Return a length near the given one such that no short substep is left for the end."""
    return left / ceil(left / length * (1 - 1e-9)) if 0 < left < 1e3 * length else length
