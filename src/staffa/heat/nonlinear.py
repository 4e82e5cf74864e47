"""Heat equation of rock whose properties depend on temperature, step by step.

The unknown is the heat at each vertex, the integral of its capacity over temperature. So the heat
that enters is the heat that is stored, whatever the capacity. Each stage of TR-BDF2 is solved by
Newton's method with a line search. If a stage has no solution in reach, the step is made shorter.
"""

from collections import defaultdict
from collections.abc import Callable

from staffa.backend.stack import PETSc

import numpy as np
import ufl
from dolfinx import fem, la
from dolfinx.fem import petsc as fem_petsc

from staffa.backend import jit
from staffa.backend.parallel import max_over_ranks
from staffa.backend.petsc_options import HEAT_NEWTON, apply, petsc_errors
from staffa.backend.petsc_status import how_it_ended
from staffa.backend.vectors import readable, writable
from staffa.errors import LoadError, SolveError
from staffa.heat.operators import HeatExchange, HeatOperators
from staffa.heat.tr_bdf2 import EMBEDDED, GAMMA, WEIGHTS, D, Tried, W, by_cause
from staffa.model.fields import owned
from staffa.model.temperature_properties import algebra, by_law, middle_of_cell
from staffa.physics.temperature import Law

# A stage is solved if the missing heat would change no vertex by more than the first part of the
# largest change; if round-off ends the descent earlier, the second part is enough.
SOLVED, ENOUGH = 1e-12, 1e-10
ROUND_OFF = 1e-14  # part of a temperature
MOST = 30
# Most halvings of a Newton step in a line search.
HALVINGS = 8
# Degree of quadrature of k(T) grad T: exact for a conductivity linear in T.
DEGREE = 2


class NonlinearSteps:
    """Steps of the method. It owns its PETSc objects. All methods are collective."""

    def __init__(self, at: HeatOperators) -> None:
        self.at, self.comm = at, at.comm
        mesh = at.space.mesh
        self._T, self._above = fem.Function(at.space), fem.Function(at.space)
        self._level = max_over_ranks(self.comm, at.initial)
        phi, change = ufl.TestFunction(at.space), ufl.TrialFunction(at.space)
        middle, forms = middle_of_cell(mesh), algebra(mesh)

        def factor(law: Law | None) -> ufl.core.expr.Expr:
            return ufl.as_ufl(1.0 if law is None else law.at(self._T, middle, forms))

        k = by_law(mesh, [(rock.k_law, cells) for rock, cells in at.rocks], factor)
        # At a uniform temperature the flow is exactly zero.
        flow = ufl.inner(k * at.flow(ufl.grad(self._above)), ufl.grad(phi))
        form = flow * at.dx(degree=max(at.degree, DEGREE))
        slope = ufl.derivative(form, self._T, change) + ufl.derivative(form, self._above, change)
        self._conduct, self._slope = (jit.form(f, self.comm) for f in (form, slope))
        self._sums = fem.Function(at.space)
        self._held_heat = at.capacities()
        self._matrix = fem_petsc.create_matrix(self._slope)
        first = self._matrix.getOwnershipRange()[0]
        self._rows = (at.held + first).astype(PETSc.IntType)
        self._free = np.ones(len(at.capacity))
        self._free[at.held] = 0.0
        self._diagonal, self._rhs = (self._matrix.createVecRight() for _ in range(2))
        self._solution = self._rhs.duplicate()
        self._ksp = PETSc.KSP().create(self.comm)
        self._ksp.setOptionsPrefix("heat_newton_")
        apply("heat_newton_", HEAT_NEWTON)
        self._ksp.setOperators(self._matrix)
        self._ksp.setFromOptions()

    def gained(self, before: np.ndarray, after: np.ndarray) -> np.ndarray:
        """Return the heat that vertices gain between two temperatures (K) (J), owned entries."""
        x, total = self.at.x, np.zeros(len(after))
        for law, capacity in self._held_heat:
            total += capacity * (after - before if law is None else law.integral(before, after, x))
        return total

    def _capacity(self, T: np.ndarray) -> np.ndarray:
        """Return the heat capacity of the vertices at temperatures (J/K), owned entries."""
        x, total = self.at.x, np.zeros(len(T))
        for law, capacity in self._held_heat:
            total += capacity * (1.0 if law is None else law.at(T, x))
        return total

    def tried(self, T: np.ndarray, time: float, length: float, span: float) -> Tried:
        """Try one step of any length; its error is in K, infinite if it has no solution in reach.

        Parameters
        ----------
        T : temperature at the start (K), owned entries, shape (n_owned,).
        time : time at the start (s).
        length : length of the step (s).
        span : largest change of temperature so far (K), the scale of the tolerances.
        """
        at, held = self.at, self.at.held
        times = (time, time + GAMMA * length, time + length)
        prescribed = [at.held_values(t) for t in times]
        started = T.copy()
        started[held] = prescribed[0]  # a jump at the start
        gain, entering = self._rates(started, at.exchanges(times[0]))
        rate, later = gain.copy(), started.copy()
        later[held] = prescribed[1]
        rate[held] = self.gained(started, later)[held] / (GAMMA * length)
        rates, sides = [rate], [by_cause(at, rate[held], gain, entering)]
        stage = started
        for i, weights in ((1, [D]), (2, [W, W])):
            base = length * np.einsum("i,ij", weights, rates)
            exchanges = at.exchanges(times[i])
            first = stage.copy()
            first[held] = prescribed[i]
            try:
                stage = self._stage(started, base, first, exchanges, D * length, span)
            except SolveError:
                return Tried(T=T, error=np.inf, entered={})
            gain, entering = self._rates(stage, exchanges)
            rate = gain.copy()
            rate[held] = (self.gained(started, stage) - base)[held] / (D * length)
            rates.append(rate)
            sides.append(by_cause(at, rate[held], gain, entering))
        entered = defaultdict[str, float](float)
        for weight, amounts in zip(WEIGHTS.tolist(), sides, strict=True):
            for name, amount in amounts.items():
                entered[name] += length * weight * amount
        jumped = self.gained(T, started)[held]
        for name, part in at.held_by_side():
            entered[name] += float(jumped[part].sum())
        difference = length * np.einsum("i,ij", WEIGHTS - EMBEDDED, rates)
        try:
            error = max_over_ranks(self.comm, np.abs(self._solve(difference)))
        except SolveError:
            error = np.inf
        return Tried(T=stage, error=error, entered=entered)

    def _rates(
        self, T: np.ndarray, exchanges: list[HeatExchange]
    ) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """Return the heat that vertices gain in total (W), and from each cause but neighbors."""
        entering = {e.name: e.entering(T) for e in exchanges}
        return np.sum(list(entering.values()), axis=0) + self._conducted(T), entering

    def _conducted(self, T: np.ndarray) -> np.ndarray:
        """Return the heat that flows to the vertices from their neighbors (W), owned entries."""
        self._put(T)
        self._sums.x.array[:] = 0.0
        fem.assemble_vector(self._sums.x.array, self._conduct)
        self._sums.x.scatter_reverse(la.InsertMode.add)
        return -owned(self._sums)

    def _put(self, T: np.ndarray) -> None:
        for function, values in ((self._T, T), (self._above, T - self._level)):
            owned(function)[:] = values
            function.x.scatter_forward()

    def _stage(
        self,
        started: np.ndarray,
        base: np.ndarray,
        first: np.ndarray,
        exchanges: list[HeatExchange],
        scale: float,
        span: float,
    ) -> np.ndarray:
        """Return the temperatures (K) of a stage.

        There the heat gained since `started` is `base` (J) plus `scale` (s) times the rates.

        Parameters
        ----------
        started : temperature at the start of the step (K).
        base : heat from the earlier stages (J).
        first : first guess (K), with the prescribed values.
        exchanges : boundary heat exchange at the time of the stage.
        scale : factor of the rates (s).
        span : largest change of temperature so far (K).

        Raises
        ------
        SolveError
            Newton's method does not converge.
        """

        def missing(T: np.ndarray) -> np.ndarray:
            return np.asarray(
                self._free * (self.gained(started, T) - base - scale * self._rates(T, exchanges)[0])
            )

        T, left = first, missing(first)
        size = self._size(left)
        for _ in range(MOST):
            self._make(T, exchanges, scale)  # also for the error, at the end
            reach = max(span, max_over_ranks(self.comm, np.abs(T - started)))
            if size <= SOLVED * reach + ROUND_OFF * max_over_ranks(self.comm, np.abs(T)):
                return T
            step, length = self._solve(left), 1.0
            for _ in range(HALVINGS):
                there = T - length * step
                left_there, size_there = self._tried_at(missing, there)
                if size_there < (1 - length / 4) * size:
                    break
                length /= 2
            else:
                if size <= ENOUGH * reach:
                    return T
                raise SolveError("the heat equation was not solved: no step lowers the residual")
            T, left, size = there, left_there, size_there
        raise SolveError(f"the heat equation was not solved in {MOST} steps of Newton's method")

    def _tried_at(
        self, missing: Callable[[np.ndarray], np.ndarray], T: np.ndarray
    ) -> tuple[np.ndarray, float]:
        """Return the residual at temperatures (K) of the line search, and its size."""
        try:
            left = missing(T)
        except LoadError:  # a heat transfer coefficient is not defined there
            return T, np.inf
        return left, self._size(left)

    def _size(self, heat: np.ndarray) -> float:
        """Return the largest change (K) that heat (J) makes; infinite if it is no number."""
        sizes = np.nan_to_num(np.abs(heat) / self.at.capacity, nan=np.inf, posinf=np.inf)
        return max_over_ranks(self.comm, sizes)

    def _make(self, T: np.ndarray, exchanges: list[HeatExchange], scale: float) -> None:
        """Fill the derivative of the residual: C(T) - scale times that of the rates."""
        self._put(T)
        self._matrix.zeroEntries()
        fem_petsc.assemble_matrix(self._matrix, self._slope)
        self._matrix.assemble()
        self._matrix.scale(scale)
        films = np.sum([e.slope(T) for e in exchanges], axis=0)
        writable(self._diagonal)[:] = self._capacity(T) - scale * films
        self._matrix.setDiagonal(self._diagonal, PETSc.InsertMode.ADD_VALUES)
        pivot = max_over_ranks(self.comm, self.at.capacity)
        self._matrix.zeroRowsColumns(self._rows, diag=pivot)

    def _solve(self, heat: np.ndarray) -> np.ndarray:
        writable(self._rhs)[:] = heat * self._free
        with petsc_errors("the heat equation was not solved", self._ksp.comm):
            self._ksp.solve(self._rhs, self._solution)
        end = how_it_ended(self._ksp)
        if not end.converged:
            raise SolveError(
                f"the heat equation was not solved by its linear solver: {end.sentence}"
            )
        return readable(self._solution).copy()

    def destroy(self) -> None:
        """Free the PETSc objects."""
        for thing in (self._ksp, self._matrix, self._diagonal, self._rhs, self._solution):
            thing.destroy()
