"""From the loads of one time to those of the next, and what is tried when a solver fails."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from staffa.errors import LoadError, SolveError
from staffa.evolution.problem import Problem
from staffa.evolution.settle import Loads, settle, temperature
from staffa.evolution.system import System
from staffa.fields import read_vector
from staffa.minimize.alternate import Sweep, equilibrium, reactions
from staffa.parallel import any_over_ranks, sum_over_ranks
from staffa.records import Effort, Outcome, Return

# Loads that raise the energy on frozen cracks by so much make cracks appear by the dozen: a guess
# then pays. Where cracks grow, it led to more sweeps and worse minima (docs/performance.md).
SURGE = 1.5
# A step may be cut in two, and its halves again, so often.
CUTS = 3


@dataclass(frozen=True, kw_only=True)
class Loading:
    """What changing the loads did with the cracks frozen.

    work: of the temperature change and of the prescribed displacements, both along the straight
    path from the loads before; exact for elasticity. start, end: total energies.
    """

    work: float
    start: float
    end: float


@dataclass(frozen=True, kw_only=True)
class Advance:
    """How the next loads were reached.

    healing: how far the damage sank below its bound. work, released: by the loads on frozen cracks,
    and by the minimization. imbalance: error of the energy balance over the energy. returned: how
    backtracking came here, if it did.
    """

    outcome: Outcome
    healing: float
    work: float
    released: float
    imbalance: float
    returned: Return | None = None

    def after(self, tried: Effort) -> "Advance":
        """The same, with what was tried before it on record."""
        effort = tried + self.outcome.effort
        return replace(self, outcome=replace(self.outcome, effort=effort))

    def then(self, other: "Advance") -> "Advance":
        """This one and the next, as one step that was cut in two."""
        last = other.outcome
        outcome = replace(
            last,
            reason=f"{last.reason}, in the second half of a step cut in two",
            sweeps=self.outcome.sweeps + last.sweeps,
            largest_rise=max(self.outcome.largest_rise, last.largest_rise),
            effort=self.outcome.effort + last.effort + Effort(halvings=1),
        )
        return Advance(
            outcome=outcome,
            healing=max(self.healing, other.healing),
            work=self.work + other.work,
            released=self.released + other.released,
            imbalance=max(self.imbalance, other.imbalance),
        )


def advance_to(
    problem: Problem,
    system: System,
    start: Loads,
    end: Loads,
    watch: Callable[[Sweep], None] = lambda sweep: None,
    cuts: int = CUTS,
) -> Advance:
    """Put on the loads and minimize; if a solver fails, without proposals, then in two half steps.

    Only a failure is tried again: running out of sweeps is what the user set as the limit. Of what
    failed, the record counts that it did (`plain`, `halvings`), not what it had done till then.

    Raises
    ------
    SolveError
        All of it failed; the state is the one at the start again.
    """
    kept = snapshot(system)
    proposes = system.alternation.newton is not None or system.coarser is not None
    try:
        return _advance(problem, system, start, end, watch)
    except LoadError:
        raise
    except SolveError as error:
        failure = error
        restore(system, kept)
    if proposes:
        plain = replace(system, alternation=replace(system.alternation, newton=None), coarser=None)
        try:
            return _advance(problem, plain, start, end, watch).after(Effort(plain=1))
        except SolveError as error:
            failure = error
            restore(system, kept)
    if not cuts:
        raise failure
    tried = Effort(plain=1 if proposes else 0)
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


def _advance(
    problem: Problem, system: System, start: Loads, end: Loads, watch: Callable[[Sweep], None]
) -> Advance:
    loading = change_loads(problem, system, start, end)
    overwhelmed = loading.end > SURGE * loading.start
    outcome, healing = settle(problem, system, end, watch, guess=overwhelmed)
    total = outcome.energies.total
    scale = max(abs(loading.start), abs(loading.end), abs(total), 1e-300)
    return Advance(
        outcome=outcome,
        healing=healing,
        work=loading.work,
        released=loading.end - total,
        imbalance=abs(loading.end - loading.start - loading.work) / scale,
    )


def change_loads(problem: Problem, system: System, start: Loads, end: Loads) -> Loading:
    """Put on the loads of a time with the cracks frozen, and account for the work. Collective.

    Raises
    ------
    LoadError
        The temperature or a prescribed displacement is not finite.
    """
    energy, state, parts = system.energy, system.state, system.alternation
    T = temperature(problem, system, end.time)
    if any_over_ranks(problem.domain.comm, not np.all(np.isfinite(T))):
        raise _not_finite("temperature", end.time)
    if any_over_ranks(problem.domain.comm, not np.all(np.isfinite(end.values))):
        raise _not_finite("displacement", end.time)

    def power() -> float:
        of_supports = float(reactions(parts) @ (end.values - start.values))
        return energy.thermal_power() + sum_over_ranks(problem.domain.comm, of_supports)

    energy.direction.x.array[:] = T - state.T.x.array
    before, power_before = energy.total(), power()
    state.T.x.array[:] = T
    equilibrium(parts, end.values)
    return Loading(work=(power_before + power()) / 2, start=before, end=energy.total())


def _not_finite(what: str, time: float) -> LoadError:
    return LoadError(
        f"the load gives a {what} that is not finite at time {time:.6g}; mend the load"
    )


def snapshot(system: System) -> tuple[np.ndarray, ...]:
    """A copy of the state and of the damage's lower bound, for `restore`."""
    state = system.state
    fields = (state.u, state.alpha, state.T, system.bounds.lower)
    return tuple(field.x.array.copy() for field in fields)


def restore(system: System, kept: tuple[np.ndarray, ...]) -> None:
    """Put back what `snapshot` kept."""
    state, parts = system.state, system.alternation
    fields = (state.u, state.alpha, state.T, system.bounds.lower)
    for field, values in zip(fields, kept, strict=True):
        field.x.array[:] = values
    read_vector(state.u, parts.u)
    read_vector(state.alpha, parts.alpha)
