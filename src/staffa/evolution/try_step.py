"""One try of a step: how far cracks ran in it decides whether it stands."""

from dataclasses import dataclass

from staffa.errors import SolveError
from staffa.evolution.advance import advance_to
from staffa.evolution.advanced_step import Advance
from staffa.evolution.equilibrate import Loads
from staffa.evolution.loose_parts import require_whole
from staffa.evolution.problem import Problem
from staffa.evolution.schedule import AdaptiveSteps
from staffa.evolution.second_order import examine
from staffa.evolution.snapshot import Snapshot, restore, snapshot
from staffa.evolution.system import System
from staffa.measure.growth import crack_advance
from staffa.minimize.alternate import Watch
from staffa.records.step import Stability


@dataclass(frozen=True, kw_only=True)
class TriedStep:
    """A step that was tried.

    Attributes
    ----------
    advance : how the loads at its end were reached.
    stability : second order of its state, if that was asked for.
    ran : how far cracks ran (m); 0 where steps do not follow the cracks.
    rejected : True if they ran too far; the state is then the one before.
    """

    advance: Advance
    stability: Stability | None = None
    ran: float = 0.0
    rejected: bool = False


def try_step(
    problem: Problem,
    system: System,
    start: Loads,
    end: Loads,
    walk: AdaptiveSteps,
    watch: Watch,
) -> TriedStep:
    """Take a step, and put the state back where cracks ran too far in it. Collective.

    Cracks are looked at again if a state was left that is not stable.

    Parameters
    ----------
    problem, system : the state that the step begins with, and what acts on it.
    start, end : loads that the step begins and ends with.
    walk : lengths of steps; told where cracks ran too far.
    watch : called after each sweep.
    """
    before = snapshot(system)
    if problem.schedule.pace is None:
        advance = advance_to(problem, system, start, end, watch)
        advance, stability = examine(problem, system, end, advance, watch)
        _require_whole(problem, system, before)
        return TriedStep(advance=advance, stability=stability)
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
    return TriedStep(advance=advance, stability=stability, ran=ran, rejected=rejected)


def _require_whole(problem: Problem, system: System, before: Snapshot) -> None:
    """The same as `require_whole`, after which the state is the one before."""
    try:
        require_whole(problem, system)
    except SolveError:  # a body in two is one
        restore(system, before)
        raise


def _ran(problem: Problem, system: System, before: Snapshot) -> float:
    """Return how far cracks ran since a snapshot (m). Collective."""
    return crack_advance(system.state, before.alpha, threshold=problem.measuring.threshold)
