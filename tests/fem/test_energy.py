"""The energy's forces are its derivatives, and elasticity converges as it should."""

from staffa.backend.stack import MPI, PETSc

import numpy as np
import pytest
import ufl
from dolfinx import fem

from staffa.backend.jit import expression, form
from staffa.evolution.coefficients import CellValues
from staffa.evolution.coefficients import rock as rock_on
from staffa.evolution.system import build
from staffa.model.energy import Energy
from staffa.model.fields import linear_spaces, owned, vertices, zero_state
from staffa.physics.damage import AT1, AT2
from support.bodies import body, rates, rock

BODIES = {
    "plane stress": ((1.0, 0.6), 0.25, "quadrilateral", "plane stress"),
    "plane strain": ((1.0, 0.6), 0.25, "triangle", "plane strain"),
    "hexahedra": ((1.0, 0.6, 0.7), 0.35, "hexahedron", "solid"),
    "tetrahedra": ((1.0, 0.6, 0.7), 0.35, "tetrahedron", "solid"),
}


def arbitrary_energy(name: str, law) -> Energy:
    """At a state without any symmetry."""
    size, h, cells, state_name = BODIES[name]
    problem = body(size, h, cells=cells, material=rock(ell=0.3, law=law, state=state_name, nu=0.3))
    spaces = linear_spaces(problem.domain)
    state = zero_state(spaces)
    seeded = np.random.default_rng(1)
    state.u.x.array[:] = seeded.normal(size=state.u.x.array.size)
    state.alpha.x.array[:] = seeded.uniform(0.1, 0.8, size=state.alpha.x.array.size)
    state.T.x.array[:] = seeded.normal(size=state.T.x.array.size)
    material = rock_on(CellValues(problem.domain, problem.material, {}))
    return Energy(domain=problem.domain, spaces=spaces, state=state, rock=material)


def slopes(function, field: fem.Function, direction: np.ndarray, steps) -> np.ndarray:
    """One-sided difference quotients of a functional, at growing steps."""
    start, here = field.x.array.copy(), function()
    found = []
    for step in steps:
        field.x.array[:] = start + step * direction
        found.append((function() - here) / step)
    field.x.array[:] = start
    return np.array(found)


@pytest.mark.parametrize("law", [AT1(), AT2()], ids=["AT1", "AT2"])
@pytest.mark.parametrize("name", BODIES)
def test_forces_are_derivatives_of_the_energy(name: str, law) -> None:
    """E(x + s d) - E(x) - s g.d falls as s^2: Taylor's remainder at rate 2, in u and in alpha."""
    energy = arbitrary_energy(name, law)
    for field, fill, matrix in [
        (energy.state.u, energy.residual, energy.new_stiffness()),
        (energy.state.alpha, energy.gradient, energy.new_hessian()),
    ]:
        direction = np.random.default_rng(2).normal(size=field.x.array.size)
        matrix.assemble()
        vector = matrix.createVecRight()
        fill(vector)
        slope = float(vector.array_r @ direction[: len(vector.array_r)])
        steps = np.array([1e-2, 5e-3, 2.5e-3])
        remainder = np.abs(slopes(energy.total, field, direction, steps) - slope) * steps
        rate = rates(remainder, steps)
        assert np.all((rate > 1.95) & (rate < 2.05)), f"remainder falls at rates {rate}"


@pytest.mark.parametrize("name", BODIES)
def test_hessians_are_derivatives_of_the_forces(name: str) -> None:
    energy = arbitrary_energy(name, AT2())
    for field, fill, hessian, matrix in [
        (energy.state.u, energy.residual, energy.stiffness, energy.new_stiffness()),
        (energy.state.alpha, energy.gradient, energy.hessian, energy.new_hessian()),
    ]:
        hessian(matrix)
        direction = np.random.default_rng(3).normal(size=field.x.array.size)
        d, g0, g1 = (matrix.createVecRight() for _ in range(3))
        d.array_w[:] = direction[: len(d.array_r)]
        fill(g0)
        field.x.array[:] += 1e-6 * direction
        fill(g1)
        product = matrix * d
        difference = (g1 - g0) * 1e6 - product
        assert difference.norm() < 1e-5 * product.norm()


def test_thermal_power_is_the_derivative_in_temperature() -> None:
    energy = arbitrary_energy("plane strain", AT1())
    direction = np.random.default_rng(4).normal(size=energy.direction.x.array.size)
    energy.direction.x.array[:] = direction
    step = 1e-4
    up = slopes(energy.total, energy.state.T, direction, [step, -step]).mean()
    assert energy.thermal_power() == pytest.approx(up, rel=1e-8)


def test_load_is_the_residual_without_displacement() -> None:
    energy = arbitrary_energy("hexahedra", AT1())
    matrix = energy.new_stiffness()
    energy.stiffness(matrix)
    u, residual, load = (matrix.createVecRight() for _ in range(3))
    u.array_w[:] = owned(energy.state.u)
    energy.residual(residual)
    energy.load(load)
    difference = matrix * u - load - residual
    assert difference.norm() < 1e-12 * residual.norm()


@pytest.mark.slow
@pytest.mark.parametrize("name", BODIES)
def test_elasticity_converges_at_second_order(name: str) -> None:
    """Manufactured displacement: the L2 error of linear elements falls at rate 2, on both sides."""
    size, _, cells, state_name = BODIES[name]
    steps = [1 / 8, 1 / 16, 1 / 32] if len(size) == 2 else [1 / 4, 1 / 8, 1 / 16]
    errors = [displacement_error(size, h, cells, state_name) for h in steps]
    rate = rates(errors, steps)[-1]
    assert 1.85 < rate < 2.15, f"L2 error falls at rate {rate:.3f}: {errors}"


def displacement_error(size, h: float, cells: str, state_name: str) -> float:
    """Of the discrete solution with the body force and boundary values of a smooth one."""
    dim = len(size)
    size = (1.0,) * dim
    problem = body(size, h, cells=cells, material=rock(state=state_name, nu=0.3))
    mesh, spaces = problem.domain.mesh, linear_spaces(problem.domain)
    state = zero_state(spaces)
    material = rock_on(CellValues(problem.domain, problem.material, {}))
    energy = Energy(domain=problem.domain, spaces=spaces, state=state, rock=material)
    x = ufl.SpatialCoordinate(mesh)
    waves = [ufl.sin(2 * x[0] + k) * ufl.cos(1.5 * x[1] - k) for k in range(dim)]
    if dim == 3:
        waves = [wave * ufl.exp(x[2] / 2) for wave in waves]
    exact = ufl.as_vector(waves)
    from staffa.physics.material import lame

    lam, mu = lame(1.0, 0.3, state_name)
    strain = ufl.sym(ufl.grad(exact))
    factor = 1 + problem.material.residual_stiffness
    stress = factor * (lam * ufl.tr(strain) * ufl.Identity(dim) + 2 * mu * strain)
    test = ufl.TestFunction(spaces.u)
    dx = ufl.Measure("dx", mesh, metadata={"quadrature_degree": 5})
    force = fem.petsc.assemble_vector(form(-ufl.inner(ufl.div(stress), test) * dx, mesh.comm))
    force.ghostUpdate(addv=PETSc.InsertMode.ADD, mode=PETSc.ScatterMode.REVERSE)
    values = fem.Function(spaces.u)
    values.interpolate(expression(exact, spaces.u.element.interpolation_points, mesh.comm))
    matrix = energy.new_stiffness()
    energy.stiffness(matrix)
    fixed = boundary_dofs(problem.domain, spaces, dim)
    matrix.zeroRowsColumns(fixed, diag=1.0, x=values.x.petsc_vec, b=force)
    ksp = PETSc.KSP().create(mesh.comm)
    ksp.setOperators(matrix)
    ksp.setType("preonly")
    ksp.getPC().setType("lu")
    ksp.solve(force, state.u.x.petsc_vec)
    state.u.x.scatter_forward()
    gap = state.u - exact
    square = fem.assemble_scalar(form(ufl.inner(gap, gap) * dx, mesh.comm))
    return float(np.sqrt(mesh.comm.allreduce(square, op=MPI.SUM)))


def boundary_dofs(domain, spaces, dim: int) -> np.ndarray:
    facets = np.unique(np.concatenate(list(domain.boundaries.values())))
    found = fem.locate_dofs_topological(spaces.alpha, dim - 1, facets)
    return (found[:, None] * dim + np.arange(dim)).ravel().astype(np.int32)


def test_crack_variation_measures_a_drawn_crack() -> None:
    """A band drawn across the body with the AT2 profile has the length of the body's height."""
    ell, height = 0.05, 0.4
    problem = body((1.0, height), ell / 10, material=rock(ell=ell, law=AT2()))
    system = build(problem)
    x = vertices(system.spaces.alpha)[:, 0]
    system.state.alpha.x.array[:] = np.exp(-np.abs(x - 0.5) / ell)
    assert system.energy.crack_variation() == pytest.approx(height, rel=0.005)
    assert system.energy.crack_length() == pytest.approx(height, rel=0.005)
    system.destroy()
