"""The one functional: every force, matrix, and reported energy is derived from it."""

from dataclasses import dataclass, replace
from functools import partial

from staffa.stack import PETSc

import ufl
from dolfinx import fem, la
from dolfinx.fem import petsc as fem_petsc

from staffa.domain import Domain
from staffa.fields import Spaces, State, read_vector
from staffa.jit import jit_options
from staffa.parallel import sum_over_ranks
from staffa.physics.damage import DamageLaw
from staffa.physics.material import PLANE_STRESS, energy_density, lame
from staffa.records import Energies

# Exact for the damaged stiffness of simplices; the 2 x 2 (x 2) Gauss rule of quadrilaterals.
QUADRATURE_DEGREE = 2


@dataclass(frozen=True, kw_only=True)
class Rock:
    """Elasticity, toughness and damage of the body.

    E (Pa), nu, expansion (1/K); Gc: toughness (J/m^2) a cell; ell: regularization length (m);
    residual_stiffness: fraction k_res left in a crack; state: "plane stress", "plane strain", or
    "solid" in 3-D.
    """

    E: float
    nu: float
    expansion: float
    Gc: fem.Function
    ell: float
    law: DamageLaw
    state: str
    residual_stiffness: float = 1e-6


def elastic_density(u: fem.Function, T: fem.Function, rock: Rock) -> ufl.core.expr.Expr:
    """psi(e(u) - e_th(T)), undamaged.

    In plane strain the out-of-plane elastic strain is -expansion T; in plane stress it has been
    minimized out (see `physics.material.lame`).
    """
    strain = ufl.sym(ufl.grad(u))
    thermal = rock.expansion * T
    elastic = strain - thermal * ufl.Identity(len(u))
    trace, square = ufl.tr(elastic), ufl.inner(elastic, elastic)
    if rock.state != PLANE_STRESS and len(u) == 2:
        trace, square = trace - thermal, square + thermal**2
    return energy_density(trace, square, *lame(rock.E, rock.nu, rock.state))


def crack_density(alpha: fem.Function, rock: Rock) -> ufl.core.expr.Expr:
    """1/(4 c_w) (w(alpha)/ell + ell |grad alpha|^2): crack length an area, or area a volume."""
    gradient = ufl.grad(alpha)
    local = rock.law.w(alpha) / rock.ell
    return (local + rock.ell * ufl.dot(gradient, gradient)) / (4 * rock.law.c_w)


class Energy:
    """E(u, alpha; T) = int (a(alpha) + k_res) psi(e(u) - e_th(T)) + Gc crack_density(alpha).

    The forms are compiled once; every method evaluates at the state that was given. All methods
    are collective.
    """

    def __init__(self, *, domain: Domain, spaces: Spaces, state: State, rock: Rock) -> None:
        self.comm = domain.comm
        self.state, self.law = state, rock.law
        u, alpha, T = state.u, state.alpha, state.T
        dx = ufl.Measure("dx", domain.mesh, metadata={"quadrature_degree": QUADRATURE_DEGREE})

        # Constants, not literals: the compiled forms then serve every set of numbers.
        numbers = ("E", "nu", "expansion", "ell", "residual_stiffness")
        constants = {
            name: fem.Constant(domain.mesh, float(getattr(rock, name))) for name in numbers
        }
        rock = replace(rock, **constants)

        stiffness_left = rock.law.a(alpha) + rock.residual_stiffness
        at_rest = fem.Function(spaces.u)

        def elastic_energy(u: fem.Function) -> ufl.Form:
            return stiffness_left * elastic_density(u, T, rock) * dx

        elastic = elastic_energy(u)
        cracks = crack_density(alpha, rock)
        surface = rock.Gc * cracks * dx
        total = elastic + surface

        v, beta = ufl.TestFunction(spaces.u), ufl.TestFunction(spaces.alpha)
        self.direction = fem.Function(spaces.alpha, name="temperature change")
        residual = ufl.derivative(elastic, u, v)
        gradient = ufl.derivative(total, alpha, beta)
        # Cracks of any shape count by the variation of alpha^4: diffuse damage hardly adds to it.
        variation = 0.5 * ufl.sqrt(ufl.dot(ufl.grad(alpha**4), ufl.grad(alpha**4)))
        length_dx = ufl.Measure("dx", domain.mesh, metadata={"quadrature_degree": 4})

        self._sums_u, self._sums_alpha = fem.Function(spaces.u), fem.Function(spaces.alpha)
        form = partial(fem.form, jit_options=jit_options(domain.comm))
        self._elastic = form(elastic)
        self._surface = form(surface)
        self._total = form(total)
        self._cracks = form(cracks * dx)
        self._variation = form(variation * length_dx)
        self._power = form(ufl.derivative(elastic, T, self.direction))
        self._residual = form(residual)
        # Not by ufl.replace, whose cache would keep every mesh there ever was.
        self._load = form(-ufl.derivative(elastic_energy(at_rest), at_rest, v))
        self._stiffness = form(ufl.derivative(residual, u, ufl.TrialFunction(spaces.u)))
        self._gradient = form(gradient)
        self._hessian = form(ufl.derivative(gradient, alpha, ufl.TrialFunction(spaces.alpha)))
        self._mixed = form(ufl.derivative(gradient, u, ufl.TrialFunction(spaces.u)))
        self._resistance = form(rock.Gc / (4 * rock.law.c_w * rock.ell) * beta * dx)

    def _integral(self, form: fem.Form) -> float:
        return sum_over_ranks(self.comm, fem.assemble_scalar(form))

    def _vector(self, form: fem.Form, sums: fem.Function, out: PETSc.Vec) -> None:
        sums.x.array[:] = 0.0
        fem.assemble_vector(sums.x.array, form)
        sums.x.scatter_reverse(la.InsertMode.add)
        read_vector(sums, out)

    def _matrix(self, form: fem.Form, out: PETSc.Mat) -> None:
        out.zeroEntries()
        fem_petsc.assemble_matrix(out, form)
        out.assemble()

    def energies(self) -> Energies:
        """Elastic and surface energy."""
        return Energies(
            elastic=self._integral(self._elastic), surface=self._integral(self._surface)
        )

    def total(self) -> float:
        """Elastic plus surface energy."""
        return self._integral(self._total)

    def crack_length(self) -> float:
        """Surface energy over Gc, toughness variations divided out: length in 2-D, area in 3-D."""
        return self._integral(self._cracks)

    def crack_variation(self) -> float:
        """1/2 int |grad alpha^4|: length of the cracks by their geometry (area in 3-D).

        Across a crack alpha rises from 0 to 1 and falls again: 1/2 (1 + 1) a unit of length,
        whatever the profile.
        """
        return self._integral(self._variation)

    def thermal_power(self) -> float:
        """Derivative of the energy along the temperature change held in `direction`."""
        return self._integral(self._power)

    def stiffness(self, out: PETSc.Mat) -> None:
        """Second derivative in u: no supports in it."""
        self._matrix(self._stiffness, out)

    def load(self, out: PETSc.Vec) -> None:
        """Thermal forces: minus the derivative in u at u = 0."""
        self._vector(self._load, self._sums_u, out)

    def residual(self, out: PETSc.Vec) -> None:
        """Derivative in u."""
        self._vector(self._residual, self._sums_u, out)

    def gradient(self, out: PETSc.Vec) -> None:
        """Derivative in alpha."""
        self._vector(self._gradient, self._sums_alpha, out)

    def hessian(self, out: PETSc.Mat) -> None:
        """Second derivative in alpha."""
        self._matrix(self._hessian, out)

    def mixed(self, out: PETSc.Mat) -> None:
        """Derivative in alpha, then in u: rows of alpha, columns of u."""
        self._matrix(self._mixed, out)

    def resistance(self, out: PETSc.Vec) -> None:
        """int Gc/(4 c_w ell) phi_i: the unit in which forces on the damage are judged."""
        self._vector(self._resistance, self._sums_alpha, out)

    def new_stiffness(self) -> PETSc.Mat:
        """A matrix that `stiffness` can fill; the caller destroys it."""
        return fem_petsc.create_matrix(self._stiffness)

    def new_mixed(self) -> PETSc.Mat:
        """A matrix that `mixed` can fill; the caller destroys it."""
        return fem_petsc.create_matrix(self._mixed)

    def new_hessian(self) -> PETSc.Mat:
        """A matrix that `hessian` can fill; the caller destroys it."""
        return fem_petsc.create_matrix(self._hessian)
