"""Energy functional: every force, matrix and reported energy is derived from it."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cached_property, partial

from staffa.backend.stack import PETSc

import numpy as np
import ufl
from dolfinx import fem

from staffa.backend import jit
from staffa.loads.forces import Forces
from staffa.model import axis
from staffa.model.contact import CrackFaces
from staffa.model.crack_fluid import CrackFluid
from staffa.model.densities import Rock, crack_density, crack_measure, strain, swelling
from staffa.model.domain import Domain
from staffa.model.external_loads import External, crack_volume_density
from staffa.model.fields import Spaces, State
from staffa.model.openings import Openings, cell_integrals
from staffa.model.quadrature import DEGREE, cell_middle, in_the_middle
from staffa.model.strain import elastic_strain
from staffa.model.temperature_properties import Spent
from staffa.physics.damage import is_quadratic
from staffa.physics.material import AXIAL
from staffa.physics.split import Contact, is_linear_in_g, is_quadratic_in_strain
from staffa.physics.strained import Strained
from staffa.physics.strength_surface import StrengthSurface
from staffa.records.step import Energies

# Part of the residual stiffness that carries nothing worth a word.
NEGLIGIBLE = 1e-3


def _is_continuous(field: fem.Function) -> bool:
    """Return True if a field has a gradient, and is not one number in each cell."""
    return bool(field.function_space.ufl_element().embedded_superdegree > 0)


class Energy(CrackFluid):
    """Energy int psi(e, a(alpha) + k_res) + Gc crack_density(alpha) - work of the loads.

    If temperature changes Gc, the second term is the energy spent at the last `book`, and
    int Gc (crack_density(alpha) - crack_density(alpha then)): energy once spent does not change.

    e is the elastic strain and psi(e, g) the energy density of the split, g psi(e) without one. The
    forms are compiled once; every method evaluates at the given state. All methods are collective.

    Attributes
    ----------
    state : the fields at which it is evaluated.
    external : the external loads.
    intact_stress : stress (Pa) of rock without damage at the current strain.
    total_strain, elastic_density, Gc : strain; energy density (J/m^3) of damaged rock; toughness
        (J/m^2); in forms.
    """

    def __init__(
        self,
        *,
        domain: Domain,
        spaces: Spaces,
        state: State,
        rock: Rock,
        external: External | None = None,
    ) -> None:
        """Compile the forms.

        Parameters
        ----------
        domain : the mesh.
        spaces : the function spaces.
        state : the fields.
        rock : properties of the rock.
        external : the external loads; None without any.
        """
        self.comm, self._mesh = domain.comm, domain.mesh
        self.state, self.law, self.elasticity = state, rock.law, rock.elasticity
        self.external = external or External(
            domain, spaces, Forces(), fem.Constant(domain.mesh, 0.0)
        )
        # True if forces are linear in u, and if the energy is quadratic in alpha.
        self.linear = is_quadratic_in_strain(rock.split, plane_stress=rock.plane_stress)
        linear_in_g = is_linear_in_g(rock.split, plane_stress=rock.plane_stress)
        self.quadratic = is_quadratic(rock.law) and linear_in_g
        self._negligible = 0.0 if linear_in_g else NEGLIGIBLE
        u, alpha, T = state.u, state.alpha, state.T
        dx, middle = axis.volume(domain, DEGREE), in_the_middle(domain)

        ell = rock_ell = rock.ell
        # Constants, not literals: the compiled forms then serve every set of numbers.
        numbers = ("ell", "residual_stiffness")
        constants = {
            name: fem.Constant(domain.mesh, float(getattr(rock, name))) for name in numbers
        }
        rock = replace(rock, **constants)
        self._residual_stiffness = constants["residual_stiffness"]

        stiffness_left = rock.law.a(alpha) + rock.residual_stiffness
        at_rest = fem.Function(spaces.u)

        split = rock.split
        if isinstance(split, StrengthSurface):
            split = split.beside(rock.residual_stiffness)
        self.faces = None  # of cracks that touch
        if isinstance(split, Contact):
            self.faces = CrackFaces(alpha, split, ell=rock_ell, h=domain.h, given=rock.given)

        def felt(e: ufl.core.expr.Expr) -> Strained:
            strained = rock.elasticity.strained
            return self.faces.felt(e, strained) if self.faces else strained(e)

        def density(e: ufl.core.expr.Expr) -> ufl.core.expr.Expr:
            return split.density(felt(e), stiffness_left)

        def stored(u: fem.Function) -> ufl.Form:
            """Return the elastic energy. With reduced elements, the energy of a change of volume,
            and a split's difference from g psi, are integrated at the center of each cell."""
            e = strain(u, T, rock)
            if not spaces.reduced:
                return density(e) * dx
            isochoric = stiffness_left * rock.elasticity.strained(e).isochoric
            return isochoric * dx + (density(e) - isochoric) * middle

        def potential(u: fem.Function) -> ufl.Form:
            """Return all of the energy that depends on the displacement."""
            elastic = stored(u)
            loads = self.external.potential(u, alpha, cold, dx)
            return elastic if loads is None else elastic + loads

        cold = swelling(T, rock, 3 if rock.state == AXIAL else domain.dim)
        loads = self.external.potential(u, alpha, cold, dx)
        density_spent = crack_density(alpha, rock)
        self.of_temperature = rock.of_temperature
        self.spent: Spent | None = None
        if "Gc" in rock.of_temperature:
            self.spent = Spent(alpha=fem.Function(spaces.alpha))
            density_spent -= crack_density(self.spent.alpha, rock)
        surface = rock.Gc * density_spent * dx
        total = potential(u) + surface
        # For `measure.energy_release`, which moves the mesh; fixed: fields that do not move.
        self._crack_measure = crack_measure(alpha, rock)
        self.bulk, self.area = potential(u), self._crack_measure * dx
        given = [*self.external.fields, *([rock.prestress] if rock.prestress else [])]
        given += [f for f in self.bulk.coefficients() if f not in (u, alpha, T, *given)]
        self.fixed = [T, *(f for f in given if _is_continuous(f))]

        self._on_body = (loads, spaces.u)
        v, beta = ufl.TestFunction(spaces.u), ufl.TestFunction(spaces.alpha)
        self.direction = fem.Function(spaces.alpha, name="temperature change")
        self.pressing = fem.Function(spaces.alpha, name="pressure change")
        residual = ufl.derivative(potential(u), u, v)
        gradient = ufl.derivative(total, alpha, beta)
        # The variation of alpha^4 measures cracks of any shape: diffuse damage hardly counts.
        variation = 0.5 * ufl.sqrt(ufl.dot(ufl.grad(alpha**4), ufl.grad(alpha**4)))
        length_dx = axis.volume(domain, 4)
        in_cracks = crack_volume_density(domain, u, alpha, cold) * dx
        self._in_cracks = (in_cracks, alpha * cold * dx, u, v)

        self.total_strain = elastic_strain(u, ufl.zero((3, 3)), rock.state)
        self.elastic_density, self.Gc = density(strain(u, T, rock)), rock.Gc
        e = ufl.variable(strain(u, T, rock))
        self._stress_density = ufl.diff(density(e), e)
        self.intact_stress = ufl.diff(rock.elasticity.strained(e).psi, e)
        lost = self.intact_stress - self._stress_density
        if self.external.forces.in_cracks:  # the fluid's share of the traction
            lost += alpha * self.external.in_excess() * ufl.Identity(lost.ufl_shape[0])
        self._opening_strain = lambda n: rock.elasticity.opened(ufl.sym(lost), n)
        self.strained: Callable[[], Strained] = lambda: rock.elasticity.strained(strain(u, T, rock))
        self._dx, self._ell = (middle if spaces.reduced else dx), ell
        self.rest = Energies(elastic=0.0, surface=0.0)
        self._sums_u, self._sums_alpha = fem.Function(spaces.u), fem.Function(spaces.alpha)
        form = partial(jit.form, comm=domain.comm)
        self._elastic = form(stored(u))
        self._surface = form(surface)
        self._loads = None if loads is None else form(loads)
        self._total = form(total)
        if self.faces and self.faces.rubs:
            self.faces.measure(e, felt(e), self._stress_density, stiffness_left, dx)
        self._cracks = form(self.area)
        self._variation = form(variation * length_dx)
        power = ufl.derivative(total, T, self.direction)
        if self.external.forces.fluid:
            power += ufl.derivative(total, state.p, self.pressing)
        self._power = form(power)
        self._residual = form(residual)
        # Not by ufl.replace, whose cache would keep every mesh alive.
        self._load = form(-ufl.derivative(potential(at_rest), at_rest, v))
        self._stiffness = form(ufl.derivative(residual, u, ufl.TrialFunction(spaces.u)))
        self._gradient = form(gradient)
        self._hessian = form(ufl.derivative(gradient, alpha, ufl.TrialFunction(spaces.alpha)))
        self._mixed = form(ufl.derivative(gradient, u, ufl.TrialFunction(spaces.u)))
        self._resistance = form(rock.Gc / (4 * rock.law.c_w * rock.ell) * beta * dx)

    def energies(self) -> Energies:
        """Return elastic, surface, load and friction energy; see `count_from_here`."""
        rubbed, spent = self.faces.friction() if self.faces else (0.0, 0.0)
        return Energies(
            elastic=self.stored() - rubbed - self.rest.elastic,
            surface=self._surface_energy(),
            loads=self.loads() - self.rest.loads,
            friction=rubbed + spent,
            at_rest=self.rest.scale,
        )

    def count_from_here(self) -> None:
        """Count elastic energy and load energy from the current state.

        The energy that the prestress stores beforehand is no measure of what follows.
        """
        self.rest = Energies(elastic=self.stored(), surface=0.0, loads=self.loads())

    @property
    def frozen(self) -> tuple[fem.Function, ...]:
        """Fields besides the state that the energy depends on, and that change between steps."""
        return (self.faces.field,) if self.faces else ()

    def stored(self) -> float:
        """Return the whole elastic energy, and the work of friction in the current step."""
        return self._integral(self._elastic)

    def total(self) -> float:
        """Return the total energy, the sum of `energies`."""
        spent = self.spent.energy if self.spent else 0.0
        spent += self.faces.friction()[1] if self.faces else 0.0
        return self._integral(self._total) + spent + self._held_volume() - self.rest.total

    def _surface_energy(self) -> float:
        return self._integral(self._surface) + (self.spent.energy if self.spent else 0.0)

    def book(self) -> None:
        """Book the surface energy so far as spent, whatever Gc becomes."""
        if self.spent:
            self.spent.energy = self._surface_energy()
            self.spent.alpha.x.array[:] = self.state.alpha.x.array

    def loads(self) -> float:
        """Return minus the work of the loads; 0 without any, and of a fluid of given volume."""
        work = 0.0 if self._loads is None else self._integral(self._loads)
        return work + self._held_volume()

    def _held_volume(self) -> float:
        """Return the term that completes minus a fluid's work to p (volume given - volume held)."""
        return float(self.external.pressure.value) * self.external.volume

    @property
    def loaded(self) -> bool:
        """True if external loads act on the body."""
        return self._loads is not None

    def applied(self, out: PETSc.Vec) -> None:
        """Write the forces of the external loads: minus the derivative in u of their energy."""
        self._vector(self._applied, self._sums_u, out)

    @cached_property
    def _applied(self) -> fem.Form:
        """Form of the applied forces, compiled at its first use."""
        loads, space = self._on_body
        form = -ufl.derivative(loads, self.state.u, ufl.TestFunction(space))
        return jit.form(form, self.comm)

    @contextmanager
    def without_residual_stiffness(self) -> Iterator[None]:
        """Set the residual stiffness of broken rock to zero in this context.

        A split that is not linear in g may have no value there: it keeps a negligible part.
        """
        kept = float(self._residual_stiffness.value)
        self._residual_stiffness.value = self._negligible * kept
        try:
            yield
        finally:
            self._residual_stiffness.value = kept

    def crack_length(self) -> float:
        """Return surface energy over Gc at its position and direction: length in 2-D, area in 3-D.

        Collective.
        """
        return self._integral(self._cracks)

    def crack_lengths(self) -> np.ndarray:
        """Return the part of `crack_length` in each owned cell, shape (n,). Collective."""
        return cell_integrals(self._cracks_by_cell, self._sums_cell)

    @cached_property
    def _cracks_by_cell(self) -> fem.Form:
        test = ufl.TestFunction(self._sums_cell.function_space)
        return jit.form(self._crack_measure * test * self._dx, self.comm)

    @cached_property
    def _sums_cell(self) -> fem.Function:
        return fem.Function(fem.functionspace(self._mesh, ("Discontinuous Lagrange", 0)))

    def crack_variation(self) -> float:
        """Return 1/2 int |grad alpha^4|, the geometric length of the cracks (area in 3-D).

        Across a crack alpha rises from 0 to 1 and falls again: 1/2 (1 + 1) a unit of length,
        whatever the profile.
        """
        return self._integral(self._variation)

    def stress(self) -> np.ndarray:
        """Return the total stress (Pa) at the center of each owned cell, shape (n, 3, 3).

        It includes the part that pores carry. It is zero across the plane in plane stress.
        """
        cells = np.arange(self._mesh.topology.index_map(self._mesh.topology.dim).size_local)
        found = self._stress.eval(self._mesh, cells.astype(np.int32))
        size = self._stress_density.ufl_shape[0]
        stress = np.zeros((len(cells), 3, 3))
        stress[:, :size, :size] = found.reshape(len(cells), size, size)
        return stress

    @cached_property
    def openings(self) -> Openings:
        """Opening strain of cracks, cell by cell. Collective at its first use."""
        state, strain = self.state, self._opening_strain
        return Openings(state.u, state.alpha, strain, ell=self._ell, dx=self._dx)

    @cached_property
    def _stress(self) -> fem.Expression:
        stress = ufl.sym(self._stress_density)
        pores = self.external.pore_pressure
        if pores is not None:
            biot = self.external.forces.biot
            stress -= biot * pores * ufl.Identity(stress.ufl_shape[0])
        return jit.expression(stress, cell_middle(self._mesh), self.comm)

    def thermal_power(self) -> float:
        """Return the derivative of the energy along the changes of temperature and of pressure."""
        return self._integral(self._power)
