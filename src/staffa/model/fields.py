"""Unknown fields on a mesh: displacement, damage, temperature, and the bounds of the damage."""

from dataclasses import dataclass
from functools import cached_property

from staffa.backend.stack import PETSc

import numpy as np
from dolfinx import fem, la

from staffa.backend.parallel import any_over_ranks
from staffa.backend.vectors import readable, writable
from staffa.errors import InputError, StaffaError
from staffa.model.domain import Domain
from staffa.physics.locking import LINEAR, QUADRATIC, REDUCED, cures

# Vertices on a boundary may lie outside the other mesh by round-off: by this fraction of a cell.
OUTSIDE = 1e-6


@dataclass(frozen=True, kw_only=True)
class Spaces:
    """Function spaces of the fields.

    Attributes
    ----------
    u : space of the displacement.
    alpha : space of damage and temperature change.
    cell : space of one constant a cell.
    nodes : scalars at the nodes of u, numbered as u is: `alpha` itself if u is linear; if u is
        quadratic, at the vertices and the midpoints of edges.
    reduced : True if the volume change is integrated with one point a cell, see `energy`.
    """

    u: fem.FunctionSpace
    alpha: fem.FunctionSpace
    cell: fem.FunctionSpace
    nodes: fem.FunctionSpace
    reduced: bool = False

    @property
    def quadratic(self) -> bool:
        """True if the displacement is quadratic."""
        return self.nodes is not self.alpha

    @cached_property
    def vertex_nodes(self) -> np.ndarray:
        """Node of u at each vertex of alpha, ghosts included, shape (n_vertices,)."""
        vertices, nodes = self.alpha.dofmap.list, self.nodes.dofmap.list
        index_map = self.alpha.dofmap.index_map
        found = np.zeros(index_map.size_local + index_map.num_ghosts, dtype=np.int32)
        # The first nodes of a cell are its corners, in their order.
        found[vertices.ravel()] = nodes[:, : vertices.shape[1]].ravel()
        return found


def spaces_on(domain: Domain, elements: str = LINEAR) -> Spaces:
    """Create the spaces on a domain. Node i of `nodes` is node i of u on every rank. Collective.

    Parameters
    ----------
    domain : the mesh.
    elements : "linear", "quadratic" (of triangles and tetrahedra) or "reduced" (of quadrilaterals
        and hexahedra), see `physics.locking`.

    Raises
    ------
    InputError
        The cells have no such elements.
    """
    mesh = domain.mesh
    shape = mesh.topology.cell_name()
    if elements not in (LINEAR, cures(shape)):
        raise InputError(f"{shape} cells have no {elements} elements; take {cures(shape)}")
    degree = 2 if elements == QUADRATIC else 1
    alpha = fem.functionspace(mesh, ("Lagrange", 1))
    spaces = Spaces(
        u=fem.functionspace(mesh, ("Lagrange", degree, (domain.dim,))),
        alpha=alpha,
        cell=fem.functionspace(mesh, ("Discontinuous Lagrange", 0)),
        nodes=alpha if degree == 1 else fem.functionspace(mesh, ("Lagrange", degree)),
        reduced=elements == REDUCED,
    )
    same = np.array_equal(spaces.u.dofmap.list, spaces.nodes.dofmap.list)
    if any_over_ranks(domain.comm, not same):
        raise StaffaError("displacement and damage number the vertices differently on this mesh")
    return spaces


def linear_spaces(domain: Domain) -> Spaces:
    """Create the spaces with a linear displacement, whose nodes are the vertices. Collective."""
    return spaces_on(domain)


@dataclass(frozen=True, kw_only=True)
class State:
    """Fields of one mesh, changed in place.

    Attributes
    ----------
    u : displacement (m).
    alpha : damage.
    T : temperature change (K).
    p : pressure of the fluid that comes with the temperature (Pa); 0 without one.
    """

    u: fem.Function
    alpha: fem.Function
    T: fem.Function
    p: fem.Function


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """Bounds lower <= alpha <= upper at each vertex of one mesh, changed in place.

    Attributes
    ----------
    lower : lower bound of the damage, from irreversibility.
    upper : upper bound of the damage.
    """

    lower: fem.Function
    upper: fem.Function


def zero_state(spaces: Spaces) -> State:
    """Return the undamaged, undeformed state at the initial temperature."""
    return State(
        u=fem.Function(spaces.u, name="u"),
        alpha=fem.Function(spaces.alpha, name="alpha"),
        T=fem.Function(spaces.alpha, name="T"),
        p=fem.Function(spaces.alpha, name="p"),
    )


def unit_bounds(spaces: Spaces) -> Bounds:
    """Return the bounds 0 <= alpha <= 1."""
    bounds = Bounds(
        lower=fem.Function(spaces.alpha, name="lower"),
        upper=fem.Function(spaces.alpha, name="upper"),
    )
    bounds.upper.x.array[:] = 1.0
    return bounds


def owned(function: fem.Function) -> np.ndarray:
    """Return the entries that this rank owns, as a view, shape (n_owned * block size,)."""
    space = function.function_space
    return np.asarray(
        function.x.array[: space.dofmap.index_map.size_local * space.dofmap.index_map_bs]
    )


def write_vector(vector: PETSc.Vec, function: fem.Function) -> None:
    """Copy a solver's vector into a function, ghosts included. Collective."""
    owned(function)[:] = readable(vector)
    function.x.scatter_forward()


def read_vector(function: fem.Function, vector: PETSc.Vec) -> None:
    """Copy a function into a solver's vector."""
    writable(vector)[:] = owned(function)


def at_vertices(u: fem.Function, spaces: Spaces) -> np.ndarray:
    """Return the displacement at the vertices that this rank owns (m), shape (n, dim)."""
    values = u.x.array.reshape(-1, u.function_space.dofmap.index_map_bs)
    return np.asarray(values[spaces.vertex_nodes[: spaces.alpha.dofmap.index_map.size_local]])


def corners(space: fem.FunctionSpace, cells: np.ndarray) -> np.ndarray:
    """Mark the vertices of some of this rank's or another's own cells; ghosts included. Collective.

    Parameters
    ----------
    space : linear scalars.
    cells : owned cells, local indices, shape (n,).
    """
    found = fem.Function(space)
    found.x.array[np.unique(space.dofmap.list[cells])] = 1.0
    found.x.scatter_reverse(la.InsertMode.add)
    found.x.scatter_forward()
    return np.asarray(found.x.array > 0)


def vertices(space: fem.FunctionSpace) -> np.ndarray:
    """Return the coordinates of the nodes (m), owned, then ghosts, shape (n, 3).

    The nodes of linear elements are the vertices.
    """
    return np.asarray(space.tabulate_dof_coordinates())


class Transfer:
    """Interpolation from the vertices of one mesh to points of another mesh of the same body.

    The points are the vertices, or for constants in cells the centers. The relation of the two
    meshes is found once. All methods are collective.
    """

    def __init__(self, source: fem.FunctionSpace, target: fem.FunctionSpace, *, h: float) -> None:
        """Find the points in the source mesh.

        Parameters
        ----------
        source : linear scalars on the mesh with known values.
        target : space on the other mesh.
        h : mesh size of the source (m); a vertex may lie outside by 1e-6 of it.
        """
        self._source, self._target = fem.Function(source), fem.Function(target)
        topology = target.mesh.topology
        self._cells = np.arange(topology.index_map(topology.dim).size_local, dtype=np.int32)
        self._meeting = fem.create_interpolation_data(
            target, source, self._cells, padding=OUTSIDE * h
        )
        reached = self(np.ones_like(self._source.x.array))  # a vertex that is not found gets 0
        if any_over_ranks(target.mesh.comm, not np.allclose(reached, 1.0)):
            raise StaffaError("the two meshes are not of the same body: a vertex has no cell")

    def __call__(self, values: np.ndarray) -> np.ndarray:
        """Return values at the target's points from those at the source's vertices, with ghosts."""
        self._source.x.array[:] = values
        self._target.interpolate_nonmatching(self._source, self._cells, self._meeting)
        self._target.x.scatter_forward()
        return np.asarray(self._target.x.array.copy())
