"""Heat equation in space: C dT/dt = F(T, t), with every term but conduction at the vertices.

Elements are linear; capacity, boundary exchange, fluxes and sources are lumped at the vertices. So
a vertex gains heat only from warmer neighbors or its surroundings, if no angle of the cells is
obtuse. A sudden drop at a boundary makes no vertex warmer, as a consistent capacity would.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
import ufl
from dolfinx import fem, la
from dolfinx import mesh as dmesh
from dolfinx.fem import petsc as fem_petsc

from staffa.backend import jit
from staffa.backend.parallel import any_over_ranks, max_over_ranks
from staffa.backend.vectors import readable, writable
from staffa.errors import InputError, LoadError
from staffa.heat.thermal_body import (
    Conduction,
    Conductor,
    Dirichlet,
    FluidFilledCrack,
    Insulating,
    Neumann,
    OfSurface,
    PointValues,
    Robin,
    Values,
)
from staffa.model import axis
from staffa.model.domain import Domain
from staffa.model.fields import Spaces, owned, vertices
from staffa.model.temperature_properties import distinct, share_of
from staffa.physics.temperature import Law

# Heat meets a crack where alpha^16 is: it rises from 0 to 1 within a cell or two of the crack,
# while alpha itself is spread over 4 ell of rock that conducts. Over each of the crack's two faces
# its gradient sums to 1, whatever the profile.
SHARPNESS, QUADRATURE = 16, 8
# Part of a difference of temperatures over which the slope of a film coefficient is taken.
STEP = 1e-5


@dataclass(frozen=True, kw_only=True)
class HeatExchange:
    """Heat that enters at vertices from one cause (W): given, or h A (T_fluid - T); owned entries.

    Attributes
    ----------
    name : the cause.
    given, coefficient : given heat (W); heat transfer coefficient times area (W/K).
    bath : temperature of the fluid (K).
    film : function that returns `coefficient` at surface temperatures (K); None if it is constant.
    """

    name: str
    given: np.ndarray
    coefficient: np.ndarray
    bath: np.ndarray
    film: Callable[[np.ndarray], np.ndarray] | None = None

    def entering(self, T: np.ndarray) -> np.ndarray:
        """Return the heat that enters at these temperatures (K) (W)."""
        return np.asarray(self.given + self._at(T) * (self.bath - T))

    def slope(self, T: np.ndarray) -> np.ndarray:
        """Return its derivative in temperature (W/K)."""
        if self.film is None:
            return -self.coefficient
        apart = STEP * np.maximum(np.abs(self.bath - T), STEP * (np.abs(T) + 1.0))
        steepness = (self._at(T + apart) - self._at(T - apart)) / (2 * apart)
        return np.asarray(steepness * (self.bath - T) - self._at(T))

    def _at(self, T: np.ndarray) -> np.ndarray:
        return self.coefficient if self.film is None else self.film(T)


class HeatOperators:
    """Capacities, conduction and exchanges of a body; arrays have its owned entries. Collective.

    Attributes
    ----------
    capacity, held : heat capacity of the vertices (J/K); entries with a Dirichlet condition.
    initial, stress_free : temperature at t = 0, and without thermal strain (K).
    """

    def __init__(self, domain: Domain, spaces: Spaces, conduction: Conduction) -> None:
        self.comm = domain.comm
        self.conduction = conduction
        self.space = spaces.alpha
        self._x = vertices(spaces.alpha)[: spaces.alpha.dofmap.index_map.size_local].T
        self._alpha = fem.Function(spaces.alpha)
        phi, T = ufl.TestFunction(spaces.alpha), ufl.TrialFunction(spaces.alpha)
        dx, faces = _measures(domain, conduction)

        sharp = self._alpha**SHARPNESS
        rocks = _rocks(domain, conduction)
        k = _tensor(domain, rocks)
        left, degree = 1.0, 2
        if isinstance(conduction.cracks, Insulating):
            residual = fem.Constant(domain.mesh, conduction.cracks.residual)
            left, degree = 1 - sharp + residual, QUADRATURE
        factor = _in_cells(spaces, rocks, lambda rock, x: rock.k_factor(x))
        self.rocks, self.dx, self.degree = rocks, dx, degree
        self.flow: Callable[[ufl.core.expr.Expr], ufl.core.expr.Expr] = lambda gradient: (
            left * factor * ufl.dot(k, gradient)
        )
        flow = self.flow(ufl.grad(T))
        self._conduct = self._form(ufl.inner(flow, ufl.grad(phi)) * dx(degree=degree))
        rho_c = _in_cells(spaces, rocks, lambda rock, x: rock.rho_c * rock.rho_c_factor(x))
        self._storage = rho_c * phi
        self.capacity = self._lumped(rho_c * phi * dx(degree=1))
        self._volume = self._lumped(phi * dx(degree=1))
        self._areas = {
            side.side: self._lumped(phi * faces(number + 1))
            for number, side in enumerate(conduction.sides)
        }
        if isinstance(conduction.cracks, FluidFilledCrack):
            steepness = ufl.sqrt(ufl.dot(ufl.grad(sharp), ufl.grad(sharp)))
            self._faces = self._form(steepness * phi * dx(degree=QUADRATURE))
        self._crack_area = np.zeros(self._x.shape[1])
        self._held = self._held_entries(domain)
        self.held = np.concatenate([np.zeros(0, dtype=np.int32), *self._held.values()])
        self.matrix = fem_petsc.create_matrix(self._conduct)
        given = conduction.stress_free
        self.initial = self._at_start("initial", conduction.initial)
        self.stress_free = self._at_start("stress_free", given) if given else self.initial
        self._level = max_over_ranks(self.comm, self.initial)
        self._felt: np.ndarray | None = None
        self._in, self._out = (self.matrix.createVecRight() for _ in range(2))

    def _form(self, form: ufl.Form) -> fem.Form:
        return jit.form(form, self.comm)

    def _lumped(self, form: ufl.Form | fem.Form) -> np.ndarray:
        sums = fem.Function(self.space)
        compiled = form if isinstance(form, fem.Form) else self._form(form)
        fem.assemble_vector(sums.x.array, compiled)
        sums.x.scatter_reverse(la.InsertMode.add)
        return owned(sums).copy()

    @property
    def x(self) -> np.ndarray:
        """Positions of the owned entries (m), shape (3, n)."""
        return self._x

    def capacities(self) -> list[tuple[Law | None, np.ndarray]]:
        """Return the laws of the heat capacities, each with its part of `capacity` (J/K)."""
        rocks = [(rock.c_law, cells) for rock, cells in self.rocks]
        laws = distinct(rocks)
        if len(laws) == 1:
            return [(laws[0], self.capacity)]
        here = [self._storage * share_of(self.space.mesh, rocks, law) for law in laws]
        parts = [self._lumped(part * self.dx(degree=1)) for part in here]
        return list(zip(laws, parts, strict=True))

    def _held_entries(self, domain: Domain) -> dict[str, np.ndarray]:
        """Return owned entries of each Dirichlet boundary; a vertex of two is the first's."""
        taken = np.zeros(self._x.shape[1], dtype=bool)
        found = {}
        for side in self._sides(Dirichlet):
            entries = fem.locate_dofs_topological(
                self.space, domain.dim - 1, domain.facets(side.side)
            )
            entries = entries[entries < len(taken)]
            found[side.side] = entries[~taken[entries]]
            taken[entries] = True
        return found

    def _sides[S: (Dirichlet, Neumann, Robin)](self, kind: type[S]) -> list[S]:
        return [side for side in self.conduction.sides if isinstance(side, kind)]

    def feel(self, alpha: np.ndarray) -> bool:
        """Update the heat flow to the damage (ghosts included); return True if it changed."""
        cracks, known = self.conduction.cracks, self._felt
        if known is not None and (cracks is None or self._same(alpha, known)):
            return False
        self._felt = alpha.copy()
        self._alpha.x.array[:] = alpha
        if isinstance(cracks, FluidFilledCrack):
            self._crack_area = self._lumped(self._faces)
            if known is not None:
                return True
        self.matrix.zeroEntries()
        fem_petsc.assemble_matrix(self.matrix, self._conduct)
        self.matrix.assemble()
        return True

    def _same(self, alpha: np.ndarray, known: np.ndarray) -> bool:
        return not any_over_ranks(self.comm, not np.array_equal(alpha, known))

    def _at_start(self, name: str, given: PointValues) -> np.ndarray:
        try:
            return self._at(name, lambda x, t: given(x), 0.0)
        except LoadError as error:
            raise InputError(str(error)) from None

    def held_values(self, t: float) -> np.ndarray:
        """Return the prescribed temperatures (K) of the entries `held` at time t (s)."""
        parts = [
            self._at(f"{side.side}.T", side.T, t, self._held[side.side])
            for side in self._sides(Dirichlet)
        ]
        return np.concatenate([np.zeros(0), *parts])

    def held_by_side(self) -> Iterator[tuple[str, slice]]:
        """Yield the positions in `held` of the entries of each Dirichlet boundary."""
        start = 0
        for name, entries in self._held.items():
            yield name, slice(start, start + len(entries))
            start += len(entries)

    def exchanges(self, t: float) -> list[HeatExchange]:
        """Return the heat exchange of each cause but Dirichlet boundaries at time t (s)."""
        found = []
        for film in self._sides(Robin):
            area = self._areas[film.side]
            found.append(self._film(film.side, area, film.h, film.T, t))
        for inflow in self._sides(Neumann):
            area = self._areas[inflow.side]
            where, entering = np.flatnonzero(area), np.zeros_like(area)
            entering[where] = self._at(f"{inflow.side}.flux", inflow.q, t, where) * area[where]
            found.append(_given(inflow.side, entering))
        made = self._at("source", self.conduction.source, t) * self._volume
        found.append(_given("source", made))
        cracks = self.conduction.cracks
        if isinstance(cracks, FluidFilledCrack):
            found.append(self._film("cracks", self._crack_area, cracks.h, cracks.T, t))
        return found

    def _film(
        self, name: str, area: np.ndarray, h: Values | OfSurface, T: Values, t: float
    ) -> HeatExchange:
        where = np.flatnonzero(area)
        coefficient, bath = np.zeros_like(area), np.zeros_like(area)
        bath[where] = self._at(f"{name}.T", T, t, where)
        film = None
        if isinstance(h, OfSurface):
            film = partial(self._coefficient, f"{name}.h", h, t, area)
        else:
            coefficient[where] = self._at(f"{name}.h", h, t, where, least=0.0) * area[where]
        return HeatExchange(
            name=name, given=0 * area, coefficient=coefficient, bath=bath, film=film
        )

    def _coefficient(
        self, name: str, h: OfSurface, t: float, area: np.ndarray, T: np.ndarray
    ) -> np.ndarray:
        """Return h A (W/K) of a surface at temperatures (K), owned entries."""
        where, found = np.flatnonzero(area), np.zeros_like(area)
        surface = T[where]
        found[where] = area[where] * self._at(
            name, lambda x, t: h.at(x, t, surface), t, where, least=0.0
        )
        return found

    def _at(
        self,
        name: str,
        values: Values,
        t: float,
        entries: np.ndarray | None = None,
        least: float = -np.inf,
    ) -> np.ndarray:
        """Return prescribed values at owned entries, by default all; refuse impossible values."""
        x = self._x if entries is None else self._x[:, entries]
        with np.errstate(all="ignore"):  # what is not finite is said below
            found = np.broadcast_to(values(x, t), x.shape[1:]).astype(float)
        if any_over_ranks(self.comm, not np.all(np.isfinite(found) & (found >= least))):
            rule = "finite" if least < 0 else "finite and not negative"
            raise LoadError(
                f"heat.{name} must be {rule} everywhere, and is not at time {t:.6g}; fix its "
                f"formula"
            )
        return found

    def conducted(self, T: np.ndarray) -> np.ndarray:
        """Return the heat that flows to the vertices from their neighbors (W), owned entries."""
        writable(self._in)[:] = T - self._level  # of an even temperature exactly nothing flows
        self.matrix.mult(self._in, self._out)
        return -readable(self._out)

    def destroy(self) -> None:
        """Free the PETSc objects."""
        for thing in (self.matrix, self._in, self._out):
            thing.destroy()


def _given(name: str, heat: np.ndarray) -> HeatExchange:
    return HeatExchange(name=name, given=heat, coefficient=0 * heat, bath=0 * heat)


# A rock and its local cells, ghosts included.
Rocks = list[tuple[Conductor, np.ndarray]]


def _rocks(domain: Domain, conduction: Conduction) -> Rocks:
    """Return the rock of the body, in all cells, then those of its regions, which override it."""
    cells = domain.mesh.topology.index_map(domain.dim)
    every = np.arange(cells.size_local + cells.num_ghosts, dtype=np.int32)
    body = Conductor(
        k=conduction.k,
        rho_c=conduction.rho_c,
        k_factor=conduction.k_factor,
        rho_c_factor=conduction.rho_c_factor,
        k_law=conduction.k_law,
        c_law=conduction.c_law,
    )
    regions = [(rock, domain.cells(name)) for name, rock in conduction.regions.items()]
    return [(body, every), *regions]


def _tensor(domain: Domain, rocks: Rocks) -> fem.Constant | fem.Function:
    """Return the conductivity without its factor: one for all, or one a cell."""
    shape = (domain.dim, domain.dim)
    if len(rocks) == 1:
        return fem.Constant(domain.mesh, np.array(rocks[0][0].k, dtype=float))
    k = fem.Function(fem.functionspace(domain.mesh, ("DG", 0, shape)))
    entries = k.x.array.reshape(-1, *shape)
    for rock, cells in rocks:
        entries[k.function_space.dofmap.list[cells, 0]] = rock.k
    return k


def _in_cells(
    spaces: Spaces, rocks: Rocks, value: Callable[[Conductor, np.ndarray], np.ndarray]
) -> fem.Function:
    """Return the value of each rock at the centers of its cells."""
    found = fem.Function(spaces.cell)
    x = spaces.cell.tabulate_dof_coordinates().T
    for rock, cells in rocks:
        entries = spaces.cell.dofmap.list[cells, 0]
        found.x.array[entries] = value(rock, x[:, entries])
    return found


def _measures(domain: Domain, conduction: Conduction) -> tuple[axis.Measure, axis.Measure]:
    """Return the measures of the volume and of the boundaries, numbered from 1 in their order."""
    dim = domain.dim
    facets = [domain.facets(side.side) for side in conduction.sides]
    numbers = [np.full(len(f), n + 1, dtype=np.int32) for n, f in enumerate(facets)]
    entities = np.concatenate([np.zeros(0, dtype=np.int32), *facets])
    values = np.concatenate([np.zeros(0, dtype=np.int32), *numbers])
    order = np.argsort(entities, kind="stable")
    tags = dmesh.meshtags(domain.mesh, dim - 1, entities[order], values[order])
    return axis.volume(domain), axis.surface(domain, tags)
