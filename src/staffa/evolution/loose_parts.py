"""Loose parts of the body, which cracks separate from all supports, and their loads."""

from dataclasses import dataclass

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
from dolfinx import fem
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from staffa.backend.parallel import everywhere, max_over_ranks, sum_over_ranks
from staffa.backend.vectors import readable, writable
from staffa.errors import PartedError, SolveError
from staffa.evolution.problem import Problem
from staffa.evolution.system import System
from staffa.model.fields import Spaces, vertices
from staffa.model.supports import rigid_modes

# Damage at all corners of a cell from which it connects nothing.
BROKEN = 0.95
# The residual stiffness of cracks stores less than this fraction of the other energy, unless it
# carries a load, or is opened by moving supports.
SHARE = 1e-2
# The residual stiffness carries a part if it carries this fraction of the part's load.
BORNE = 0.5
# A rigid motion is free if supports resist it by less than the first number; a load is zero if all
# but the second fraction of it cancels.
FREE, CANCELS = 1e-9, 1e-9


@dataclass(frozen=True, kw_only=True)
class LoosePart:
    """Part that nothing supports against its load.

    Attributes
    ----------
    place : its center (m).
    share : its part of the whole body.
    loads : names of the loads that act on it.
    broken : True for rock that is broken throughout.
    """

    place: tuple[float, ...]
    share: float
    loads: tuple[str, ...]
    broken: bool

    def sentence(self) -> str:
        """Return a message on the part, with the way out."""
        place = ", ".join(f"{c:.3g}" for c in self.place)
        what = "rock, broken all through," if self.broken else "part"
        instead = ", or take a larger damage.residual_stiffness" if self.broken else ""
        return (
            f"the load cannot be carried any more, the body is in two: nothing supports the {what} "
            f"around ({place}), {self.share:.0%} of the body, against {' and '.join(self.loads)}. "
            f"Earlier steps are kept; shorter time steps find the load at which it breaks. "
            f"To go further take smaller loads, prescribe displacements in their place, or support "
            f"that part by [supports]{instead}"
        )


def require_whole(problem: Problem, system: System) -> None:
    """Refuse a state in which only the residual stiffness of cracks carries a load. Collective.

    Raises
    ------
    PartedError
        A part is loose.
    SolveError
        Energy or forces are no numbers, so that nothing is known of it.
    """
    part = loose_part(problem, system)
    if part is not None:
        raise PartedError(part.sentence())


def loose_part(problem: Problem, system: System, *, solved: bool = True) -> LoosePart | None:
    """Return the loose part with the largest load; None without one. Collective.

    A part consists of cells that are not broken and are connected; the vertices in none of them
    are one more part, which may move freely. A part is loose if supports leave it a rigid motion
    along which its load does work, and if the residual stiffness of cracks balances this load, not
    faces in contact (a split).

    Parameters
    ----------
    problem : the problem.
    system : its system.
    solved : False if no displacement was found. Without a split none is needed; with one, None is
        returned where the displacement gives no numbers.
    """
    try:
        return _loose_part(problem, system, solved)
    except SolveError:
        if solved:
            raise
        return None


def _loose_part(problem: Problem, system: System, solved: bool) -> LoosePart | None:
    energy, alpha, comm = system.energy, system.state.alpha, problem.domain.comm
    # If the volume in cracks is given, the pressure falls as a part moves.
    dead = energy.loaded and not energy.external.controlled
    if not dead or not max_over_ranks(comm, alpha.x.array) >= BROKEN:
        return None
    known = solved or not energy.linear
    rest = _stored_without_cracks(system) if known else 0.0
    if known and _number(energy.stored()) - rest <= SHARE * rest:
        return None
    labels, number = number_parts(alpha, BROKEN)
    n_owned = system.spaces.nodes.dofmap.index_map.size_local
    dim, fixed = problem.domain.dim, system.supports.fixed
    labels = _at_nodes(system.spaces, alpha, labels)
    mine = np.where(labels < 0, number, labels)[:n_owned]
    modes = rigid_modes(problem.domain, system.spaces)[: n_owned * dim].copy()
    modes[np.repeat(mine == number, dim), dim:] = 0.0  # broken rock turns as it likes
    resisted = np.zeros((number + 1, modes.shape[1], modes.shape[1]))
    constrained = fixed[mine[fixed // dim] < number]
    np.add.at(
        resisted,
        mine[constrained // dim],
        modes[constrained][:, :, None] * modes[constrained][:, None, :],
    )
    resisted = sum_over_ranks(comm, resisted)
    modes[np.setdiff1d(fixed, constrained)] = 0.0
    loads = _net(system, modes, mine, number + 1, applied=True)
    balanced = _net(system, modes, mine, number + 1, applied=False)[0] if known else loads[0]
    worst, most = -1, 0.0
    for k in range(number + 1):
        strength, directions = np.linalg.eigh(resisted[k])
        free = directions[:, strength <= FREE * max(1.0, float(strength[-1]))]
        load, unborne = free.T @ loads[0][k], free.T @ balanced[k]
        size = float(np.linalg.norm(load))
        if size <= max(most, CANCELS * loads[1]) or np.linalg.norm(unborne) <= BORNE * size:
            continue
        if not known or _carried(system, mine == k) > SHARE * rest:
            worst, most = k, size
    if worst < 0:
        return None
    return _piece(problem, system, mine == worst, broken=worst == number)


def number_parts(alpha: fem.Function, broken: float) -> tuple[np.ndarray, int]:
    """Number the part of each vertex, ghosts included, -1 for none, and count the parts.

    Cells belong together if they share a vertex and neither has this damage at all its corners.
    Collective.
    """
    space, comm = alpha.function_space, alpha.function_space.mesh.comm
    cells = space.dofmap.list
    sound = alpha.x.array[cells].min(axis=1) < broken
    joined = cells[sound]
    here, own = _components(
        np.repeat(joined[:, 0], joined.shape[1] - 1), joined[:, 1:].ravel(), len(alpha.x.array)
    )
    before = [int(part[0]) for part in everywhere(comm, np.array([here]))]
    own = own + sum(before[: comm.rank])
    told = fem.Function(space)
    told.x.array[:] = own
    told.x.scatter_forward()  # ghosts: the part that the owner has
    pairs = np.unique(np.stack([own, told.x.array.astype(np.int64)], axis=1), axis=0)
    start, end = np.concatenate(everywhere(comm, pairs)).T
    n, together = _components(start, end, sum(before))
    labels = together[own]
    topology = space.mesh.topology
    n_cells = topology.index_map(topology.dim).size_local
    there = np.bincount(labels[cells[:n_cells][sound[:n_cells], 0]], minlength=n)
    sound_ones = sum_over_ranks(comm, there) > 0
    return np.where(sound_ones, np.cumsum(sound_ones) - 1, -1)[labels], int(sound_ones.sum())


def _at_nodes(spaces: Spaces, alpha: fem.Function, labels: np.ndarray) -> np.ndarray:
    """Return the parts of the nodes of u from those of the vertices.

    A midpoint of an edge is in the part of an unbroken cell around it, -1 if there is none.
    """
    if not spaces.quadratic:
        return labels
    cells, nodes = spaces.alpha.dofmap.list, spaces.nodes.dofmap.list
    found = np.full(int(nodes.max()) + 1, -1, dtype=np.int64)
    sound = alpha.x.array[cells].min(axis=1) < BROKEN
    found[nodes[sound]] = labels[cells[sound][:, 0]][:, None]
    found[spaces.vertex_nodes] = labels
    return found


def _components(start: np.ndarray, end: np.ndarray, n: int) -> tuple[int, np.ndarray]:
    links = coo_array((np.ones(len(start), dtype=bool), (start, end)), shape=(n, n))
    number, labels = connected_components(links, directed=False)
    return int(number), labels.astype(np.int64)


def _stored_without_cracks(system: System) -> float:
    """Return the elastic energy without the residual stiffness of cracks. Collective."""
    with system.energy.without_residual_stiffness():
        return _number(system.energy.stored())


def _number(value: float) -> float:
    """Return the value; refuse one with which no comparison is True."""
    if not np.isfinite(value):
        raise SolveError(
            f"energy or forces of the broken body are no number ({value}), so that nothing tells "
            f"if a part of it has come loose; shorter time steps, or a larger "
            f"damage.residual_stiffness, may find a state"
        )
    return value


def _carried(system: System, part: np.ndarray) -> float:
    """Return the energy that the load on a part would store by itself. Collective.

    Wide cracks store energy in their residual stiffness too, which no load has brought there.

    Parameters
    ----------
    system : the system.
    part : True for the owned nodes of the part.
    """
    forces, answer = (system.alternation.u.duplicate() for _ in range(2))
    system.energy.applied(forces)
    kept = writable(forces).reshape(len(part), -1)
    kept[~part] = 0.0
    answer.set(0.0)
    try:
        system.alternation.elastic.solve_forces(forces, answer)
        return float(forces.dot(answer)) / 2
    except SolveError:  # nothing resists it that a solver finds
        return np.inf
    finally:
        forces.destroy()
        answer.destroy()


def _net(
    system: System, modes: np.ndarray, labels: np.ndarray, number: int, *, applied: bool
) -> tuple[np.ndarray, float]:
    """Return the loads on each part along rigid motions, and the sum of their absolute values.

    Without `applied` it returns the residual without residual stiffness in place of the loads. The
    loads have shape (number, n_modes). Collective.

    Parameters
    ----------
    system : the system.
    modes : rigid motions, shape (n_owned, n_modes), see `rigid_modes`.
    labels : part of each owned node.
    number : number of parts.
    applied : True for the loads.
    """
    energy, forces = system.energy, system.alternation.u.duplicate()
    if applied:
        energy.applied(forces)
    else:
        with energy.without_residual_stiffness():
            energy.residual(forces)
    works = modes * readable(forces)[:, None]
    forces.destroy()
    found = np.zeros((number, modes.shape[1]))
    np.add.at(found, np.repeat(labels, len(modes) // max(len(labels), 1)), works)
    comm = energy.comm
    size = _number(float(sum_over_ranks(comm, float(np.abs(works).sum()))))
    return sum_over_ranks(comm, found), size


def _piece(problem: Problem, system: System, mine: np.ndarray, *, broken: bool) -> LoosePart:
    """Return the part of the owned nodes where `mine` is True. Collective."""
    space, forces, domain = system.spaces.nodes, problem.forces, problem.domain
    comm = domain.comm
    x = vertices(space)[: len(mine)][mine][:, : domain.dim]
    n_all = sum_over_ranks(comm, float(len(mine)))
    n_here = sum_over_ranks(comm, float(mine.sum()))
    middle = sum_over_ranks(comm, x.sum(axis=0)) / n_here
    names = [
        f"what acts on '{t.side}'" for t in forces.sides if _touches(problem, system, t.side, mine)
    ]
    names += ["its weight"] if forces.gravity is not None else []
    pores = (forces.fluid or forces.pore_pressure is not None) and forces.biot > 0
    names += ["the fluid in cracks"] if forces.in_cracks else []
    names += ["the pressure in its pores"] if pores else []
    place = tuple(middle.tolist())
    return LoosePart(place=place, share=n_here / n_all, loads=tuple(names), broken=broken)


def _touches(problem: Problem, system: System, side: str, mine: np.ndarray) -> bool:
    """Return True if some of the marked nodes lie on a boundary. Collective."""
    space, domain = system.spaces.nodes, problem.domain
    found = fem.locate_dofs_topological(space, domain.dim - 1, domain.facets(side))
    found = found[found < len(mine)]
    return bool(sum_over_ranks(domain.comm, float(mine[found].sum())) > 0)
