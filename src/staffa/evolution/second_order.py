"""Second-order conditions after a step: stability, uniqueness, and a way out of a saddle."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from staffa.backend.vectors import readable
from staffa.errors import SolveError
from staffa.evolution.advanced_step import Advance
from staffa.evolution.agree import agree
from staffa.evolution.equilibrate import Loads, descend
from staffa.evolution.problem import Problem, SecondOrder
from staffa.evolution.resolution import TooCoarseError
from staffa.evolution.saddle import MOST, go_along, tested
from staffa.evolution.snapshot import copied, restore, snapshot
from staffa.evolution.system import System
from staffa.minimize.alternate import Watch, equilibrium
from staffa.minimize.stability import Mode, SecondVariation
from staffa.model.fields import owned, read_vector
from staffa.records.step import Stability

# A gradient in the damage up to this, over Gc/(4 c_w ell), counts as zero.
BALANCED = 1e-2


def examine(
    problem: Problem,
    system: System,
    loads: Loads,
    advance: Advance,
    watch: Watch = lambda sweep: None,
) -> tuple[Advance, Stability | None]:
    """Find the second order of a converged state, and leave it if that is asked for. Collective.

    If it cannot be found, the state stays the last that converged, and the record has the reason.
    Where cells are too coarse for what leads away from it, it is the state that the search began
    with: the search is repeated on finer cells.

    Parameters
    ----------
    problem : the problem.
    system : its system.
    loads : the current loads.
    advance : the step.
    watch : called after each sweep.

    Raises
    ------
    TooCoarseError
        Cells must be split.
    """
    if not advance.outcome.converged:
        return advance, None
    kept = copied(system)
    try:
        return _examined(problem, system, loads, advance, watch)
    except TooCoarseError:
        restore(system, kept)
        raise


def _examined(
    problem: Problem, system: System, loads: Loads, advance: Advance, watch: Watch
) -> tuple[Advance, Stability | None]:
    """Do the same as `examine`; where cells are too coarse, the state is one on the way."""
    rule = problem.second_order
    if rule is None or rule.kind == "test":
        return tested(problem, system, loads, advance, watch), None
    if system.alternation.held:
        return advance, Stability(
            bifurcation=None,
            stability=None,
            negative=0,
            failure="it does not know of a prescribed volume",
        )
    kept, found = snapshot(system), None
    try:
        for state in _escapes(problem, rule, system, loads, advance, watch):
            (advance, found), kept = state, snapshot(system)
    except SolveError as error:
        restore(system, kept)
        found = found or Stability(bifurcation=None, stability=None, negative=0)
        found = replace(found, failure=str(error))
    return advance, found


def _escapes(
    problem: Problem,
    rule: SecondOrder,
    system: System,
    loads: Loads,
    advance: Advance,
    watch: Watch,
) -> Iterator[tuple[Advance, Stability]]:
    """Yield the converged state and its second order, and those of the states that follow it."""
    for escapes in range(MOST + 1):
        space, cone = modes(system)
        found = Stability(
            bifurcation=None if space is None else space.value,
            stability=None if cone is None else cone.value,
            negative=0 if space is None else space.negative,
            escapes=escapes,
        )
        yield advance, found
        way = _way_out(rule, space, cone)
        if way is None or escapes == MOST:
            return
        kept = snapshot(system)
        if not (go_along(system, way.v, way.b) or go_along(system, -way.v, -way.b)):
            restore(system, kept)
            return
        equilibrium(system.alternation, loads.values)
        outcome, healing = descend(problem, system, loads, watch)
        gained = advance.outcome.energies.total - outcome.energies.total
        advance = replace(
            advance,
            outcome=advance.outcome.then(outcome),
            healing=max(advance.healing, healing),
            released=advance.released + gained,
        )
        advance = agree(problem, system, loads, advance, watch)
        if not advance.outcome.converged:
            yield advance, found
            return


def modes(system: System) -> tuple[Mode | None, Mode | None]:
    """Return the modes of the smallest second variation in the space V and in the cone.

    The first is None if no damage is free. The second, in the cone of admissible rates, is None if
    the first is not negative: the cone is a part of V, so that the state is stable, and it is
    costly. Damage is free if it has left its bound, or if no gradient holds it there. Collective.
    """
    parts, energy, bounds = system.alternation, system.energy, system.bounds
    read_vector(system.state.alpha, parts.alpha)
    parts.damage.move_to(parts.alpha)
    parts.damage.gradient(parts.work)
    alpha = readable(parts.alpha)
    balanced = np.abs(readable(parts.work)) <= BALANCED * readable(parts.damage.unit)
    between = (alpha > owned(bounds.lower) + 1e-8) & (alpha < owned(bounds.upper) - 1e-8)
    matrices = energy.new_stiffness(), energy.new_mixed(), energy.new_hessian()
    for fill, matrix in zip(
        (energy.stiffness, energy.mixed, energy.hessian), matrices, strict=True
    ):
        fill(matrix)
    K, C, H = matrices
    variation = SecondVariation(
        stiffness=K,
        mixed=C,
        hessian=H,
        mass=parts.damage.unit,
        fixed=system.supports.fixed,
        moved=system.supports.moved,
        modes=system.supports.modes,
        free=balanced | between,
    )
    for matrix in matrices:
        matrix.destroy()
    try:
        if not variation.size:
            return None, None
        space = variation.on_the_space()
        return space, variation.on_the_cone(space) if space.value < 0 else None
    finally:
        variation.destroy()


def _way_out(rule: SecondOrder, space: Mode | None, cone: Mode | None) -> Mode | None:
    """Return the mode to follow: of lost stability, or else of bifurcation."""
    if rule.kind != "follow":
        return None
    return next((m for m in (cone, space) if m and m.value < -rule.tolerance), None)
