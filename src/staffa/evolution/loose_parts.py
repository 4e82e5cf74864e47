"""Pieces of the body that cracks part from all that holds them, and the loads that they bear."""

from dataclasses import dataclass

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
from dolfinx import fem
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from staffa.backend.parallel import everywhere, max_over_ranks, sum_over_ranks
from staffa.backend.vectors import readable
from staffa.errors import PartedError
from staffa.evolution.problem import Problem
from staffa.evolution.system import System
from staffa.model.fields import Spaces, vertices
from staffa.model.supports import rigid_modes

# Damage at all corners of a cell from which on it joins nothing.
BROKEN = 0.95
# What is left of stiffness in cracks stores less than this fraction of what the rest does, unless
# it bears a load of its own, or is opened by supports that move.
SHARE = 1e-2
# A piece is borne by it if it bears this fraction of the piece's load.
BORNE = 0.5
# A rigid motion is free if supports resist it by less than this; a load is none if so much of it
# does not cancel.
FREE, CANCELS = 1e-9, 1e-9


@dataclass(frozen=True, kw_only=True)
class LoosePart:
    """A piece that nothing holds against its load.

    place: its middle (m). share: of the whole body. loads: what acts on it, by name. broken: True
    for rock that is broken all through.
    """

    place: tuple[float, ...]
    share: float
    loads: tuple[str, ...]
    broken: bool

    def sentence(self) -> str:
        """Say what happened, and the way out."""
        place = ", ".join(f"{c:.3g}" for c in self.place)
        what = "rock, broken all through," if self.broken else "piece"
        return (
            f"the load cannot be carried any more, the body is in two: nothing holds the {what} "
            f"around ({place}), {self.share:.0%} of the body, against {' and '.join(self.loads)}. "
            f"What was found before stands; shorter time steps find the load at which it breaks. "
            f"To go further take smaller loads, prescribe displacements in their place, or hold "
            f"that piece by [supports]"
        )


def require_whole(problem: Problem, system: System) -> None:
    """Nothing that bears a load is held by the residual stiffness of cracks alone. Collective.

    Raises
    ------
    PartedError
        Something is.
    """
    piece = loose_part(problem, system)
    if piece is not None:
        raise PartedError(piece.sentence())


def loose_part(problem: Problem, system: System, *, solved: bool = True) -> LoosePart | None:
    """The piece with the largest load that nothing holds; None without one. Collective.

    A piece is what is joined by cells that are not broken; what is in none of them counts as one
    more, which may go anywhere. Nothing holds it if supports leave it a rigid motion along which
    its load does work, and if what balances this load is the residual stiffness of cracks, not
    faces that press on each other (a split).

    Parameters
    ----------
    solved : False where no displacement was found. Without a split none is needed.
    """
    energy, alpha, comm = system.energy, system.state.alpha, problem.domain.comm
    # Where a volume is given in cracks, its pressure falls as a piece gives way.
    dead = energy.loaded and not energy.external.controlled
    if not dead or not max_over_ranks(comm, alpha.x.array) >= BROKEN:
        return None
    known = solved or not energy.linear
    if known and not _stores_much(system):
        return None
    labels, number = number_parts(alpha, BROKEN)
    n_owned = system.spaces.nodes.dofmap.index_map.size_local
    dim, fixed = problem.domain.dim, system.supports.fixed
    labels = _at_nodes(system.spaces, alpha, labels)
    mine = np.where(labels < 0, number, labels)[:n_owned]
    modes = rigid_modes(problem.domain, system.spaces)[: n_owned * dim].copy()
    modes[np.repeat(mine == number, dim), dim:] = 0.0  # broken rock turns as it likes
    resisted = np.zeros((number + 1, modes.shape[1], modes.shape[1]))
    held = fixed[mine[fixed // dim] < number]
    np.add.at(resisted, mine[held // dim], modes[held][:, :, None] * modes[held][:, None, :])
    resisted = sum_over_ranks(comm, resisted)
    modes[np.setdiff1d(fixed, held)] = 0.0
    loads = _net(system, modes, mine, number + 1, applied=True)
    balanced = _net(system, modes, mine, number + 1, applied=False)[0] if known else loads[0]
    worst, most = -1, 0.0
    for k in range(number + 1):
        strength, directions = np.linalg.eigh(resisted[k])
        free = directions[:, strength <= FREE * max(1.0, float(strength[-1]))]
        load, unborne = free.T @ loads[0][k], free.T @ balanced[k]
        size = float(np.linalg.norm(load))
        if size > max(most, CANCELS * loads[1]) and np.linalg.norm(unborne) > BORNE * size:
            worst, most = k, size
    if worst < 0:
        return None
    return _piece(problem, system, mine == worst, broken=worst == number)


def number_parts(alpha: fem.Function, broken: float) -> tuple[np.ndarray, int]:
    """Number the piece of each vertex, ghosts included, -1 if it has none; and count them.

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
    told.x.scatter_forward()  # ghosts: the piece that the owner has
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
    """The pieces of the nodes of u, from those of the vertices; a node in the middle of an edge is
    in that of a cell around it that is not broken, -1 if there is none."""
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


def _stores_much(system: System) -> bool:
    """True if the residual stiffness of cracks stores what counts beside the rest. Collective."""
    energy = system.energy
    whole = energy.stored()
    with energy.without_residual_stiffness():
        rest = energy.stored()
    return whole - rest > SHARE * rest


def _net(
    system: System, modes: np.ndarray, labels: np.ndarray, number: int, *, applied: bool
) -> tuple[np.ndarray, float]:
    """The loads on each piece along rigid motions, or what is unbalanced but for the residual
    stiffness, shape (number, n_modes); the size of all of them, their signs left out. Collective.

    Parameters
    ----------
    modes : shape (n_owned, n_modes), see `rigid_modes`. labels : of the owned nodes.
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
    return sum_over_ranks(comm, found), float(sum_over_ranks(comm, float(np.abs(works).sum())))


def _piece(problem: Problem, system: System, mine: np.ndarray, *, broken: bool) -> LoosePart:
    """The piece of the owned nodes where `mine` is True. Collective."""
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
    names += ["the fluid in cracks"] if forces.in_cracks else []
    names += ["the pressure in its pores"] if forces.pore_pressure is not None else []
    place = tuple(middle.tolist())
    return LoosePart(place=place, share=n_here / n_all, loads=tuple(names), broken=broken)


def _touches(problem: Problem, system: System, side: str, mine: np.ndarray) -> bool:
    """True if some of this rank's owned nodes, or of another's, lie on a side. Collective."""
    space, domain = system.spaces.nodes, problem.domain
    found = fem.locate_dofs_topological(space, domain.dim - 1, domain.facets(side))
    found = found[found < len(mine)]
    return bool(sum_over_ranks(domain.comm, float(mine[found].sum())) > 0)
