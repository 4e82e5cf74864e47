"""Time loop: one minimization a step, its audit, and its record."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter
from types import NoneType

import numpy as np

from staffa.arguments import require
from staffa.backend.parallel import require_together
from staffa.errors import PartedError, SolveError, StoppedError
from staffa.evolution.advance import Advance, advance_to, restore, snapshot
from staffa.evolution.audit import audit
from staffa.evolution.backtrack import Better, StepHistory, better_earlier, go_back
from staffa.evolution.equilibrate import Loads
from staffa.evolution.initial_equilibrium import come_to_rest
from staffa.evolution.loose_parts import require_whole
from staffa.evolution.measures import measuring
from staffa.evolution.problem import Problem
from staffa.evolution.restart_state import Loop, RestartState
from staffa.evolution.schedule import AdaptiveSteps
from staffa.evolution.second_order import examine
from staffa.evolution.system import System
from staffa.measure.growth import crack_advance
from staffa.measure.reactions import reactions
from staffa.minimize.alternate import Sweep, Watch
from staffa.records.step import (
    REJECTED,
    Audit,
    Measures,
    Moment,
    Outcome,
    Return,
    SolverStatistics,
    Stability,
    Step,
)
from staffa.records.tip_release import Release


@dataclass(frozen=True, kw_only=True)
class Observers:
    """Functions that are called at each step.

    Attributes
    ----------
    measure : returns the measures of the state, collective; None for those of the problem.
    probe : returns the fields at the probes, collective.
    save : (moment, converged) -> name of the file written, or None, collective.
    release : returns G at the tips of a saved state, collective.
    watch : called after each sweep, with the step's moment.
    keep : called with the restart state before each step and after the last, and True if it must be
        kept now, collective.
    pause : raises `StoppedError` on all ranks if the run is to stop.
    """

    measure: Callable[[], Measures | None] | None = None
    probe: Callable[[], tuple[tuple[float, ...], ...]] = lambda: ()
    save: Callable[[Moment, bool], str | None] = lambda moment, converged: None
    release: Callable[[], tuple[Release, ...]] = lambda: ()
    watch: Callable[[Moment, Sweep], None] = lambda moment, sweep: None
    keep: Callable[[RestartState, bool], None] = lambda standing, now: None
    pause: Callable[[], None] = lambda: None


def march(
    problem: Problem,
    system: System,
    observers: Observers | None = None,
    standing: RestartState | None = None,
) -> Iterator[Step]:
    """Visit the times of the problem; yield the record of each complete step. Collective.

    With backtracking a step may come again (see `records.Step.returned`); a failed return is
    recorded (status "rejected") and given up. Adaptive steps may be rejected before they come.

    Parameters
    ----------
    problem : the problem.
    system : its system.
    observers : functions called at each step; None for the measures alone.
    standing : restart state, as `observers.keep` received it; None to start.

    Raises
    ------
    PartedError
        The load cannot be carried any more; as with any `SolveError`, earlier steps are kept.
    SolveError
        A step did not converge, or a solver failed in it. It was saved and yielded before, with its
        status and reason, and the restart state before it was kept.
    LoadError
        The loads crack the rock by themselves before the first step.
    StoppedError
        `observers.pause` raised it; the restart state before the current step was kept, if the
        initial equilibrium was found.
    """
    require(problem, Problem, "problem", "give a Problem, as staffa.problem(case) makes one")
    require(system, System, "system", "give a System, as staffa.build(problem) makes one")
    require(observers, (Observers, NoneType), "observers", "give staffa.evolution.march.Observers")
    observers = observers or Observers()
    observers = replace(observers, measure=observers.measure or measuring(problem, system))
    if standing is None:
        come_to_rest(problem, system, lambda sweep: observers.pause())
        history = StepHistory(system.state) if problem.backtracking else None
        rest = system.energy.total()
        loop = Loop(walk=AdaptiveSteps(problem.schedule), history=history, total=rest)
    else:
        loop = standing.taken_up(problem, system)
    try:
        yield from _visit(problem, system, observers, loop)
    finally:
        if loop.history:
            loop.history.close()


def _visit(problem: Problem, system: System, observers: Observers, loop: Loop) -> Iterator[Step]:
    walk, history = loop.walk, loop.history
    start = loop.start(system)
    while True:
        if history and loop.due:
            _look_back(problem, system, observers, loop, history)
        system.energy.book()
        time, standing = loop.next_time(), loop.standing(system)
        observers.keep(standing, time is None)
        if time is None:
            return
        began = perf_counter()
        index, better = loop.next_index, loop.better
        elastic = system.alternation.elastic
        system.begin()
        direct = elastic.linear.takeovers
        moment = _moment(problem, index, time)
        end = Loads(time=time, values=system.supports.values(time))
        watch = partial(_watch, observers, moment)
        before, spent = loop.before(standing.kept), None
        try:
            observers.pause()
            if history and better:
                advance = go_back(problem, system, history, better, watch)
                advance, stability = examine(problem, system, end, advance, watch)
                ran, rejected, spent = 0.0, False, advance.outcome
                if not advance.outcome.converged:
                    raise SolveError(advance.outcome.reason)
            else:
                tried = _try(problem, system, start, end, walk, watch)
                advance, stability, ran, rejected = tried
        except StoppedError:
            observers.keep(standing, True)
            raise
        except SolveError as error:
            require_together(problem.domain.comm, error)
            if history and better:
                restore(system, standing.kept)
                history.failed.add(index)
                history.returns[index] = standing.returns.get(index, 0)
                loop.better, loop.due = None, True  # another step may be better too
                seconds = perf_counter() - began
                yield _not_returned(system, moment, history, better, error, spent, seconds)
                continue
            observers.keep(standing, True)
            yield _failed(system, moment, observers, str(error))
            kind = PartedError if isinstance(error, PartedError) else SolveError
            raise kind(f"step {index} (time {time:.6g}) failed: {error}") from error
        seconds = perf_counter() - began
        if rejected:
            yield _rejected(problem, moment, advance, ran, seconds)
            continue
        advance = advance.after(SolverStatistics(direct=elastic.linear.takeovers - direct))
        outcome = advance.outcome
        if not outcome.converged:
            observers.keep(standing, True)
        audited = audit(problem, system, before, advance, stability)
        accepted = _accepted(system, moment, observers, advance, audited, stability, seconds)
        yield replace(accepted, hoop=system.hoop.share(before.alpha) if system.hoop else None)
        if not outcome.converged:
            raise SolveError(f"step {index} (time {time:.6g}) {outcome.reason}; its state is saved")
        if better and history:
            walk.back(time)
            history.failed.clear()  # the damage is another
        else:
            walk.onward(time, ran)
        start, loop.index, loop.better = end, index + 1, None
        loop.total = outcome.energies.total
        if history:
            history.drop(index)
            history.keep(end, advance, system.state)
            loop.due = True


def _watch(observers: Observers, moment: Moment, sweep: Sweep | None) -> None:
    if sweep is not None:
        observers.watch(moment, sweep)
    observers.pause()


def _try(
    problem: Problem,
    system: System,
    start: Loads,
    end: Loads,
    walk: AdaptiveSteps,
    watch: Watch,
) -> tuple[Advance, Stability | None, float, bool]:
    """Take a step; return it, its second order, the crack advance, and True if that is too far.

    Then the state is the one before it. The crack advance is found again if a saddle was left.
    Collective.
    """
    before = snapshot(system)
    if problem.schedule.pace is None:
        advance = advance_to(problem, system, start, end, watch)
        examined = examine(problem, system, end, advance, watch)
        _require_whole(problem, system, before)
        return *examined, 0.0, False
    advance, stability = advance_to(problem, system, start, end, watch), None
    ran = _ran(problem, system, before)
    rejected = walk.goes_too_far(ran)
    if not rejected:
        advance, stability = examine(problem, system, end, advance, watch)
        if (stability and stability.escapes) or (advance.curvature and advance.curvature.escapes):
            ran = _ran(problem, system, before)
            rejected = walk.goes_too_far(ran)
    if rejected:
        restore(system, before)
    else:
        _require_whole(problem, system, before)
    return advance, stability, ran, rejected


def _require_whole(problem: Problem, system: System, before: tuple[np.ndarray, ...]) -> None:
    """Call `require_whole`; if it refuses, restore the state before."""
    try:
        require_whole(problem, system)
    except PartedError:
        restore(system, before)
        raise


def _ran(problem: Problem, system: System, before: tuple[np.ndarray, ...]) -> float:
    """Return the crack advance since `snapshot` (m). Collective."""
    return crack_advance(system.state, before[1], threshold=problem.measuring.threshold)


def _look_back(
    problem: Problem, system: System, observers: Observers, loop: Loop, history: StepHistory
) -> None:
    """Find the step to return to, if any; after a failure it stays due for a resumed run."""
    try:
        loop.better = better_earlier(problem, system, history)
    except SolveError as error:
        require_together(problem.domain.comm, error)
        observers.keep(loop.standing(system), True)
        raise SolveError(
            f"step {loop.index - 1} is saved, but looking back failed: {error}"
        ) from error
    loop.due = False


def _moment(problem: Problem, index: int, time: float) -> Moment:
    return Moment(
        index=index, time=time, tau=None if problem.tau_of is None else problem.tau_of(time)
    )


def _accepted(
    system: System,
    moment: Moment,
    observers: Observers,
    advance: Advance,
    audited: Audit,
    stability: Stability | None,
    seconds: float,
) -> Step:
    """Return the record of a kept step, converged or not, after measuring and saving its state."""
    outcome = advance.outcome
    fields = observers.save(moment, outcome.converged)
    return Step(
        **vars(moment),
        energies=outcome.energies,
        sweeps=outcome.sweeps,
        status="converged" if outcome.converged else "not converged",
        reason=outcome.reason,
        audit=audited,
        measures=observers.measure() if observers.measure else None,
        effort=outcome.effort,
        fields=fields,
        released=observers.release() if fields and outcome.converged else (),
        seconds=seconds,
        returned=advance.returned,
        stability=stability,
        curvature=advance.curvature,
        heat=advance.all_heat,
        reactions=_reactions(system),
        probed=observers.probe(),
    )


def _reactions(system: System) -> dict[str, tuple[float, ...]]:
    """Return the reactions of the supports. Collective."""
    forces = system.alternation.u.duplicate()
    system.energy.residual(forces)
    mesh = system.state.u.function_space.mesh
    found = reactions(mesh.comm, system.supports, forces.array_r, dim=mesh.geometry.dim)
    forces.destroy()
    return found


def _rejected(
    problem: Problem, moment: Moment, advance: Advance, ran: float, seconds: float
) -> Step:
    """Return the record of a step in which cracks advanced too far."""
    assert problem.schedule.pace is not None
    outcome, ell, most = advance.outcome, problem.material.ell, problem.schedule.pace.advance
    how_far = f"ran {ran / ell:.3g} ell" if np.isfinite(ran) else "started"
    reason = f"cracks {how_far}, in a step that allows {most / ell:.3g} ell: taken again, shorter"
    return Step(
        **vars(moment),
        energies=outcome.energies,
        sweeps=outcome.sweeps,
        status=REJECTED,
        reason=reason if outcome.converged else f"{outcome.reason}; {reason}",
        effort=outcome.effort,
        seconds=seconds,
    )


def _not_returned(
    system: System,
    moment: Moment,
    history: StepHistory,
    better: Better,
    error: SolveError,
    spent: Outcome | None,
    seconds: float,
) -> Step:
    """Return the record of a failed return to an earlier step; the state is the last step's again.

    `spent` is its outcome, if it has one.
    """
    last = len(history.steps) - 1
    return Step(
        **vars(moment),
        energies=system.energy.energies(),
        sweeps=spent.sweeps if spent else 0,
        effort=spent.effort if spent else SolverStatistics(),
        status=REJECTED,
        reason=f"the return to it failed ({error}), and step {last} is kept",
        seconds=seconds,
        returned=Return(
            index=last,
            time=history.steps[-1].loads.time,
            before=history.steps[better.index].total,
            found=better.found,
        ),
    )


def _failed(system: System, moment: Moment, observers: Observers, reason: str) -> Step:
    """Return the record of a step in which all solvers failed, after saving the state before it."""
    return Step(
        **vars(moment),
        energies=system.energy.energies(),
        sweeps=0,
        status="failed",
        reason=reason,
        fields=observers.save(moment, False),
    )
