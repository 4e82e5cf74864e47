"""The time loop: one minimization a step, its audit, and its record."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from time import perf_counter

import numpy as np

from staffa.errors import SolveError
from staffa.evolution.advance import Advance, advance_to
from staffa.evolution.backtrack import History, better_earlier, go_back
from staffa.evolution.problem import Problem
from staffa.evolution.second_order import examine
from staffa.evolution.settle import Loads
from staffa.evolution.system import System
from staffa.minimize.alternate import Sweep, equilibrium
from staffa.records import Audit, Measures, Stability, Step

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


def march(problem: Problem, system: System, observers: Observers | None = None) -> Iterator[Step]:
    """Visit the times of the problem; yield each step when it is complete. Collective.

    With backtracking a step may come again: see `records.Step.returned`.

    Raises
    ------
    SolveError
        A step did not converge, or a solver failed in it; it has been saved and yielded before,
        with its status and the reason.
    """
    observers = observers or Observers()
    history = History(system.state.alpha.x.array) if problem.backtracking else None
    try:
        yield from _visit(problem, system, observers, history)
    finally:
        if history:
            history.close()


def _visit(
    problem: Problem, system: System, observers: Observers, history: History | None
) -> Iterator[Step]:
    times = problem.schedule.times
    start = Loads(time=0.0, values=np.zeros(len(system.supports.fixed)))
    equilibrium(system.alternation, start.values)
    index, better = 0, None  # better: an earlier step to go back to
    while index < len(times):
        started, time = perf_counter(), times[index]
        end = Loads(time=time, values=system.supports.values(time))
        try:
            if history and better:
                advance = go_back(problem, system, history, better)
                history.drop(index)
            else:
                watch = partial(observers.watch, index)
                advance = advance_to(problem, system, start, end, watch)
            advance, stability = examine(problem, system, end, advance)
        except SolveError as error:
            yield _failed(problem, system, index, time, observers, str(error))
            raise SolveError(f"step {index} (time {time:.6g}) failed: {error}") from error
        outcome = advance.outcome
        step = Step(
            index=index,
            time=time,
            tau=None if problem.tau_of is None else problem.tau_of(time),
            energies=outcome.energies,
            sweeps=outcome.sweeps,
            status="converged" if outcome.converged else "not converged",
            reason=outcome.reason,
            audit=audit(advance, stability),
            measures=observers.measure() if observers.measure else None,
            effort=outcome.effort,
            fields=observers.save(index, time, outcome.converged),
            seconds=perf_counter() - started,
            returned=advance.returned,
            stability=stability,
        )
        yield step
        if not outcome.converged:
            raise SolveError(f"step {index} (time {time:.6g}) {step.reason}; its state is saved")
        start = end
        if history:
            history.keep(end, advance, system.state.alpha.x.array)
            try:
                better = better_earlier(problem, system, history)
            except SolveError as error:
                raise SolveError(
                    f"step {index} is saved, but looking back failed: {error}"
                ) from error
        index = better.index if better else index + 1


def _failed(
    problem: Problem, system: System, index: int, time: float, observers: Observers, reason: str
) -> Step:
    """The record of a step in which all solvers failed, after saving the state before it."""
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


def audit(advance: Advance, stability: Stability | None = None) -> Audit:
    """Hold a step against what must be true of it."""
    outcome, healing, balance = advance.outcome, advance.healing, advance.imbalance
    checks = {
        f"the energy rose by {outcome.largest_rise:.1e} of itself in a half sweep": (
            outcome.largest_rise > RISE_ALLOWED
        ),
        f"damage healed by {healing:.1e}": healing > HEALING_ALLOWED,
        f"the energy balance is off by {balance:.1e} of the energy": balance > BALANCE_ALLOWED,
        f"the first-order residual is {outcome.residual:.1e}": not outcome.converged,
    }
    if stability and stability.failure:
        checks[f"its second order was not found: {stability.failure}"] = True
    return Audit(
        largest_rise=outcome.largest_rise,
        healing=max(healing, 0.0),
        optimality=outcome.residual,
        balance=balance,
        work=advance.work,
        released=advance.released,
        violations=tuple(sentence for sentence, violated in checks.items() if violated),
    )
