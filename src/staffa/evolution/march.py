"""Time loop: one minimization a step, its audit, and its record."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import partial
from time import perf_counter
from types import NoneType

from staffa.arguments import require
from staffa.backend.parallel import max_over_ranks, require_together
from staffa.errors import PartedError, SolveError, StoppedError
from staffa.evolution.advanced_step import Advance
from staffa.evolution.audit import Before, audit
from staffa.evolution.backtrack import Better, StepHistory, better_earlier, go_back
from staffa.evolution.equilibrate import Loads
from staffa.evolution.loop_numbers import Finer
from staffa.evolution.observers import Observers as Observers
from staffa.evolution.problem import Problem
from staffa.evolution.rejected_steps import not_returned, rejected
from staffa.evolution.resolution import TooCoarseError
from staffa.evolution.rest import rest_on_fine_mesh
from staffa.evolution.restart_state import FirstGuess, Loop, RestartState
from staffa.evolution.schedule import AdaptiveSteps
from staffa.evolution.second_order import examine
from staffa.evolution.session import Session
from staffa.evolution.snapshot import restore
from staffa.evolution.step_record import accepted, failed, mesh_record
from staffa.evolution.system import System
from staffa.evolution.try_step import try_step
from staffa.minimize.alternate import Sweep
from staffa.records.step import (
    Moment,
    SolverStatistics,
    Stability,
    Step,
)

# Change of the damage in a sweep from which on cracks are near to where they will be: if the mesh
# is too coarse for them, the rest of the sweeps would be lost.
ROUGH = 0.002


def march(
    problem: Problem,
    system: System,
    observers: Observers | None = None,
    restart: RestartState | None = None,
) -> Iterator[Step]:
    """Visit the times of the problem; yield the record of each complete step. Collective.

    With backtracking a step may come again (see `records.Step.returned`); a failed return is
    recorded (status "rejected") and given up. Adaptive steps may be rejected before they come.

    Parameters
    ----------
    problem : the problem.
    system : its system.
    observers : functions called at each step; None for the measures alone.
    restart : restart state, as `observers.keep` received it; None to start.

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
    yield from march_session(Session(problem, system), observers, restart)


def march_session(
    session: Session, observers: Observers | None = None, restart: RestartState | None = None
) -> Iterator[Step]:
    """The same as `march`, for a session, whose mesh may change while a step is yielded.

    Parameters
    ----------
    session : owner of the mesh and of all that is built for it.
    observers : see `Observers`; None for none but the measures.
    restart : restart state to go on from; None to begin.
    """
    observers = observers or Observers()
    try:
        loop = _started(session, observers) if restart is None else restart.taken_up(session)
        while (taken := _take(session, observers, loop)) is not None:
            yield taken.step
            if taken.error is not None:
                raise taken.error
    finally:
        if session.history:
            session.history.close()


def _started(session: Session, observers: Observers) -> Loop:
    """The loop before the first step, in the initial equilibrium. Collective."""
    rest_on_fine_mesh(session, observers.pause)
    problem, system = session.problem, session.system
    if session.circulated:
        system.thermal.put(session.circulated.at_rest(system.thermal.read(), system.cracks))
    if problem.backtracking:
        session.history = StepHistory(system)
    walk, total = AdaptiveSteps(problem.schedule), system.energy.total()
    return Loop(session=session, walk=walk, total=total, changes=session.changes)


@dataclass(frozen=True, kw_only=True)
class _Taken:
    """The record of a step, and the error with which the run ends after it, if it does."""

    step: Step
    error: SolveError | None = None


@dataclass(frozen=True, kw_only=True)
class _Start:
    """All that a step begins with.

    Attributes
    ----------
    moment : number and time of the step.
    restart : restart state before it.
    before : the state before it, as it is on record.
    start, end : loads that it begins and ends with.
    better : the earlier step that it returns to; None for the next step.
    clock : seconds at which it began, by `perf_counter`.
    """

    moment: Moment
    restart: RestartState
    before: Before
    start: Loads
    end: Loads
    better: Better | None
    clock: float


def _take(session: Session, observers: Observers, loop: Loop) -> _Taken | None:
    """Take the next step, on a mesh that is fine enough for it; None at the end. Collective."""
    clock = perf_counter()
    while True:
        loop.meet_mesh()
        if loop.history and loop.due:
            _look_back(session, observers, loop, loop.history)
        session.system.energy.book()
        time, restart = loop.next_time(), loop.restart()
        observers.keep(restart, time is None)
        if time is None:
            return None
        started = _start(session, loop, restart, time, clock)
        session.system.begin()
        try:
            observers.pause()
            if loop.history and started.better:
                return _return(session, observers, loop, started, loop.history, started.better)
            return _advance(session, observers, loop, started)
        except TooCoarseError as error:
            _refine(session, loop, started, error)
        except StoppedError:
            observers.keep(started.restart, True)
            raise


def _start(
    session: Session, loop: Loop, restart: RestartState, time: float, clock: float
) -> _Start:
    """All that a step to a time begins with, on the current mesh. Collective."""
    problem, system = session.problem, session.system
    return _Start(
        moment=_moment(problem, loop.next_index, time),
        restart=restart,
        before=loop.before(restart.kept),
        start=loop.start(),
        end=Loads(time=time, values=system.supports.values(time)),
        better=loop.better if loop.history else None,
        clock=clock,
    )


def _refine(session: Session, loop: Loop, started: _Start, error: TooCoarseError) -> None:
    """Split cells, and go back to the state with which the step began. Collective.

    What damage grew to is a first guess for the next try. An earlier step is looked for again: on
    the finer mesh another one may be better, or none.
    """
    time, damage = started.moment.time, None
    if not started.better:
        damage = session.state.alpha.x.array.copy()
        if not max_over_ranks(session.comm, damage - started.restart.kept.alpha) > 0:
            damage = loop.guess(time)  # this try ended before cracks grew
    restore(session.system, started.restart.kept)
    if loop.history and started.better:
        index = started.better.index
        loop.history.returns[index] = started.restart.returns.get(index, 0)
        loop.better, loop.due = None, True
    damage = session.refine(error.wanted, damage)
    loop.tried = None if damage is None else FirstGuess(time=time, alpha=damage)
    try:
        loop.meet_mesh()
    except SolveError as failure:
        require_together(session.comm, failure)
        index = started.moment.index
        raise SolveError(f"step {index} failed on a finer mesh: {failure}") from failure


def _advance(session: Session, observers: Observers, loop: Loop, started: _Start) -> _Taken:
    """Take a step to a later time. Collective."""
    problem, guess = session.problem, loop.guess(started.moment.time)
    system = replace(session.system, tried=guess)
    linear, watch = (
        system.alternation.elastic.linear,
        partial(_watch, session, observers, started.moment),
    )
    direct = linear.takeovers
    try:
        tried = try_step(problem, system, started.start, started.end, loop.walk, watch)
    except SolveError as error:
        require_together(session.comm, error)
        observers.keep(started.restart, True)
        moment = started.moment
        words = f"step {moment.index} (time {moment.time:.6g}) failed: {error}"
        ending = PartedError(words) if isinstance(error, PartedError) else SolveError(words)
        ending.__cause__ = error
        return _Taken(step=failed(session, moment, observers, str(error)), error=ending)
    if not tried.rejected:
        system.require_fine()
    seconds = perf_counter() - started.clock
    if tried.rejected:
        return _Taken(step=rejected(problem, started.moment, tried.advance, tried.ran, seconds))
    advance = tried.advance.after(SolverStatistics(direct=linear.takeovers - direct))
    taken = _stands(session, observers, loop, started, advance, tried.stability, seconds)
    if taken.error is None:
        loop.walk.onward(started.moment.time, tried.ran)
        _go_on(session, loop, started, advance)
    return taken


def _return(
    session: Session,
    observers: Observers,
    loop: Loop,
    started: _Start,
    history: StepHistory,
    better: Better,
) -> _Taken:
    """Go back to an earlier step. Collective."""
    problem, system, spent = session.problem, session.system, None
    linear, watch = (
        system.alternation.elastic.linear,
        partial(_watch, session, observers, started.moment),
    )
    direct = linear.takeovers
    try:
        advance = go_back(problem, system, history, better, watch)
        advance, stability = examine(problem, system, started.end, advance, watch)
        spent = advance.outcome
        if not spent.converged:
            raise SolveError(spent.reason)
        system.require_fine()
    except SolveError as error:
        require_together(session.comm, error)
        restore(system, started.restart.kept)
        index = started.moment.index
        history.failed.add(index)
        history.returns[index] = started.restart.returns.get(index, 0)
        loop.better, loop.due = None, True  # another step may be better too
        seconds = perf_counter() - started.clock
        return _Taken(
            step=not_returned(system, started.moment, history, better, error, spent, seconds)
        )
    seconds = perf_counter() - started.clock
    advance = advance.after(SolverStatistics(direct=linear.takeovers - direct))
    taken = _stands(session, observers, loop, started, advance, stability, seconds)
    loop.walk.back(started.moment.time)
    history.failed.clear()  # the damage is another
    _go_on(session, loop, started, advance)
    return taken


def _stands(
    session: Session,
    observers: Observers,
    loop: Loop,
    started: _Start,
    advance: Advance,
    stability: Stability | None,
    seconds: float,
) -> _Taken:
    """Audit and record a step that stands, converged or not. Collective."""
    problem, system, outcome = session.problem, session.system, advance.outcome
    if not outcome.converged:
        observers.keep(started.restart, True)
    audited = audit(problem, system, started.before, advance, stability)
    step = accepted(session, started.moment, observers, advance, audited, stability, seconds)
    if system.resolution:
        step = replace(step, mesh=mesh_record(session, loop))
    if system.hoop:
        step = replace(step, hoop=system.hoop.share(started.before.alpha))
    if outcome.converged:
        return _Taken(step=step)
    when = f"step {step.index} (time {step.time:.6g})"
    return _Taken(step=step, error=SolveError(f"{when} {outcome.reason}; its state is saved"))


def _go_on(session: Session, loop: Loop, started: _Start, advance: Advance) -> None:
    """Let the next step follow on one that stands."""
    index, history = started.moment.index, loop.history
    loop.index, loop.better = index + 1, None
    loop.total = advance.outcome.energies.total
    loop.finer, loop.tried = Finer(), None
    if history:
        history.drop(index)
        history.keep(started.end, advance, session.system)
        loop.due = True


def _watch(session: Session, observers: Observers, moment: Moment, sweep: Sweep | None) -> None:
    if sweep is not None:
        observers.watch(moment, sweep)
    observers.pause()
    resolution = session.system.resolution
    if resolution and sweep is not None and sweep.change <= ROUGH:
        resolution.require_at_cracks()


def _look_back(session: Session, observers: Observers, loop: Loop, history: StepHistory) -> None:
    """Find the step to return to, if any; after a failure it stays due for a resumed run."""
    try:
        loop.better = better_earlier(session.problem, session.system, history)
    except SolveError as error:
        require_together(session.comm, error)
        observers.keep(loop.restart(), True)
        raise SolveError(
            f"step {loop.index - 1} is saved, but looking back failed: {error}"
        ) from error
    loop.due = False


def _moment(problem: Problem, index: int, time: float) -> Moment:
    return Moment(
        index=index, time=time, tau=None if problem.tau_of is None else problem.tau_of(time)
    )
