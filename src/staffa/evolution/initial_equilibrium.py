"""Initial equilibrium under prestress, weight and loads of t = 0, without a new crack."""

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np

from staffa.backend.parallel import best_candidate
from staffa.errors import LoadError, SolveError
from staffa.evolution.equilibrate import Loads, settle
from staffa.evolution.loose_parts import require_whole
from staffa.evolution.problem import Problem
from staffa.evolution.snapshot import snapshot
from staffa.evolution.system import System
from staffa.measure.growth import crack_advance
from staffa.minimize.alternate import Watch, equilibrium
from staffa.model.fields import vertices
from staffa.physics.damage import damage_at_strength

# Half width (in ell) of the damage beside a crack, which forms beside initial cracks.
PROFILE = 2.0
# Damage beyond that of the strength by this amount is a crack that has started.
MARGIN = 0.05


def unmoved(system: System) -> Loads:
    """Return the loads before the first step: t = 0, no prescribed displacement."""
    return Loads(time=0.0, values=np.zeros(len(system.supports.fixed)))


def come_to_rest(problem: Problem, system: System, watch: Watch = lambda sweep: None) -> None:
    """Apply the forces of t = 0, and minimize. Collective.

    Parameters
    ----------
    problem : the problem.
    system : its system.
    watch : called after each sweep.

    Raises
    ------
    PartedError
        Initial cracks separate a part from its supports.
    LoadError
        The loads crack the rock by themselves, or extend the initial cracks.
    SolveError
        No minimum was found.
    """
    start, faces = unmoved(system), system.energy.faces
    if faces:
        faces.turn()
    equilibrium(system.alternation, start.values)
    if problem.forces.at_rest:
        return
    before = snapshot(system).alpha
    outcome, _ = settle(problem, system, start, watch)
    if not outcome.converged:
        raise SolveError(f"the equilibrium before the first step {outcome.reason}")
    require_whole(problem, system)
    if faces and faces.rubs:
        faces.stick()
        faces.forget_work()
    system.energy.count_from_here()
    failing = damage_at_strength(problem.material.law) + MARGIN
    ran = crack_advance(system.state, before, threshold=failing)
    if ran > PROFILE * problem.material.ell:
        place = ", ".join(f"{c:.3g}" for c in _most_damaged(problem, system, before))
        raise LoadError(
            f"what acts before cooling cracks the rock by itself, most at ({place}); take smaller "
            f"forces or stresses in [forces], supports that carry them, another damage.split, or a "
            f"smaller damage.ell (a higher strength)"
        )


def _most_damaged(problem: Problem, system: System, before: np.ndarray) -> tuple[float, ...]:
    """Return the position at which the damage grew most (m)."""
    state = system.state
    space = state.alpha.function_space
    n_owned = space.dofmap.index_map.size_local
    growth = (state.alpha.x.array - before)[:n_owned]
    own = None
    if len(growth):
        k = int(growth.argmax())
        own = (float(growth[k]), *(float(c) for c in vertices(space)[k]))
    best = best_candidate(problem.domain.comm, own)
    assert best is not None
    return best[1 : 1 + problem.domain.dim]
