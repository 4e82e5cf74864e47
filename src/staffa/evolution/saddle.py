"""Second-order test of a step: a saddle is left, and the lowest state beside it is kept."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from staffa.backend.parallel import max_over_ranks
from staffa.backend.vectors import readable, writable
from staffa.errors import SolveError
from staffa.evolution.advanced_step import Advance
from staffa.evolution.agree import agree
from staffa.evolution.equilibrate import Loads, descend
from staffa.evolution.problem import Problem, SecondOrder
from staffa.evolution.snapshot import copied, restore, snapshot
from staffa.evolution.system import System
from staffa.minimize.alternate import Watch, equilibrium
from staffa.minimize.bounded import AT_BOUND
from staffa.minimize.coupled import CoupledModel, destroy_pairs
from staffa.minimize.lanczos import Softest, softest
from staffa.minimize.newton import search
from staffa.model.fields import owned, read_vector, vertices, write_vector
from staffa.records.step import Curvature

# A gradient in the damage up to the first number, over Gc/(4 c_w ell), counts as zero; or up to the
# residual of the minimization, at most the second: with 1e-2 an intact bar broke at .995 of its
# strength.
BALANCED, LOOSEST = 1e-6, 1e-3
# Most iterations that turn a direction into one without a decrease of the damage.
TURNS = 16
# The most applications of the second derivative in a search; most searches end after 8 to 14.
ITERATIONS = 40
# Most saddles that are left in a step.
MOST = 10
# An energy lower by less than this fraction of it is not lower.
ROUND_OFF = 1e-10
# The damage of a state that is left is scattered by this fraction of itself, over these lengths (in
# ell). Uniform cracks that grow from the softest direction alone stop each other later, and end at
# energies some 5 % higher (`make verify ONLY=saddles`).
SCATTER, LENGTHS = 0.05, (2.0, 4.0)


# Displacement and damage, owned entries.
Direction = tuple[np.ndarray, np.ndarray]


def tested(
    problem: Problem,
    system: System,
    loads: Loads,
    advance: Advance,
    watch: Watch = lambda sweep: None,
) -> Advance:
    """Search a converged state for a direction along which the energy falls, and follow it.

    From a saddle the minimization starts three times: along that direction, and twice with
    scattered damage. The lowest result is kept and searched again. Collective.

    Parameters
    ----------
    problem : the problem.
    system : its system.
    loads : the current loads.
    advance : the step.
    watch : called after each sweep.
    """
    rule, model = problem.second_order, system.alternation.model
    if rule is None or model is None:
        why = (
            'solver.stability = "none"'
            if rule is None
            else "the volume of the fluid in cracks is given, which the test does not know of"
        )
        return replace(advance, curvature=Curvature(reason=f"not tested: {why}"))
    kept = copied(system)
    try:
        return _searched(problem, rule, system, model, loads, advance, watch)
    except SolveError as error:
        restore(system, kept)
        return replace(advance, curvature=Curvature(reason=f"not tested: {error}"))


def _searched(
    problem: Problem,
    rule: SecondOrder,
    system: System,
    model: CoupledModel,
    loads: Loads,
    advance: Advance,
    watch: Watch,
) -> Advance:
    """Search, leave, and search again, until nothing is found or gained. Collective."""
    for escapes in range(MOST + 1):
        slack = min(max(BALANCED, advance.outcome.residual), LOOSEST)
        way = _softest(problem, system, model, rule.tolerance, slack)
        found = Curvature(
            smallest=None if way is None else way.value,
            iterations=0 if way is None else way.iterations,
            escapes=escapes,
        )
        if way is None or not len(way.b):
            return replace(advance, curvature=found)
        falling = _falling(system, model, loads, way)
        if falling is None:
            reason = "a bifurcation: no damage within its bounds was found to lower the energy"
            return replace(advance, curvature=replace(found, bifurcation=True, reason=reason))
        if escapes == MOST:
            reason = f"left {escapes} times, and each time for another saddle"
            return replace(advance, curvature=replace(found, reason=reason))
        advance, reason = _left(problem, system, loads, advance, falling, watch)
        if reason:
            return replace(advance, curvature=replace(found, reason=reason))
    raise AssertionError


def _softest(
    problem: Problem, system: System, model: CoupledModel, tolerance: float, slack: float
) -> Softest | None:
    """Search from a random start that depends on position alone. Collective.

    `slack` is the gradient, over its scale, up to which a bound does not block.
    """
    parts, bounds = system.alternation, system.bounds
    read_vector(system.state.alpha, parts.alpha)
    start = model.pair()
    try:
        lower, upper = bounds.lower.x.petsc_vec, bounds.upper.x.petsc_vec
        model.move_to(parts.alpha, lower, upper, start, slack=slack)
        force_u, force_alpha = start.getNestSubVecs()
        force_u.set(0.0)
        writable(force_alpha)[:] = _scattered(problem, system) * readable(parts.damage.unit)
        writable(force_alpha)[model.held] = 0.0
        return softest(model, start, iterations=ITERATIONS, tolerance=tolerance)
    finally:
        destroy_pairs(start)


def _scattered(problem: Problem, system: System) -> np.ndarray:
    """Return pseudorandom numbers in [-1, 1] at owned vertices, a function of position alone."""
    x = vertices(system.state.alpha.function_space)[: len(owned(system.state.alpha))]
    waves = 43758.5453 * np.sin(x / problem.domain.h @ np.array([12.9898, 78.233, 37.719]))
    return np.asarray(2 * (waves - np.floor(waves)) - 1)


def _left(
    problem: Problem,
    system: System,
    loads: Loads,
    advance: Advance,
    falling: Direction,
    watch: Watch,
) -> tuple[Advance, str]:
    """Minimize from several starts beside this state, and keep the lowest result. Collective.

    Returns
    -------
    The advance, with the work of all starts recorded, and the reason if the state was kept.
    """
    kept, before = snapshot(system), advance.outcome.energies
    spent, ends = advance.outcome, []
    starts: list[Callable[[], object]] = [partial(go_along, system, *falling)]
    starts += [partial(_scatter, problem, system, length) for length in LENGTHS]
    reasons = []
    for start in starts:
        restore(system, kept)
        try:
            start()
            equilibrium(system.alternation, loads.values)
            outcome, healing = descend(problem, system, loads, watch)
        except SolveError as error:
            reasons.append(str(error))
            continue
        spent = replace(
            spent,
            sweeps=spent.sweeps + outcome.sweeps,
            effort=spent.effort + outcome.effort,
        )
        if not outcome.converged:
            reasons.append(outcome.reason)
        elif outcome.energies.total < before.total - ROUND_OFF * before.scale:
            ends.append((outcome, healing, snapshot(system)))
    stays = replace(advance, outcome=spent)
    if ends:
        outcome, healing, reached = min(ends, key=lambda end: end[0].energies.total)
        restore(system, reached)
        left = replace(
            advance,
            outcome=replace(
                outcome,
                reason=f"{outcome.reason}, after a saddle was left",
                sweeps=spent.sweeps,
                effort=spent.effort,
                largest_rise=max(advance.outcome.largest_rise, outcome.largest_rise),
                before=spent.before,
            ),
            healing=max(advance.healing, healing),
            released=advance.released + before.total - outcome.energies.total,
        )
        try:
            equilibrium(system.alternation, loads.values)
            agreed = agree(problem, system, loads, left, watch)
            if agreed.outcome.converged:
                return agreed, ""
            reasons.append(agreed.outcome.reason)
        except SolveError as error:
            reasons.append(str(error))
    restore(system, kept)
    return stays, "; ".join(["no start beside it led to a lower state", *reasons])


def _falling(system: System, model: CoupledModel, loads: Loads, way: Softest) -> Direction | None:
    """Return a direction within the bounds along which the energy falls; the state is unchanged.

    It starts with the softest direction, with its negative, and with its absolute value. A decrease
    of damage at a bound is cut off. Sweeps of the linearized alternate minimization, each cut off
    likewise, turn it towards the softest admissible rate. Collective.
    """
    bounds, alpha = system.bounds, owned(system.state.alpha)
    at_lower = alpha <= owned(bounds.lower) + AT_BOUND
    at_upper = alpha >= owned(bounds.upper) - AT_BOUND
    comm = system.energy.comm

    def admissible(b: np.ndarray) -> np.ndarray:
        b = np.where(at_lower, np.maximum(b, 0.0), b)
        return np.where(at_upper, np.minimum(b, 0.0), b)

    kept = snapshot(system)
    equilibrium(system.alternation, loads.values)  # also solves for the modes of a section
    try:
        for start in (way.b, -way.b, np.abs(way.b)):
            b = admissible(start)
            for _ in range(TURNS):
                largest = max_over_ranks(comm, np.abs(b))
                if not largest > 0:
                    break
                b = b / largest
                v = model.following(b)
                turned, curvature = model.swept(v, b)
                if curvature < 0 and go_along(system, v, b):
                    return v, b
                b = admissible(turned)
        return None
    finally:
        restore(system, kept)


def _scatter(problem: Problem, system: System, length: float) -> None:
    """Scatter the damage by a random field of position alone, within its bounds.

    Parameters
    ----------
    problem : the problem.
    system : its system.
    length : correlation length of the field, in ell.
    """
    import gstools  # takes a second to load, and few runs need it

    alpha, bounds, parts = owned(system.state.alpha), system.bounds, system.alternation
    x = vertices(system.state.alpha.function_space)[: len(alpha)] / problem.material.ell
    field = gstools.SRF(gstools.Gaussian(dim=problem.domain.dim, len_scale=length), seed=0)
    waves = field(tuple(x.T[: problem.domain.dim]), store=False) if len(x) else np.zeros(0)
    moved = alpha * (1 + SCATTER * waves)
    writable(parts.alpha)[:] = np.clip(moved, owned(bounds.lower), owned(bounds.upper))
    write_vector(parts.alpha, system.state.alpha)


def go_along(system: System, v: np.ndarray, b: np.ndarray) -> bool:
    """Move along a direction within the bounds as far as the energy falls; False if it does not.

    Collective.

    Parameters
    ----------
    system : the system.
    v, b : displacement and damage of the direction, owned entries.
    """
    parts, state, bounds = system.alternation, system.state, system.bounds
    u, alpha = owned(state.u).copy(), owned(state.alpha).copy()
    lower, upper = owned(bounds.lower), owned(bounds.upper)
    total = system.energy.total()

    def energy_at(t: float) -> float:
        writable(parts.u)[:] = u + t * v
        writable(parts.alpha)[:] = np.clip(alpha + t * b, lower, upper)
        write_vector(parts.u, state.u)
        write_vector(parts.alpha, state.alpha)
        return system.energy.total()

    taken, _ = search(energy_at, total - ROUND_OFF * abs(total))
    return taken > 0
