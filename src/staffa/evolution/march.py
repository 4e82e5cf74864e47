"""The time loop: one minimization a step, its audit, and its record."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np

from staffa.errors import SolveError
from staffa.evolution.advance import Advance, advance_to, restore, snapshot
from staffa.evolution.backtrack import History, better_earlier, go_back
from staffa.evolution.problem import Problem
from staffa.evolution.schedule import Walk
from staffa.evolution.second_order import examine
from staffa.evolution.settle import Loads
from staffa.evolution.system import System
from staffa.measure.advance import crack_advance
from staffa.minimize.alternate import Sweep, equilibrium
from staffa.records import REJECTED, Audit, Measures, Moment, Outcome, Stability, Step

# What round-off and the tolerances of the inner solvers can explain, and no more.
RISE_ALLOWED = 1e-7
HEALING_ALLOWED = 1e-12
BALANCE_ALLOWED = 1e-5


@dataclass(frozen=True, kw_only=True)
class Observers:
    """What is done at each step by those who look on.

    measure: the measures of the state, collective; save: (moment, converged) -> the name of the
    file written, or None, collective; watch: called after each sweep, with the step's moment.
    """

    measure: Callable[[], Measures] | None = None
    save: Callable[[Moment, bool], str | None] = lambda moment, converged: None
    watch: Callable[[Moment, Sweep], None] = lambda moment, sweep: None


def march(problem: Problem, system: System, observers: Observers | None = None) -> Iterator[Step]:
    """Visit the times of the problem; yield each step when it is complete. Collective.

    With backtracking a step may come again (see `records.Step.returned`), and where steps follow
    the cracks one may be rejected before it comes (status "rejected").

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
    walk = Walk(problem.schedule)
    start = Loads(time=0.0, values=np.zeros(len(system.supports.fixed)))
    equilibrium(system.alternation, start.values)
    time: float | None = walk.first()
    index, better = 0, None  # better: an earlier step to go back to
    while time is not None:
        started = perf_counter()
        before = snapshot(system) if problem.schedule.pace else ()
        moment = _moment(problem, index, time)
        end = Loads(time=time, values=system.supports.values(time))
        try:
            watch = partial(observers.watch, moment)
            if history and better:
                advance = go_back(problem, system, history, better, watch)
                history.drop(index)
            else:
                advance = advance_to(problem, system, start, end, watch)
            if better or not advance.outcome.converged:
                ran, nearer = 0.0, None
            else:
                ran = _advance_of_cracks(problem, system, before)
                nearer = walk.again(start.time, time, ran)
            if nearer is not None:
                restore(system, before)
                yield _rejected(problem, moment, advance, ran, perf_counter() - started)
                time = nearer
                continue
            advance, stability = examine(problem, system, end, advance)
        except SolveError as error:
            yield _failed(system, moment, observers, str(error))
            raise SolveError(f"step {index} (time {time:.6g}) failed: {error}") from error
        outcome = advance.outcome
        yield _step(
            moment,
            outcome,
            status="converged" if outcome.converged else "not converged",
            audit=audit(advance, stability),
            measures=observers.measure() if observers.measure else None,
            fields=observers.save(moment, outcome.converged),
            seconds=perf_counter() - started,
            returned=advance.returned,
            stability=stability,
        )
        if not outcome.converged:
            raise SolveError(f"step {index} (time {time:.6g}) {outcome.reason}; its state is saved")
        time = walk.resume(time) if better else walk.onward(start.time, time, ran)
        start, index, better = end, index + 1, None
        if history:
            history.keep(end, advance, system.state.alpha.x.array)
            try:
                better = better_earlier(problem, system, history)
            except SolveError as error:
                raise SolveError(
                    f"step {index - 1} is saved, but looking back failed: {error}"
                ) from error
        if history and better:
            index, time = better.index, history.steps[better.index].loads.time


def _moment(problem: Problem, index: int, time: float) -> Moment:
    return Moment(
        index=index, time=time, tau=None if problem.tau_of is None else problem.tau_of(time)
    )


def _advance_of_cracks(problem: Problem, system: System, before: tuple[np.ndarray, ...]) -> float:
    """How far cracks ran since `snapshot`, if that is what steps follow. Collective."""
    if problem.schedule.pace is None:
        return 0.0
    threshold = problem.measuring.threshold
    return crack_advance(system.state, before[1], threshold=threshold)


def _step(moment: Moment, outcome: Outcome, **more: Any) -> Step:
    """The record of a minimization at this moment."""
    return Step(
        **vars(moment),
        energies=outcome.energies,
        sweeps=outcome.sweeps,
        effort=outcome.effort,
        **{"reason": outcome.reason, **more},
    )


def _rejected(
    problem: Problem, moment: Moment, advance: Advance, ran: float, seconds: float
) -> Step:
    """The record of a step in which cracks ran too far."""
    assert problem.schedule.pace is not None
    ell, most = problem.material.ell, problem.schedule.pace.advance
    how_far = f"ran {ran / ell:.3g} ell" if np.isfinite(ran) else "started"
    reason = f"cracks {how_far}, in a step that allows {most / ell:.3g} ell: taken again, shorter"
    return _step(moment, advance.outcome, status=REJECTED, reason=reason, seconds=seconds)


def _failed(system: System, moment: Moment, observers: Observers, reason: str) -> Step:
    """The record of a step in which all solvers failed, after saving the state before it."""
    return Step(
        **vars(moment),
        energies=system.energy.energies(),
        sweeps=0,
        status="failed",
        reason=reason,
        fields=observers.save(moment, False),
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
