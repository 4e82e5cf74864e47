"""The time loop: one minimization a step, its audit, and its record."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from staffa.errors import SolveError
from staffa.evolution.problem import Irreversibility, Problem
from staffa.evolution.system import System
from staffa.fields import owned, read_vector, vertices, write_vector
from staffa.minimize.alternate import Sweep, alternate, equilibrium
from staffa.parallel import any_over_ranks, max_over_ranks, sum_over_ranks
from staffa.records import Audit, Measures, Outcome, Step

# What round-off and the tolerances of the inner solvers can explain, and no more.
RISE_ALLOWED = 1e-7
HEALING_ALLOWED = 1e-12
BALANCE_ALLOWED = 1e-5


@dataclass(frozen=True, kw_only=True)
class Observers:
    """What is done at each step by those who look on.

    measure: the measures of the state, collective; save: (index, time, converged) -> the name of
    the file written, or None, collective; watch: called after each sweep, with the step's index.
    """

    measure: Callable[[], Measures] | None = None
    save: Callable[[int, float, bool], str | None] = lambda index, time, converged: None
    watch: Callable[[int, Sweep], None] = lambda index, sweep: None


@dataclass(frozen=True, kw_only=True)
class Loading:
    """What changing the loads did with the cracks frozen.

    work: of the temperature change and of the prescribed displacements, both along the straight
    path from the loads before; exact for elasticity. start, end: total energies.
    """

    work: float
    start: float
    end: float


def march(problem: Problem, system: System, observers: Observers | None = None) -> Iterator[Step]:
    """Visit the times of the problem; yield each step when it is complete. Collective.

    Raises
    ------
    SolveError
        A step did not converge, or a solver failed in it; it has been saved and yielded before,
        with its status and the reason.
    """
    observers = observers or Observers()
    values = np.zeros(len(system.supports.fixed))
    equilibrium(system.alternation, values)
    for index, time in enumerate(problem.schedule.times):
        started = perf_counter()
        try:
            loading = change_loads(problem, system, time, values)
            values = system.supports.values(time)
            outcome, healing = minimize_step(problem, system, index, values, observers)
        except SolveError as error:
            yield _failed(problem, system, index, time, observers, str(error))
            raise SolveError(f"step {index} (time {time:.6g}) failed: {error}") from error
        step = Step(
            index=index,
            time=time,
            tau=None if problem.tau_of is None else problem.tau_of(time),
            energies=outcome.energies,
            sweeps=outcome.sweeps,
            status="converged" if outcome.converged else "not converged",
            reason=outcome.reason,
            audit=audit(outcome, loading, healing),
            measures=observers.measure() if observers.measure else None,
            fallbacks=outcome.fallbacks,
            fields=observers.save(index, time, outcome.converged),
            seconds=perf_counter() - started,
        )
        yield step
        if not outcome.converged:
            raise SolveError(f"step {index} (time {time:.6g}) {step.reason}; its state is saved")


def _failed(
    problem: Problem, system: System, index: int, time: float, observers: Observers, reason: str
) -> Step:
    """The record of a step in which a solver failed, after saving the last state before that."""
    write_vector(system.alternation.alpha, system.state.alpha)
    return Step(
        index=index,
        time=time,
        tau=None if problem.tau_of is None else problem.tau_of(time),
        energies=system.energy.energies(),
        sweeps=0,
        status="failed",
        reason=reason,
        fields=observers.save(index, time, False),
    )


def change_loads(problem: Problem, system: System, time: float, before: np.ndarray) -> Loading:
    """Put on the loads of a time with the cracks frozen, and account for the work. Collective.

    Parameters
    ----------
    before : prescribed displacements so far, shape (n_fixed,).
    """
    energy, state, parts = system.energy, system.state, system.alternation
    x = vertices(state.T.function_space).T
    T = problem.load.temperature(x, time)
    if any_over_ranks(problem.domain.comm, not np.all(np.isfinite(T))):
        raise SolveError(
            f"the load gives a temperature that is not finite at time {time:.6g}; mend the load"
        )
    values = system.supports.values(time)

    def power() -> float:
        reactions = float(parts.elastic.reactions(parts.u) @ (values - before))
        return energy.thermal_power() + sum_over_ranks(problem.domain.comm, reactions)

    energy.direction.x.array[:] = T - state.T.x.array
    start, power_before = energy.total(), power()
    state.T.x.array[:] = T
    equilibrium(parts, values)
    return Loading(work=(power_before + power()) / 2, start=start, end=energy.total())


def raise_bounds(rule: Irreversibility, system: System) -> None:
    """Bound the damage from below by what must not heal."""
    alpha = system.state.alpha.x.array
    kept = alpha >= rule.threshold if rule.crack_set_only else np.full(len(alpha), True)
    system.bounds.lower.x.array[:] = np.where(kept, alpha, 0.0)


def minimize_step(
    problem: Problem, system: System, index: int, values: np.ndarray, observers: Observers
) -> tuple[Outcome, float]:
    """Minimize from the frozen state; the outcome, and how far the damage sank below its bound."""
    raise_bounds(problem.irreversibility, system)
    parts, state, bounds = system.alternation, system.state, system.bounds
    read_vector(state.alpha, parts.alpha)
    outcome = alternate(
        parts,
        values,
        bounds.lower.x.petsc_vec,
        bounds.upper.x.petsc_vec,
        problem.solvers.stop,
        lambda sweep: observers.watch(index, sweep),
    )
    write_vector(parts.alpha, state.alpha)
    sunk = owned(bounds.lower) - owned(state.alpha)
    return outcome, max_over_ranks(problem.domain.comm, sunk)


def audit(outcome: Outcome, loading: Loading, healing: float) -> Audit:
    """Hold a step against what must be true of it."""
    end = outcome.energies.total
    scale = max(abs(loading.start), abs(loading.end), abs(end), 1e-300)
    balance = abs(loading.end - loading.start - loading.work) / scale
    checks = {
        f"the energy rose by {outcome.largest_rise:.1e} of itself in a half sweep": (
            outcome.largest_rise > RISE_ALLOWED
        ),
        f"damage healed by {healing:.1e}": healing > HEALING_ALLOWED,
        f"the energy balance is off by {balance:.1e} of the energy": balance > BALANCE_ALLOWED,
        f"the first-order residual is {outcome.residual:.1e}": not outcome.converged,
    }
    return Audit(
        largest_rise=outcome.largest_rise,
        healing=max(healing, 0.0),
        optimality=outcome.residual,
        balance=balance,
        work=loading.work,
        released=loading.end - end,
        violations=tuple(sentence for sentence, violated in checks.items() if violated),
    )
