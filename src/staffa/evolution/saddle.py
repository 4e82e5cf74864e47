"""The second-order test of a step: a saddle is left, and the lowest state beside it kept."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from staffa.errors import SolveError
from staffa.evolution.advance import Advance, agree, restore, snapshot
from staffa.evolution.problem import Problem
from staffa.evolution.settle import Loads, descend
from staffa.evolution.system import System
from staffa.fields import owned, read_vector, vertices, write_vector
from staffa.minimize.alternate import Watch, equilibrium
from staffa.minimize.bounded import AT_BOUND
from staffa.minimize.coupled import CoupledModel, destroy_pairs
from staffa.minimize.lanczos import Softest, softest
from staffa.minimize.newton import search
from staffa.records import Curvature

# A force on the damage this small, over Gc/(4 c_w ell), counts as none: with 1e-2 a sound bar broke
# at .995 of its strength.
BALANCED = 1e-6
# The most applications of the second derivative in a search; most searches end after 8 to 14.
ITERATIONS = 40
# A state is left so often in a step.
MOST = 10
# An energy lower by less than this fraction of it is not lower.
ROUND_OFF = 1e-10
# The damage of a state that is left is scattered by this fraction of itself, over lengths of so
# many ell. Even cracks that grow from the softest direction alone stop each other later, and end at
# energies some 5 % higher (`make verify ONLY=saddles`).
SCATTER, LENGTHS = 0.05, (2.0, 4.0)


def tested(
    problem: Problem,
    system: System,
    loads: Loads,
    advance: Advance,
    watch: Watch = lambda sweep: None,
) -> Advance:
    """Search a converged state for a direction along which the energy falls, and follow it.

    From a state that is left the minimization goes on from three starts: along that direction, and
    twice with the damage scattered. The lowest end is kept and searched again. Collective.
    """
    rule, model = problem.second_order, system.alternation.model
    if rule is None or model is None:
        why = (
            'solver.stability = "none"'
            if rule is None
            else "the volume of the fluid in cracks is given, which the test does not know of"
        )
        return replace(advance, curvature=Curvature(reason=f"not tested: {why}"))
    for escapes in range(MOST + 1):
        way = _softest(problem, system, model, rule.tolerance)
        found = Curvature(
            smallest=None if way is None else way.value,
            iterations=0 if way is None else way.iterations,
            escapes=escapes,
        )
        if way is None or not len(way.b):
            return replace(advance, curvature=found)
        if not _falls(system, way):
            reason = "a bifurcation: within its bounds no damage lowers the energy along it"
            return replace(advance, curvature=replace(found, bifurcation=True, reason=reason))
        left = _left(problem, system, loads, advance, way, watch) if escapes < MOST else None
        if left is None:
            reason = f"left {escapes} times, and no start beside it led to a lower state"
            return replace(advance, curvature=replace(found, reason=reason))
        advance = left
    raise AssertionError


def _softest(
    problem: Problem, system: System, model: CoupledModel, tolerance: float
) -> Softest | None:
    """Search from a random start that depends on position alone. Collective."""
    parts, bounds = system.alternation, system.bounds
    read_vector(system.state.alpha, parts.alpha)
    start = model.pair()
    try:
        lower, upper = bounds.lower.x.petsc_vec, bounds.upper.x.petsc_vec
        model.move_to(parts.alpha, lower, upper, start, slack=BALANCED)
        force_u, force_alpha = start.getNestSubVecs()
        force_u.set(0.0)
        force_alpha.array_w[:] = _scattered(problem, system) * parts.damage.unit.array_r
        force_alpha.array_w[model.held] = 0.0
        return softest(model, start, iterations=ITERATIONS, tolerance=tolerance)
    finally:
        destroy_pairs(start)


def _scattered(problem: Problem, system: System) -> np.ndarray:
    """Numbers between -1 and 1 at owned vertices that look random, a function of position alone."""
    x = vertices(system.state.alpha.function_space)[: len(owned(system.state.alpha))]
    waves = 43758.5453 * np.sin(x / problem.domain.h @ np.array([12.9898, 78.233, 37.719]))
    return 2 * (waves - np.floor(waves)) - 1


def _left(
    problem: Problem,
    system: System,
    loads: Loads,
    advance: Advance,
    way: Softest,
    watch: Watch,
) -> Advance | None:
    """Go on from some starts beside this state to the lowest end, if one is lower. Collective."""
    kept, before = snapshot(system), advance.outcome.energies.total
    ends = []
    starts: list[Callable[[], object]] = [partial(_go, system, way)]
    starts += [partial(_scatter, problem, system, length) for length in LENGTHS]
    for start in starts:
        restore(system, kept)
        start()
        try:
            equilibrium(system.alternation, loads.values)
            outcome, healing = descend(problem, system, loads, watch)
        except SolveError:
            continue
        advance = replace(advance, outcome=advance.outcome.then(outcome))
        if outcome.converged and outcome.energies.total < before:
            ends.append((outcome, healing, snapshot(system)))
    if not ends:
        restore(system, kept)
        return None
    outcome, healing, reached = min(ends, key=lambda end: end[0].energies.total)
    restore(system, reached)
    spent = advance.outcome
    left = replace(
        advance,
        outcome=replace(
            outcome,
            reason=f"{outcome.reason}, after a saddle was left",
            sweeps=spent.sweeps,
            effort=spent.effort,
            largest_rise=spent.largest_rise,
            before=spent.before,
        ),
        healing=max(advance.healing, healing),
        released=advance.released + before - outcome.energies.total,
    )
    try:
        equilibrium(system.alternation, loads.values)
        return agree(problem, system, loads, left, watch)
    except SolveError:
        restore(system, kept)
        return None


def _falls(system: System, way: Softest) -> bool:
    """True if the energy falls along a direction; the state stays. Collective."""
    kept = snapshot(system)
    falls = _go(system, way)
    restore(system, kept)
    return falls


def _go(system: System, way: Softest) -> bool:
    """Go along a direction, either way, within the bounds and as far as the energy falls.

    Damage that lies on a bound moves off it alone, and the displacement follows the damage.
    """
    bounds, alpha, model = system.bounds, owned(system.state.alpha), system.alternation.model
    at_lower = alpha <= owned(bounds.lower) + AT_BOUND
    at_upper = alpha >= owned(bounds.upper) - AT_BOUND
    assert model is not None
    for sign in (1.0, -1.0):
        b = np.where(at_lower, np.maximum(sign * way.b, 0.0), sign * way.b)
        b = np.where(at_upper, np.minimum(b, 0.0), b)
        if go_along(system, model.following(b), b):
            return True
    return False


def _scatter(problem: Problem, system: System, length: float) -> None:
    """Scatter the damage by a random field of position alone, within its bounds.

    Parameters
    ----------
    length : over which the field is correlated, in ell.
    """
    import gstools  # takes a second to load, and few runs need it

    alpha, bounds, parts = owned(system.state.alpha), system.bounds, system.alternation
    x = vertices(system.state.alpha.function_space)[: len(alpha)] / problem.material.ell
    field = gstools.SRF(gstools.Gaussian(dim=problem.domain.dim, len_scale=length), seed=0)
    waves = field(tuple(x.T[: problem.domain.dim]), store=False) if len(x) else np.zeros(0)
    moved = alpha * (1 + SCATTER * waves)
    parts.alpha.array_w[:] = np.clip(moved, owned(bounds.lower), owned(bounds.upper))
    write_vector(parts.alpha, system.state.alpha)


def go_along(system: System, v: np.ndarray, b: np.ndarray) -> bool:
    """Go along a direction within the bounds as far as the energy falls; False if it does not.

    Parameters
    ----------
    v, b : displacement and damage of the direction, owned entries. Collective.
    """
    parts, state, bounds = system.alternation, system.state, system.bounds
    u, alpha = owned(state.u).copy(), owned(state.alpha).copy()
    lower, upper = owned(bounds.lower), owned(bounds.upper)
    total = system.energy.total()

    def energy_at(t: float) -> float:
        parts.u.array_w[:] = u + t * v
        parts.alpha.array_w[:] = np.clip(alpha + t * b, lower, upper)
        write_vector(parts.u, state.u)
        write_vector(parts.alpha, state.alpha)
        return system.energy.total()

    taken, _ = search(energy_at, total - ROUND_OFF * abs(total))
    return taken > 0
