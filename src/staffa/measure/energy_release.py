"""Energy release rate of crack tips by the G-theta method: along a virtual motion of the mesh.

The field theta is the crack's direction around its tip, and 0 beyond a ring. It moves the tip with
its damage and leaves the body's shape unchanged. G is the energy released per advance. At fixed
vertex values, the derivative of the energy of the rock and its loads along the motion of the mesh
contains all terms (sigma grad u . grad theta - psi div theta, the pressure in the crack, the
weight, ...). Fields that are fixed in space and do not move with the tip (temperature, prestress,
pore pressure) add the derivative along their own gradient. The damage around the tip moves
unchanged, so that only the ring contributes, in which rock beside the crack is intact (Li, Marigo,
Guilbaud, Potapov 2016).

The derivative is linear in theta. It is assembled once a state, as the force that drives each
vertex, and serves any number of tips and rings.
"""

from staffa.backend.stack import MPI  # noqa: F401

import dolfinx.mesh as dmesh
import numpy as np
import ufl
from dolfinx import fem, la

from staffa.backend import jit
from staffa.backend.parallel import gather, max_over_ranks, sum_over_ranks
from staffa.measure.fronts import Front, Surface
from staffa.model.domain import Domain
from staffa.model.energy import Energy
from staffa.records.tip_release import Release

# Inner and outer radius of the rings, over the largest: one for the value, one for its error.
RINGS = ((1 / 2, 1.0), (1 / 3, 2 / 3))
# Rock whose properties differ by less, over the largest, is homogeneous.
ALIKE = 1e-6
RUBBING = "with friction, what the faces take up along the crack is not the tip's alone"


class EnergyRelease:
    """Energy release rate G at the tips of a body's states. All methods are collective."""

    def __init__(self, domain: Domain, energy: Energy, *, factor: float) -> None:
        """Compile the forms.

        Parameters
        ----------
        domain : the mesh.
        energy : the energy of the state.
        factor : effective Gc over Gc, by which areas are counted.
        """
        mesh, self._domain, self._factor = domain.mesh, domain, factor
        space = fem.functionspace(mesh, ("Lagrange", 1, (domain.dim,)))
        theta = ufl.TestFunction(space)
        place = ufl.SpatialCoordinate(mesh)
        along = [ufl.derivative(energy.bulk, f, ufl.dot(ufl.grad(f), theta)) for f in energy.fixed]
        moved = (ufl.derivative(energy.bulk, place, theta), sum(along[1:], along[0]))
        self._moved = [jit.form(form, mesh.comm) for form in moved]
        self._grown = jit.form(ufl.derivative(energy.area, place, theta), mesh.comm)
        self._sums = fem.Function(space)
        owned = space.dofmap.index_map.size_local
        self._x = space.tabulate_dof_coordinates()[:owned]
        cells = np.arange(mesh.topology.index_map(domain.dim).size_local, dtype=np.int32)
        self._middles = dmesh.compute_midpoints(mesh, domain.dim, cells)
        rubs = energy.faces is not None and energy.faces.rubs
        self._rubbing = RUBBING if rubs else None
        self._rock = [_by_cell(field, len(cells)) for field in _rock(energy)]

    def __call__(self, fronts: tuple[Front, ...]) -> tuple[Release, ...]:
        """Return G at each tip, the same on all ranks; `fronts` is the same on all ranks, too."""
        if not fronts:
            return ()
        forces, areas = -self._along(*self._moved), self._along(self._grown)
        return tuple(self._at(front, forces, areas) for front in fronts)

    def _along(self, *forms: fem.Form) -> np.ndarray:
        """Return the derivative of the forms' sum along this rank's vertices' motion, (n, dim)."""
        self._sums.x.array[:] = 0.0
        for form in forms:
            fem.assemble_vector(self._sums.x.array, form)
        self._sums.x.scatter_reverse(la.InsertMode.add)
        return np.asarray(self._sums.x.array.reshape(-1, self._domain.dim)[: len(self._x)].copy())

    def _at(self, front: Front, forces: np.ndarray, areas: np.ndarray) -> Release:
        dim, comm = self._domain.dim, self._domain.comm
        place, way = front.position[:dim], np.array(front.direction[:dim])
        reason = front.reason or self._changing(front) or self._rubbing
        if reason:
            return Release(position=place, direction=tuple(way.tolist()), reason=reason)
        away = np.linalg.norm(self._x - np.array(front.position), axis=1) / front.radius
        inner, outer = np.array(RINGS).T
        share = np.clip((outer - away[:, None]) / (outer - inner), 0, 1)
        released, grown = sum_over_ranks(
            comm, np.stack([share.T @ (forces @ way), share.T @ (areas @ way)])
        )
        if dim == 3 or self._domain.axial:  # over the advance of the front, which the area tells
            released = released / (grown / self._factor)
        return Release(
            position=place,
            direction=tuple(way.tolist()),
            G=float(released[0]),
            uncertainty=float(abs(released[0] - released[1])),
            radius=front.radius,
        )

    def _changing(self, front: Front) -> str | None:
        """Return a reason if the rock changes within the ring: its jumps would release energy."""
        near = np.linalg.norm(self._middles - np.array(front.position), axis=1) <= front.radius
        for values in self._rock:
            some = values[near]
            most = [max_over_ranks(self._domain.comm, column) for column in some.T]
            least = [-max_over_ranks(self._domain.comm, -column) for column in some.T]
            spread = max(np.subtract(most, least))
            if spread > ALIKE * max(np.abs([*most, *least])):
                return "the rock changes within the ring around the tip"
        return None


def _rock(energy: Energy) -> list[fem.Function]:
    """Return the rock properties in the energy that are constant in each cell."""
    fields = [f for f in energy.bulk.coefficients() if f not in energy.frozen]
    return [f for f in fields if f.function_space.ufl_element().embedded_superdegree == 0]


def _by_cell(field: fem.Function, count: int) -> np.ndarray:
    """Return the values of a field in the first cells, shape (count, values a cell)."""
    space = field.function_space
    values = field.x.array.reshape(-1, space.dofmap.index_map_bs)
    return np.asarray(values[space.dofmap.list[:count, 0]])


def body_surface(domain: Domain) -> Surface | None:
    """Gather all facets of the body's surface on rank 0; return None elsewhere. Collective."""
    mesh, dim = domain.mesh, domain.dim
    mesh.topology.create_connectivity(dim - 1, dim)
    facets = dmesh.exterior_facet_indices(mesh.topology)
    corners = mesh.geometry.x[dmesh.entities_to_geometry(mesh, dim - 1, facets)]
    middles = corners.mean(axis=1)
    sides = corners[:, 1:dim] - corners[:, :1]
    other = sides[:, 1] if dim == 3 else np.array([0.0, 0.0, 1.0])
    across = np.cross(sides[:, 0], other)
    across /= np.linalg.norm(across, axis=1)[:, None]
    sizes = np.linalg.norm(corners - middles[:, None], axis=2).max(axis=1)
    parts = [gather(domain.comm, part) for part in (middles, across, sizes)]
    if parts[0] is None:
        return None
    whole = [np.concatenate(part or []) for part in parts]
    return Surface(middles=whole[0], normals=whole[1], sizes=whole[2])
