"""Supports of the body: prescribed displacements, pins, and generalized plane strain."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
from dolfinx import fem
from dolfinx.mesh import exterior_facet_indices

from staffa.backend.parallel import best_candidate, on_root, sum_over_ranks
from staffa.errors import InputError
from staffa.model.axis import held_by_axis
from staffa.model.domain import Domain
from staffa.model.fields import Spaces, vertices

# A displacement component (m): of points x, shape (3, n), and time t -> shape (n,), or one value.
Displacement = Callable[[np.ndarray, float], np.ndarray | float]


def no_displacement(x: np.ndarray, t: float) -> float:
    """Return 0, at all points and times."""
    return 0.0


@dataclass(frozen=True, kw_only=True)
class SideSupport:
    """Displacement components prescribed on one boundary.

    Attributes
    ----------
    side : name of the boundary.
    components : displacement (m) by axis.
    """

    side: str
    components: Mapping[int, Displacement]


def rollers(domain: Domain, side: str) -> SideSupport:
    """Prescribe no displacement across a flat boundary; displacement along it is free.

    Raises
    ------
    InputError
        There is no such boundary, or it is not flat across an axis.
    """
    domain.facets(side)
    if side not in domain.axes:
        raise InputError(
            f"rollers need a side that is flat across an axis, and '{side}' is not; flat are "
            f"{', '.join(sorted(domain.axes)) or 'none'}"
        )
    return SideSupport(side=side, components={domain.axes[side]: no_displacement})


def clamped(domain: Domain, side: str) -> SideSupport:
    """Prescribe no displacement at all on a boundary."""
    return SideSupport(side=side, components=dict.fromkeys(range(domain.dim), no_displacement))


@dataclass(frozen=True, kw_only=True)
class GeneralizedPlaneStrain:
    """Right side of a slab's cell that stays plane: u_x = c + theta (y - y_m).

    With rollers on the left this is the uniform strain e_xx = (c + theta (y - y_m))/width, added to
    a periodic field. c and theta are minimized with the displacement (no force, no moment). y_m is
    the middle of the height, for conditioning only.

    Attributes
    ----------
    bending : False if theta is 0.
    """

    bending: bool


@dataclass(frozen=True, kw_only=True)
class Supports:
    """Degrees of freedom that are not free, as local indices of entries that this rank owns.

    Attributes
    ----------
    fixed : prescribed entries of u, shape (n_fixed,).
    points : coordinates of their nodes (m), shape (3, n_fixed).
    displacements : prescribed displacements, each with the positions in `fixed` of its entries.
    sides : boundary of each displacement.
    moved : entries that the unknowns of generalized plane strain move, shape (n_moved,).
    modes : displacement of all entries for a unit of each of these unknowns, shape (n_owned,) each.
    """

    fixed: np.ndarray
    points: np.ndarray
    displacements: tuple[tuple[Displacement, np.ndarray], ...]
    sides: tuple[str, ...]
    moved: np.ndarray
    modes: tuple[np.ndarray, ...]

    def values(self, t: float) -> np.ndarray:
        """Return the prescribed values (m) at time t (s), one for each entry of `fixed`."""
        values = np.zeros(len(self.fixed))
        for displacement, places in self.displacements:
            values[places] = displacement(self.points[:, places], t)
        return values


def build_supports(
    domain: Domain,
    spaces: Spaces,
    sides: Sequence[SideSupport],
    *,
    section: GeneralizedPlaneStrain | None = None,
    anchor: str | None = None,
) -> Supports:
    """Turn supports into degrees of freedom, and pin the remaining rigid body motions.

    There are as many pins, components of single nodes, as free rigid body motions. So they carry no
    reaction under loads in equilibrium, and bend nothing. On the axis of a body of revolution
    nothing moves along r. Collective.

    Parameters
    ----------
    domain : the mesh.
    spaces : the function spaces.
    sides : supports of the boundaries.
    section : generalized plane strain; None without.
    anchor : boundary on which pins are sought, that opposite the cooled face, which no crack cuts
        off early; None for all boundaries, or the whole surface if none has a name.
    """
    displacements: list[Displacement] = []
    follows: dict[int, int] = {}
    for support in sides:
        for axis, displacement in support.components.items():
            follows |= dict.fromkeys(
                _dofs(domain, spaces, support.side, axis).tolist(), len(displacements)
            )
            displacements.append(displacement)
    moved, modes = _section_modes(domain, spaces, section)
    on_axis = [dof for dof in held_by_axis(domain, spaces).tolist() if dof not in follows]
    held = np.array([*follows, *moved, *on_axis], dtype=np.int32)
    pins = _pins(domain, spaces, held, anchor)
    fixed = np.array(sorted([*follows, *pins, *on_axis]), dtype=np.int32)
    number = np.array([follows.get(dof, -1) for dof in fixed.tolist()], dtype=np.int64)
    return Supports(
        fixed=fixed,
        points=vertices(spaces.nodes)[fixed // domain.dim].T,
        displacements=tuple(
            (displacement, np.flatnonzero(number == k))
            for k, displacement in enumerate(displacements)
        ),
        sides=tuple(support.side for support in sides for _ in support.components),
        moved=moved,
        modes=modes,
    )


def _dofs(domain: Domain, spaces: Spaces, side: str, axis: int) -> np.ndarray:
    facets = domain.facets(side)
    found = fem.locate_dofs_topological(spaces.nodes, domain.dim - 1, facets)
    return np.asarray(found[found < spaces.nodes.dofmap.index_map.size_local] * domain.dim + axis)


def _section_modes(
    domain: Domain, spaces: Spaces, section: GeneralizedPlaneStrain | None
) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
    if section is None:
        return np.zeros(0, dtype=np.int32), ()
    if domain.dim != 2 or domain.axial:
        raise InputError("a section that stretches or bends is for flat 2-D cells; use rollers")
    moved = np.asarray(_dofs(domain, spaces, "right", 0), dtype=np.int32)
    x = vertices(spaces.nodes)
    stretch = np.zeros(2 * spaces.nodes.dofmap.index_map.size_local)
    stretch[moved] = 1.0
    if not section.bending:
        return moved, (stretch,)
    bend = np.zeros_like(stretch)
    bend[moved] = x[moved // 2, 1] - _middle(domain)[1]
    return moved, (stretch, bend)


def _middle(domain: Domain) -> np.ndarray:
    return np.array(domain.lower) + np.array(domain.size) / 2


def rigid_modes(domain: Domain, spaces: Spaces) -> np.ndarray:
    """Return translations and rotations about the body's center, of order 1, (n_local, 3 or 6).

    For a body of revolution the translation along its axis alone, shape (n_local, 1).
    """
    dim = domain.dim
    if domain.axial:
        along = np.tile([0.0, 1.0], len(vertices(spaces.nodes)))
        return along[:, None]
    x = (vertices(spaces.nodes)[:, :dim] - _middle(domain)) / max(domain.size)
    planes = [(0, 1)] if dim == 2 else [(0, 1), (1, 2), (2, 0)]
    modes = np.zeros((len(x), dim, dim + len(planes)))
    for axis in range(dim):
        modes[:, axis, axis] = 1.0
    for number, (i, j) in enumerate(planes):
        modes[:, i, dim + number] = -x[:, j]
        modes[:, j, dim + number] = x[:, i]
    return modes.reshape(len(x) * dim, dim + len(planes))


def _pins(domain: Domain, spaces: Spaces, held: np.ndarray, anchor: str | None) -> list[int]:
    """Choose components that stop the remaining rigid motions, the same on any ranks."""
    comm, dim = domain.comm, domain.dim
    modes = rigid_modes(domain, spaces)
    n_owned = spaces.u.dofmap.index_map.size_local * dim
    gram = sum_over_ranks(comm, modes[held].T @ modes[held])
    count = max(1.0, sum_over_ranks(comm, len(held)))
    # On one rank: the basis of several free motions depends on the processor.
    strength, directions = on_root(comm, lambda: np.linalg.eigh(gram / count))
    free = modes @ directions[:, strength < 1e-9]  # what no support resists, to round-off

    if anchor or domain.boundaries:
        names = [anchor] if anchor else list(domain.boundaries)
        facets = np.unique(np.concatenate([domain.facets(name) for name in names]))
    else:
        facets = exterior_facet_indices(domain.mesh.topology)
    candidates = fem.locate_dofs_topological(spaces.nodes, dim - 1, facets)
    candidates = candidates[candidates * dim < n_owned]
    dofs = (candidates[:, None] * dim + np.arange(dim)).ravel()
    x = vertices(spaces.nodes) / max(domain.size)
    local_range = spaces.u.dofmap.index_map.local_range[0] * dim
    pins = []
    for _ in range(free.shape[1]):
        best = None
        if len(dofs):
            reach = np.round(np.linalg.norm(free[dofs], axis=1), 9)
            keys = [
                (reach[k], *x[dof // dim].round(9), float(dof % dim)) for k, dof in enumerate(dofs)
            ]
            k = max(range(len(dofs)), key=keys.__getitem__)
            best = (*keys[k], float(local_range + dofs[k]), *free[dofs[k]])
        chosen = best_candidate(comm, best)
        assert chosen is not None and chosen[0] > 1e-6, "no node to pin the body at"
        dof = int(chosen[5]) - local_range
        row = np.array(chosen[6:])
        if 0 <= dof < n_owned:
            pins.append(int(dof))
        free = free - np.outer(free @ row, row) / (row @ row)
    return pins
