"""Advance from the loads of one time to those of the next, and the fall-backs if a solver fails."""

from dataclasses import dataclass, replace

import numpy as np

from staffa.backend.parallel import max_over_ranks
from staffa.errors import LoadError, PartedError, SolveError
from staffa.evolution.apply_loads import Loading, change_loads, put_on
from staffa.evolution.coupling import ThermalState
from staffa.evolution.energy_gaps import gap_at_start, gap_between_parts
from staffa.evolution.equilibrate import Loads, descend, raise_bounds, settle
from staffa.evolution.loose_parts import loose_part
from staffa.evolution.problem import Problem
from staffa.evolution.sliding import renew, rub
from staffa.evolution.snapshot import Snapshot, restore, snapshot
from staffa.evolution.system import System
from staffa.minimize.alternate import Watch, equilibrium
from staffa.model.fields import owned
from staffa.records.step import CANCELED, Curvature, Heat, Outcome, Return, SolverStatistics

# Loads that raise the energy on frozen cracks by so much make cracks appear by the dozen: a guess
# then pays. Where cracks grow, it led to more sweeps and worse minima (docs/performance.md).
SURGE = 1.5
# What round-off and the tolerances of the inner solvers can explain of the balance of energies and
# of a rise of the energy, and no more.
BALANCE_ALLOWED, RISE_ALLOWED = 1e-5, 1e-7
# A step may be cut in two, and its halves again, so often.
CUTS = 3


@dataclass(frozen=True, kw_only=True)
class Origin:
    """Time (s) at which a step, or its last part, begins, and the `thermal` state then."""

    time: float
    thermal: ThermalState


@dataclass(frozen=True, kw_only=True)
class Advance:
    """Step from the loads of one time to the next ones.

    Attributes
    ----------
    outcome : result of the minimization.
    healing : how far the damage sank below its bound.
    work, released : work of the loads on frozen cracks, and energy that the minimization released.
    imbalance : error of the energy balance over the energy.
    origin : start of the last part of the step.
    renewed : change of the energy by new normals and new friction of faces that touch.
    began : energy before; None after backtracking.
    gap : largest difference between the energies that one part ended and the next began with, over
        the energy.
    returned : how backtracking came here, if it did.
    heat : account of heat of the last part; None where the coupling keeps none.
    earlier : account of heat of the parts before it.
    curvature : second-order test of the state, if it was made.
    """

    outcome: Outcome
    healing: float
    work: float
    released: float
    imbalance: float
    origin: Origin
    renewed: float = 0.0
    began: float | None = None
    gap: float = 0.0
    returned: Return | None = None
    heat: Heat | None = None
    earlier: Heat | None = None
    curvature: Curvature | None = None

    @property
    def all_heat(self) -> Heat | None:
        """Heat balance of all parts of a step that was cut."""
        return _together(self.earlier, self.heat)

    def after(self, tried: SolverStatistics) -> "Advance":
        """Return the same with the solver statistics of earlier attempts added."""
        effort = tried + self.outcome.effort
        return replace(self, outcome=replace(self.outcome, effort=effort))

    def then(self, other: "Advance") -> "Advance":
        """Return this advance and the next as one step that was cut in two."""
        both = self.outcome.then(other.outcome)
        outcome = replace(
            both,
            reason=f"{both.reason}, in the second half of a step cut in two",
            effort=both.effort + SolverStatistics(halvings=1),
        )
        return Advance(
            outcome=outcome,
            healing=max(self.healing, other.healing),
            work=self.work + other.work,
            released=self.released + other.released,
            renewed=self.renewed + other.renewed,
            imbalance=max(self.imbalance, other.imbalance),
            began=self.began,
            gap=max(self.gap, other.gap, gap_between_parts(self.outcome, other.began)),
            heat=other.heat,
            earlier=_together(self.all_heat, other.earlier),
            origin=other.origin,
        )

    def again(
        self, outcome: Outcome, healing: float, loading: Loading, heat: Heat | None
    ) -> "Advance":
        """Return the same step after one more change of temperature and minimization.

        Parameters
        ----------
        outcome : outcome of that minimization.
        healing : its irreversibility violation.
        loading : the change of loads before it.
        heat : heat balance of the step.
        """
        heat, seconds = heat or Heat(), self.heat.seconds if self.heat else 0.0
        return replace(
            self,
            outcome=self.outcome.then(outcome),
            healing=max(self.healing, healing),
            work=self.work + loading.work,
            released=self.released + loading.end - outcome.energies.total,
            imbalance=max(self.imbalance, imbalance(loading, outcome)),
            gap=max(
                self.gap,
                gap_between_parts(self.outcome, loading.start),
                gap_at_start(loading, outcome),
            ),
            heat=replace(heat, seconds=heat.seconds + seconds),
        )


def _together(one: Heat | None, other: Heat | None) -> Heat | None:
    """Return the sum of two heat balances, or the one that is given."""
    return one.then(other) if one and other else one or other


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
    proposes = system.alternation.newton is not None or system.coarser is not None
    try:
        return _sound(problem, system, kept, start, end, watch)
    except LoadError:
        restore(system, kept)
        raise
    except SolveError as error:
        failure = error
        loose = loose_part(problem, system, solved=False)
        restore(system, kept)
        if loose is not None:
            raise PartedError(loose.sentence()) from error
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
    return agree(problem, system, end, advance, watch)


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


def imbalance(loading: Loading, outcome: Outcome) -> float:
    """Return the error of the energy balance on frozen cracks, over the energy."""
    scale = max(abs(loading.start), abs(loading.end), outcome.scale, CANCELED * loading.spread)
    return abs(loading.end - loading.start - loading.work) / scale


def agree(
    problem: Problem,
    system: System,
    end: Loads,
    advance: Advance,
    watch: Watch = lambda sweep: None,
) -> Advance:
    """Repeat the step's temperature with the cracks that it led to, and minimize again, until it no
    longer changes. Nothing is done where cracks do not change it. Collective.

    Cracks that a pass has made stay, as in time they would: otherwise cracks and temperatures come
    and go by turns, each the other's cause. They only grow then, and that ends.

    Raises
    ------
    SolveError
        They do not agree within the limit of passes: in too long a step cracks run ahead of
        the thermal boundary layer.
    """
    coupling, origin, T = system.coupling, advance.origin, system.state.T
    rule = coupling.agreement
    if rule is None:
        return advance
    passes, gap, spent = 0, np.inf, 0.0
    while advance.outcome.converged:
        thermal, heat = coupling.advance(origin.thermal, system.cracks, origin.time, end.time)
        apart = max_over_ranks(problem.domain.comm, np.abs(thermal.T[: len(owned(T))] - owned(T)))
        # Of the step, and not of its end alone, where the temperature may be the first one again.
        gap = apart / (max(coupling.span(origin.thermal), coupling.span(thermal)) or 1.0)
        if gap <= rule.tolerance:
            spent = heat.seconds if heat else 0.0
            break
        if passes == rule.passes:
            raise SolveError(
                f"the temperature and the cracks that change it still differ by {gap:.1g} of the "
                f"temperature's change after {passes} passes; take shorter time steps, or a larger "
                f"{rule.key}"
            )
        raise_bounds(problem.irreversibility, system)
        loading = put_on(problem, system, thermal, end.values, end)
        outcome, healing = descend(problem, system, end, watch)
        advance, passes = advance.again(outcome, healing, loading, heat), passes + 1
    kept = advance.heat or Heat()
    return replace(
        advance, heat=replace(kept, passes=passes, gap=gap, seconds=kept.seconds + spent)
    )
