"""State of one mesh on another of the same body: interpolated, or lifted to a finer one."""

from collections.abc import Callable
from dataclasses import replace

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
from dolfinx import fem

from staffa.backend.parallel import any_over_ranks
from staffa.evolution.initial_equilibrium import unmoved
from staffa.evolution.problem import Problem
from staffa.evolution.snapshot import Snapshot, copied, restore
from staffa.evolution.system import System, build, initially_broken
from staffa.geometry.nested import Nested
from staffa.minimize.alternate import equilibrium
from staffa.model.domain import Domain, local_edges
from staffa.model.fields import Transfer, owned, spaces_on
from staffa.model.initial_cracks import broken
from staffa.model.numbering import Numbering
from staffa.model.refinement import Wanted, refined, too_coarse
from staffa.records.energies import Energies

# Values of one function as values of another one, ghosts included.
Across = Callable[[fem.Function, fem.Function, np.ndarray], np.ndarray]


def carried(old: System, problem: Problem, across: Across) -> System:
    """Build a problem on another mesh of the same body, with the state carried over. Collective.

    Parameters
    ----------
    old : its state is read, and stays as it is.
    problem : the problem on the other mesh.
    across : from a function on the old mesh, one on the new mesh, and values of the first, values
        of the second.
    """
    new, kept = build(problem), copied(old)
    before, after, spent, counted = old.state, new.state, old.energy.spent, new.energy.spent
    frozen = zip(old.energy.frozen, new.energy.frozen, kept.frozen, strict=True)
    booked = None
    if spent and counted and kept.spent is not None:
        booked = across(spent.alpha, counted.alpha, kept.spent)
    moved = Snapshot(
        u=across(before.u, after.u, kept.u),
        alpha=across(before.alpha, after.alpha, kept.alpha),
        lower=across(old.bounds.lower, new.bounds.lower, kept.lower),
        thermal=kept.thermal.moved(lambda values: across(before.T, after.T, values)),
        frozen=tuple(across(*field) for field in frozen),
        spent=booked,
        loads=kept.loads,
    )
    rest = old.energy.rest if problem.forces.at_rest else _rest(new)
    restore(new, moved)
    new.energy.rest = rest
    return new


def _rest(system: System) -> Energies:
    """Return the energies from which others count, of a system as it was built.

    They are those of the loads of t = 0 without damage but that of initial cracks: on another mesh
    they are others, and may be much larger than what comes.
    """
    equilibrium(system.alternation, unmoved(system).values)
    system.energy.count_from_here()
    return system.energy.rest


def interpolation(h: float) -> Across:
    """Return the way between any two meshes of a body; h: mesh size of the old one (m)."""

    def across(source: fem.Function, target: fem.Function, values: np.ndarray) -> np.ndarray:
        return Transfer(source.function_space, target.function_space, h=h)(values)

    return across


class Lift:
    """The way to a finer mesh whose cells lie in those of the old one. Collective.

    Old vertices keep their values to the last bit, new ones take the mean of the two that they lie
    between, cells take what the cell that they lie in has, and quadratic functions are
    interpolated.
    """

    def __init__(self, old: Domain, nested: Nested | None) -> None:
        """Take the relation of two meshes.

        Parameters
        ----------
        old : the coarser mesh.
        nested : its relation to the finer one, on rank 0; None elsewhere.
        """
        assert old.source is not None
        self._old, self._nested = old, nested
        self._orders: dict[tuple[bool, int], Numbering] = {}

    def __call__(
        self, source: fem.Function, target: fem.Function, values: np.ndarray
    ) -> np.ndarray:
        """Return values of the target from those of the source; see `Across`."""
        before, after = source.function_space, target.function_space
        per_cell = before.dofmap.list.shape[1]
        if per_cell > self._old.dim + 1:
            return Transfer(before, after, h=self._old.h)(values)
        width = before.dofmap.index_map_bs
        whole = self._order(before).whole(values.reshape(-1, width))
        lifted = None
        if whole is not None and self._nested is not None:
            lifted = self._in_cells(whole) if per_cell == 1 else self._nested.values @ whole
        field = fem.Function(after)
        owned(field)[:] = self._order(after).share(lifted).ravel()
        field.x.scatter_forward()
        return np.asarray(field.x.array.copy())

    def _order(self, space: fem.FunctionSpace) -> Numbering:
        """Return the order of vertices or cells of one of the meshes, found once."""
        key = (space.mesh is self._old.mesh, space.dofmap.list.shape[1])
        if key not in self._orders:
            self._orders[key] = Numbering(self._old.comm, space)
        return self._orders[key]

    def _in_cells(self, whole: np.ndarray) -> np.ndarray:
        """Return values in the finer cells in their order, from those in the coarser cells."""
        assert self._nested is not None
        assert self._old.source is not None
        assert self._old.source.mesh is not None
        given = np.empty_like(whole)
        given[_in_order(self._old.source.mesh.cells)] = whole
        return np.asarray(given[self._nested.parents][_in_order(self._nested.mesh.cells)])


def _in_order(cells: np.ndarray) -> np.ndarray:
    """Return the cells in the order of `Numbering`."""
    return np.lexsort(np.sort(cells, axis=1).T)


def refined_at_cracks(problem: Problem) -> Problem:
    """Return a problem whose mesh is fine around initial cracks and along regions. Collective.

    Cells that a crack cuts are halved until they are fine, and then those around them: coarse cells
    that it cuts reach far.

    Parameters
    ----------
    problem : it comes back as it is if its mesh stays as it is.
    """
    rules, coarse = problem.refinement, problem.domain.source is not None
    while rules is not None and coarse:
        wanted, coarse = _at_cracks(problem)
        problem = replace(problem, domain=refined(problem.domain, wanted, ahead=rules.ahead)[0])
    return problem


def _at_cracks(problem: Problem) -> tuple[Wanted, bool]:
    """Return the edges that cells at initial cracks should get, and True if some are coarse."""
    domain = problem.domain
    assert domain.source is not None
    space = spaces_on(domain).alpha
    cells = space.dofmap.list[: domain.mesh.topology.index_map(domain.dim).size_local]
    at = initially_broken(problem, space)
    for crack in problem.material.given:  # coarse vertices may all be too far from it to break
        at |= broken(space, crack, h=domain.h)
    cracked, edges = at[cells].any(axis=1), local_edges(domain)
    long, wanted = cracked & too_coarse(edges, domain.source.finest), Wanted.nothing(len(edges))
    coarse = any_over_ranks(domain.comm, bool(long.any()))
    wanted.edge[long] = edges[long] / 2
    wanted.around[:] = cracked & (not coarse)
    return wanted, coarse
