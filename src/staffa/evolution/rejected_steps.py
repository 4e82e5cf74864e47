"""Records of steps that stand for no state of the run: too long, or a return that failed."""

import numpy as np

from staffa.errors import SolveError
from staffa.evolution.advanced_step import Advance
from staffa.evolution.backtrack import Better, StepHistory
from staffa.evolution.problem import Problem
from staffa.evolution.system import System
from staffa.records.status import Status
from staffa.records.step import Moment, Outcome, Return, SolverStatistics, Step


def rejected(
    problem: Problem, moment: Moment, advance: Advance, ran: float, seconds: float
) -> Step:
    """Return the record of a step in which cracks ran too far.

    Parameters
    ----------
    problem : the problem.
    moment : number and time of the step.
    advance : result of the step.
    ran : distance by which cracks grew (m); infinite where they started.
    seconds : computing time.
    """
    assert problem.schedule.pace is not None
    outcome, ell, most = advance.outcome, problem.material.ell, problem.schedule.pace.advance
    how_far = f"ran {ran / ell:.3g} ell" if np.isfinite(ran) else "started"
    reason = f"cracks {how_far}, in a step that allows {most / ell:.3g} ell: taken again, shorter"
    return Step(
        **vars(moment),
        energies=outcome.energies,
        sweeps=outcome.sweeps,
        status=Status.REJECTED,
        reason=reason if outcome.converged else f"{outcome.reason}; {reason}",
        effort=outcome.effort,
        seconds=seconds,
    )


def not_returned(
    system: System,
    moment: Moment,
    history: StepHistory,
    better: Better,
    error: SolveError,
    spent: Outcome | None,
    seconds: float,
) -> Step:
    """Return the record of a failed return to an earlier step; the last step's state stands again.

    Parameters
    ----------
    system : its state.
    moment : number and time of the earlier step.
    history : kept steps.
    better : the earlier step, and its energy with the later damage.
    error : reason of the failure.
    spent : result of its minimization; None if that did not end.
    seconds : computing time.
    """
    last = len(history.steps) - 1
    return Step(
        **vars(moment),
        energies=system.energy.energies(),
        sweeps=spent.sweeps if spent else 0,
        effort=spent.effort if spent else SolverStatistics(),
        status=Status.REJECTED,
        reason=f"the return to it failed ({error}), and step {last} stands",
        seconds=seconds,
        returned=Return(
            index=last,
            time=history.steps[-1].loads.time,
            before=history.steps[better.index].total,
            found=better.found,
        ),
    )
