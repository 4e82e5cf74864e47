"""Advance from the loads of one time to those of the next, and the fall-backs if a solver fails."""

from dataclasses import replace

from staffa.errors import LoadError, PartedError, SolveError
from staffa.evolution.advanced_step import Advance, Origin, imbalance
from staffa.evolution.agree import agree
from staffa.evolution.apply_loads import Loading, change_loads
from staffa.evolution.energy_gaps import gap_at_start
from staffa.evolution.equilibrate import Loads, descend, settle
from staffa.evolution.loose_parts import loose_part
from staffa.evolution.problem import Problem
from staffa.evolution.sliding import renew, rub
from staffa.evolution.snapshot import Snapshot, restore, snapshot
from staffa.evolution.system import System
from staffa.minimize.alternate import Watch, equilibrium
from staffa.records.step import SolverStatistics

# Loads that raise the energy on frozen cracks by so much make cracks appear by the dozen: a guess
# then pays. Where cracks grow, it led to more sweeps and worse minima (docs/performance.md).
SURGE = 1.5
# What round-off and the tolerances of the inner solvers can explain of the balance of energies and
# of a rise of the energy, and no more.
BALANCE_ALLOWED, RISE_ALLOWED = 1e-5, 1e-7
# A step may be cut in two, and its halves again, so often.
CUTS = 3


def advance_to(
    problem: Problem,
    system: System,
    start: Loads,
    end: Loads,
    watch: Watch = lambda sweep: None,
    cuts: int = CUTS,
) -> Advance:
    """Apply the loads and minimize; after a failure without proposals, then in two half steps.

    Only a failure is tried again: the largest number of sweeps is a limit of the user. The record
    counts a failure (`plain`, `halvings`), but not the work before it.

    Parameters
    ----------
    problem : the problem.
    system : its system.
    start : loads before the step.
    end : loads after it.
    watch : called after each sweep.
    cuts : how often the step may be cut in two.

    Raises
    ------
    PartedError
        A solver failed because a part has come loose: there is no equilibrium.
    SolveError
        All of it failed; the state is the one at the start again.
    """
    kept = snapshot(system)
    guesses = system.coarser is not None or system.tried is not None
    proposes = guesses or system.alternation.newton is not None
    try:
        return _sound(problem, system, kept, start, end, watch)
    except LoadError:
        restore(system, kept)
        raise
    except SolveError as error:
        failure = error
        system.require_fine()  # on a finer mesh it may not fail
        loose = loose_part(problem, system, solved=False)
        restore(system, kept)
        if loose is not None:
            raise PartedError(loose.sentence()) from error
    system = replace(system, tried=None)
    if proposes:
        plain = replace(system, alternation=replace(system.alternation, newton=None), coarser=None)
        try:
            return _sound(problem, plain, kept, start, end, watch).after(SolverStatistics(plain=1))
        except SolveError as error:
            failure = error
            restore(system, kept)
    if not cuts:
        raise failure
    tried = SolverStatistics(plain=1 if proposes else 0)
    time = (start.time + end.time) / 2
    middle = Loads(time=time, values=system.supports.values(time))
    try:
        first = advance_to(problem, system, start, middle, watch, cuts - 1)
        if not first.outcome.converged:
            raise SolveError(f"the first half of the step {first.outcome.reason}")
        whole = first.then(advance_to(problem, system, middle, end, watch, cuts - 1))
    except SolveError:
        restore(system, kept)
        raise failure from None
    return whole.after(tried)


def _sound(
    problem: Problem,
    system: System,
    kept: Snapshot,
    start: Loads,
    end: Loads,
    watch: Watch,
) -> Advance:
    """Take the step; take it again with a factorization if an iterative solver was too inexact."""
    advance, elastic = _advance(problem, system, start, end, watch), system.alternation.elastic
    rise = advance.outcome.largest_rise
    if elastic.linear.direct or (advance.imbalance <= BALANCE_ALLOWED and rise <= RISE_ALLOWED):
        return advance
    restore(system, kept)
    elastic.linear.take_over()
    return _advance(problem, system, start, end, watch)


def _advance(problem: Problem, system: System, start: Loads, end: Loads, watch: Watch) -> Advance:
    origin = Origin(time=start.time, thermal=system.thermal.read())
    renewed = renew(system, start)
    loading = change_loads(problem, system, start, end)
    system.require_fine()
    overwhelmed = loading.end - loading.start > (SURGE - 1) * abs(loading.start)
    rubbed, slid = _slide(system, end, loading)
    outcome, healing = settle(problem, system, end, watch, guess=overwhelmed)
    advance = Advance(
        outcome=outcome,
        healing=healing,
        work=loading.work,
        released=loading.end + rubbed - outcome.energies.total,
        renewed=renewed + rubbed,
        imbalance=imbalance(loading, outcome),
        began=loading.start - renewed,
        gap=gap_at_start(slid, outcome),
        heat=loading.heat,
        origin=origin,
    )
    advance = rubbing(problem, system, end, advance, watch)
    advance = agree(problem, system, end, advance, watch)
    system.require_fine()
    return advance


def _slide(system: System, end: Loads, loading: Loading) -> tuple[float, Loading]:
    """Let faces slide on frozen cracks; return the energy change by new friction, and the end."""
    if system.energy.faces is None or not system.energy.faces.rubs:
        return 0.0, loading

    def minimize() -> bool:
        equilibrium(system.alternation, end.values)
        return True

    return rub(system, minimize), replace(loading, end=system.energy.total())


def rubbing(
    problem: Problem,
    system: System,
    end: Loads,
    advance: Advance,
    watch: Watch = lambda sweep: None,
) -> Advance:
    """Minimize again with the friction of the new pressure, until both agree. Collective.

    Parameters
    ----------
    problem : the problem.
    system : its system.
    end : the current loads.
    advance : the step so far.
    watch : called after each sweep.
    """
    found = [advance]

    def minimize() -> bool:
        equilibrium(system.alternation, end.values)
        outcome, healing = descend(problem, system, end, watch)
        last = found[-1]
        found.append(
            replace(last, outcome=last.outcome.then(outcome), healing=max(last.healing, healing))
        )
        return outcome.converged

    renewed, last = rub(system, minimize), found[-1]
    freed = advance.outcome.energies.total - last.outcome.energies.total
    return replace(
        last,
        released=advance.released + renewed + freed,
        renewed=advance.renewed + renewed,
    )
