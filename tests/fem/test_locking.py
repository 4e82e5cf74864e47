"""Nearly incompressible rock is as soft as it is, on all cells, whatever its split."""

import json
import re
from dataclasses import replace
from pathlib import Path

from staffa.backend.stack import MPI

import numpy as np
import pytest
import ufl
from dolfinx import fem
from dolfinx.fem.petsc import LinearProblem
from dolfinx.mesh import meshtags

from fem.test_opening import AT, LONG, NU, cooled, seen
from staffa.case.check.preview import preview
from staffa.case.reading.read import parse_case, read_case
from staffa.case.schema.case import Case
from staffa.case.values.elements import largest_nu
from staffa.errors import InputError
from staffa.evolution.output_fields import field_values
from staffa.evolution.problem import Problem
from staffa.evolution.session import Session
from staffa.evolution.system import build
from staffa.io.field_output import FieldWriter
from staffa.io.run_directory import open_run, read_manifest
from staffa.io.vtkhdf import read_vtkhdf
from staffa.minimize.alternate import equilibrium
from staffa.model.fields import at_vertices, linear_spaces, spaces_on, vertices
from staffa.model.numbering import Numbering
from staffa.physics.locking import too_stiff
from staffa.runs.resume import resume
from staffa.setup.build import problem
from support.bodies import needs_gmsh
from support.meshes import written
from support.restarting import assert_same, cut_run, finish, whole_run
from support.rings import INNER, OUTER, in_equilibrium, lame, quarter, widened

CELLS = ("quadrilateral", "triangle", "hexahedron", "tetrahedron")
CURES = dict(zip(CELLS, ("reduced", "quadratic") * 2, strict=True))


# --- Lame's ring: fault F12 ---

# Forms in 3-D take long to compile.
ALL = [
    *CELLS[:2],
    pytest.param("hexahedron", marks=pytest.mark.long),
    pytest.param("tetrahedron", marks=pytest.mark.slow),
]
# Each split, and two splits on either kind of cells.
DERIVED = [
    ("triangle", "none"),
    ("quadrilateral", "volumetric-deviatoric"),
    ("triangle", "spectral"),
    ("quadrilateral", "no-tension"),
]
OTHERS = [
    pytest.param(cells, split, marks=pytest.mark.long)
    for split in ("none", "volumetric-deviatoric", "spectral", "no-tension")
    for cells in ("quadrilateral", "triangle")
    if (cells, split) not in DERIVED
]


@pytest.mark.parametrize("cells", ALL)
def test_a_ring_widens_as_lame_says(cells: str) -> None:
    """Within 1 % at the inner side, by default; its stress within 3 % of the pressure. Linear
    elements lack about as much of it as is said, within a factor of 2.5: 1 to 20 %."""
    for nu in (0.45, 0.49):
        made = quarter(cells, 8, nu)
        assert made.elements == CURES[cells]
        found = widened(made)
        assert found.inner == pytest.approx(lame(nu, INNER), rel=0.01)
        assert found.stress < 0.03, f"radial stress off by {found.stress:.3f} of the pressure"
        linear = widened(quarter(cells, 8, nu, ["domain.elements=linear"])).inner
        lacking, said = 1 - linear / found.inner, too_stiff(nu, cells, 8)
        assert said / 2.5 < lacking < 2.5 * said, f"{nu}: {lacking:.4f} against {said:.4f}"


@pytest.mark.parametrize("cells", CELLS[:2])
def test_the_error_falls_fourfold_however_incompressible_the_rock_is(cells: str) -> None:
    """Sides are straight from vertex to vertex, so that a quadratic displacement gains no more."""
    for nu in (0.45, 0.4999):
        errors = [abs(widened(quarter(cells, n, nu)).inner / lame(nu, INNER) - 1) for n in (4, 8)]
        assert 3.5 < errors[0] / errors[1] < 5, f"nu = {nu}: {errors}"


def ring(gmsh) -> None:
    """Fault F12's ring: inner and outer side, and rock between them."""
    occ, model = gmsh.model.occ, gmsh.model
    disc, hole = occ.addDisk(0, 0, 0, OUTER, OUTER), occ.addDisk(0, 0, 0, INNER, INNER)
    occ.cut([(2, disc)], [(2, hole)])
    occ.synchronize()
    model.addPhysicalGroup(2, [tag for _, tag in model.getEntities(2)], name="rock")
    for _, tag in model.getEntities(1):
        radius = model.getBoundingBox(1, tag)[3]
        model.addPhysicalGroup(1, [tag], name="inner" if radius < 0.2 else "outer")


F12 = """
title = "A ring under pressure from within"
[domain]
mesh = "ring.msh"
[material]
nu = 0.49
Gc = 1e6
plane = "strain"
[damage]
ell = 0.03
split = "none"
[temperature]
profile = "none"
[forces]
inner = { pressure = { t = [0.0, 1.0], value = [0.0, 1.0] } }
[time]
t = [1.0]
[output]
at = [1.0]
probes = [{ name = "in", point = [0.1, 0.0] }]
"""


@needs_gmsh
def test_the_ring_of_the_fault_widens_as_lame_says(tmp_path: Path) -> None:
    """F12-lame: u_r(a) = 0.1649 for nu = 0.45 and 0.1680 for 0.49, within 1 %; it was 1.5 and 5.8 %
    too small, without a word. Sides of 63 edges cost half a per cent of it. Who keeps linear
    elements is told so: 5.2 % of it is locking."""
    written(tmp_path / "ring.msh", ring, h=0.01)
    (tmp_path / "lame.toml").write_text(F12)
    for nu, right in ((0.45, 0.1649), (0.49, 0.1680)):
        case = read_case(tmp_path / "lame.toml", [f"material.nu={nu}"])
        found = whole_run(case, tmp_path / f"{nu}")
        assert found.manifest.elements == "quadratic"
        assert found.steps[-1].probed[0][1] == pytest.approx(right, rel=0.01)
        assert not found.steps[-1].audit.violations
    kept = preview(read_case(tmp_path / "lame.toml", ["domain.elements=linear"]))
    said = re.search(r"about ([0-9.]+) % too stiff with 20", " ".join(kept.warnings))
    assert said and 4.5 < float(said[1]) < 6.5, kept.warnings


# --- public reports, each against Taylor and Hood's elements ---


def taylor_hood(made: Problem, push: tuple[float, float], nu: float) -> fem.Function:
    """The displacement of a plane strain body by quadratic displacement and linear pressure, which
    do not lock. E = 1; left is clamped; push: traction on the right."""
    mesh = made.domain.mesh
    V = fem.functionspace(mesh, ("Lagrange", 2, (2,)))
    Q = fem.functionspace(mesh, ("Lagrange", 1))
    spaces = ufl.MixedFunctionSpace(V, Q)
    (u, p), (v, q) = ufl.TrialFunctions(spaces), ufl.TestFunctions(spaces)
    mu, lambda_ = 1 / (2 * (1 + nu)), nu / ((1 + nu) * (1 - 2 * nu))
    e = ufl.sym(ufl.grad(u))
    form = (2 * mu * ufl.inner(e, ufl.grad(v)) - p * ufl.div(v)) * ufl.dx
    form += (-q * ufl.div(u) - p * q / lambda_) * ufl.dx
    far = made.domain.facets("right")
    tags = meshtags(mesh, 1, np.sort(far), np.ones(len(far), dtype=np.int32))
    ds = ufl.Measure("ds", mesh, subdomain_data=tags)(1)
    load = ufl.dot(fem.Constant(mesh, push), v) * ds + fem.Constant(mesh, 0.0) * q * ufl.dx
    dofs = fem.locate_dofs_topological(V, 1, made.domain.facets("left"))
    bc = fem.dirichletbc(np.zeros(2), dofs, V)
    solution = LinearProblem(
        ufl.extract_blocks(form),
        ufl.extract_blocks(load),
        u=[fem.Function(V), fem.Function(Q)],
        bcs=[bc],
        kind="mpi",
        petsc_options_prefix="taylor_hood_",
        petsc_options={
            "ksp_type": "preonly",
            "pc_type": "lu",
            "pc_factor_mat_solver_type": "mumps",
        },
    ).solve()
    return solution[0]


PANEL = """
[domain]
size = {size}
h = {h}
cells = "{cells}"
[material]
nu = 0.4999
Gc = 1e9
plane = "strain"
[damage]
ell = {h}
allow_coarse = true
[temperature]
profile = "none"
[forces]
right = {push}
[supports]
left = "clamped"
[time]
t = [1.0]
"""


def panel(cells: str, h: float, settings: tuple[str, ...] = (), *, cook: bool = True) -> Problem:
    """Cook's membrane, a block bent into the panel of sides 44 and 16; else a square that is pulled
    where it is not held."""
    size, push = ([48.0, 44.0], "{ y = 0.01 }") if cook else ([1.0, 1.0], "{ x = 0.01 }")
    text = PANEL.format(cells=cells, size=size, h=h, push=push)
    made = problem(parse_case(text, settings))
    x = made.domain.mesh.geometry.x
    if cook:
        x[:, 1] = 44 * x[:, 0] / 48 + x[:, 1] * (1 - 28 / 44 * x[:, 0] / 48)
    return made


def corner(x: np.ndarray, u: np.ndarray) -> np.ndarray:
    """The displacement of the vertex that lies furthest to the upper right."""
    found: np.ndarray = u[int(np.argmax(x[:, 0] + x[:, 1]))]
    return found


def moved(made: Problem) -> np.ndarray:
    """That of a panel under its forces."""
    system = in_equilibrium(made)
    try:
        return corner(vertices(system.spaces.alpha), at_vertices(system.state.u, system.spaces))
    finally:
        system.destroy()


@pytest.mark.parametrize(
    ("cook", "h", "axis"),
    [
        pytest.param(True, (3.0, 1.5), 1, id="cook"),
        pytest.param(False, (0.1, 0.04), 0, id="square", marks=pytest.mark.long),
    ],
)
def test_public_panels_move_as_mixed_elements_have_it(
    cook: bool, h: tuple[float, float], axis: int
) -> None:
    """Cook's membrane of Ferrite.jl's tutorial "Incompressible elasticity" (ferrite-fem.github.io),
    and the square that is held on one side and loaded on the other of "Element volume locking" in
    github.com/georgiosmalik/fenics-course, nu = 0.4999 in both: linear triangles and quadrilaterals
    are too stiff, Taylor and Hood's elements are not. (Four triangles to a square lock the least.)
    """
    push = (0.0, 0.01) if cook else (0.01, 0.0)
    u = taylor_hood(panel("triangle", h[1], cook=cook), push, 0.4999)
    x = u.function_space.tabulate_dof_coordinates()
    right = corner(x, u.x.array.reshape(-1, 2))[axis]
    for cells in CELLS[:2]:
        assert moved(panel(cells, h[0], cook=cook))[axis] == pytest.approx(right, rel=0.03), cells
        locked = moved(panel(cells, h[0], ("domain.elements=linear",), cook=cook))[axis]
        assert locked < 0.99 * right, f"{cells}: {locked:.4g} against {right:.4g}"


# --- one functional ---

PLATE = """
[domain]
size = [1.0, 0.5]
h = 0.1
cells = "{cells}"
[material]
nu = 0.48
plane = "strain"
[damage]
ell = 0.2
split = "{split}"
[toughness]
amplitude = 0.1
[temperature]
profile = "half-space"
severity = 8.0
[supports]
left = "rollers"
right = "rollers"
[time]
tau = [0.05, 0.1, 0.2, 0.4]
[output]
at = [0.2]
checkpoint = {{ steps = 1 }}
probes = [{{ name = "p", point = [0.52, 0.27] }}]
[solver]
backtracking = true
"""


def plate(cells: str, *settings: str, split: str = "none") -> Case:
    """A cooled plate that cracks."""
    return parse_case(PLATE.format(cells=cells, split=split), settings)


@pytest.mark.parametrize(("cells", "split"), DERIVED + OTHERS)
def test_forces_and_matrices_are_derivatives_of_one_energy(cells: str, split: str) -> None:
    """At a random state, by differences; a kernel with two quadrature rules once gave other
    matrices."""
    system = build(problem(plate(cells, split=split)))
    energy, state, rng = system.energy, system.state, np.random.default_rng(0)
    u0, alpha0 = (0.1 * rng.normal(size=len(f.x.array)) for f in (state.u, state.alpha))
    alpha0 = np.abs(alpha0)
    v, b = rng.normal(size=len(u0)), rng.normal(size=len(alpha0))
    K, C = energy.new_stiffness(), energy.new_mixed()
    force_u, force_alpha = K.createVecRight(), C.createVecLeft()
    step = 1e-6

    def at(t: float) -> tuple[float, np.ndarray, np.ndarray]:
        state.u.x.array[:], state.alpha.x.array[:] = u0 + t * v, alpha0 + t * b
        energy.residual(force_u)
        energy.gradient(force_alpha)
        return energy.total(), force_u.array.copy(), force_alpha.array.copy()

    (total, on_u, _), (less, before, _) = at(step), at(-step)
    _, here_u, here_alpha = at(0.0)
    slope = (total - less) / (2 * step)
    assert slope == pytest.approx(here_u @ v + here_alpha @ b, rel=1e-6)
    energy.stiffness(K)
    energy.mixed(C)
    direction, answer, across = K.createVecRight(), K.createVecRight(), C.createVecLeft()
    direction.array_w[:], across.array_w[:] = v, b
    K.mult(direction, answer)
    change = answer.array.copy()
    C.multTranspose(across, answer)
    change += answer.array
    assert np.abs((on_u - before) / (2 * step) - change).max() < 1e-6 * np.abs(change).max()
    for thing in (K, C, force_u, force_alpha, direction, answer, across):
        thing.destroy()
    system.destroy()


def test_a_body_that_only_shrinks_has_no_stress() -> None:
    """Temperature linear in space, free sides: a quadratic displacement follows it exactly, and
    only what plane strain holds is left across the plane."""
    made = problem(plate("triangle", 'supports.left="free"', 'supports.right="free"'))
    system = build(made)
    x = vertices(system.spaces.alpha)
    system.state.T.x.array[:] = x[:, 0] - 2 * x[:, 1]
    equilibrium(system.alternation, system.supports.values(0.0))
    stress = system.energy.stress()
    held = np.abs(stress[:, 2, 2]).max()
    stress[:, 2, 2] = 0.0
    assert held > 0.5 and np.abs(stress).max() < 1e-9 * held
    system.destroy()


@pytest.mark.slow
@pytest.mark.parametrize("cells", CELLS[:2])
def test_openings_are_the_jumps_across_cracks(cells: str, tmp_path: Path) -> None:
    """Two cracks that cold has opened, to 5 %: the strain across them is no longer constant in a
    cell."""
    made = replace(cooled(LONG / 5, "plane strain", cells=cells), elements=CURES[cells])
    found = seen(made, tmp_path / "fields.vtkhdf")
    right = found.reference(
        reach=2 * LONG / 5, expansion=1.0, rock=(1.0, NU, "plane strain"), rest=0.0
    )
    assert found.network.volume == pytest.approx(found.volume, rel=0.003)
    for x in AT.values():
        here = np.isfinite(right) & (np.abs(found.middles[:, 0] - x) < 0.2)
        size = found.network.sizes[here]
        assert size @ found.opening[here] == pytest.approx(size @ right[here], rel=0.05), x


# --- files, restarts ---


@pytest.mark.slow
@pytest.mark.parametrize("cells", CELLS[:2])
def test_a_run_that_is_cut_and_resumed_has_the_same_bits(cells: str, tmp_path: Path) -> None:
    expected = whole_run(plate(cells), tmp_path / "whole")
    cut_run(plate(cells), tmp_path / "cut", 8)
    finish(tmp_path / "cut", 12)
    assert_same(open_run(tmp_path / "cut"), expected)
    assert expected.steps[-1].energies.surface > 0.1


def test_fields_for_paraview_have_the_displacement_of_the_vertices(tmp_path: Path) -> None:
    """u of a quadratic displacement, read off again where the vertices are."""
    made = problem(plate("triangle"))
    system = build(made)
    system.state.u.interpolate(lambda x: (x[0] ** 2 - x[1], x[0] * x[1]))
    at_vertices, _ = field_values(Session(made, system), ["u"])
    FieldWriter(made.domain.comm, system.spaces).write(tmp_path / "u.vtkhdf", at_vertices)
    grid, fields = read_vtkhdf(tmp_path / "u.vtkhdf")
    x, y, _ = grid.points.T
    assert np.allclose(fields["u"], np.column_stack([x**2 - y, x * y, 0 * x]), atol=1e-14)
    system.destroy()


# --- which elements a case takes ---

CHOSEN = [
    ([], "quadratic"),
    (["material.nu=0.449"], "linear"),
    (["material.nu=0.45"], "quadratic"),
    (['material.plane="stress"'], "linear"),
    (["domain.cells=quadrilateral"], "reduced"),
    (["domain.elements=linear"], "linear"),
    (["material.nu=0.2", "regions.clay={lower=[0,0], upper=[1,0.1], nu=0.49}"], "quadratic"),
    (["material.nu={formula='0.3 + 0.3*y'}"], "linear"),
    (["material.nu={formula='0.3 + 0.31*y'}"], "quadratic"),
    (["material.nu={mean=0.4, variation=0.1, length=0.1}"], "quadratic"),
    (["material.nu=0.4", "domain.elements=quadratic"], "quadratic"),
]


@pytest.mark.parametrize(("settings", "elements"), CHOSEN, ids=str)
def test_nearly_incompressible_rock_takes_elements_that_do_not_lock(
    settings: list[str], elements: str
) -> None:
    assert plate("triangle", *settings).domain.elements == elements


def anisotropic(C: list[list[float]]) -> Case:
    """The plate of rock of this stiffness."""
    text = PLATE.format(cells="triangle", split="none")
    return parse_case(text.replace("nu = 0.48", f"stiffness = {C}"))


def test_rock_with_directions_counts_by_its_volume() -> None:
    """Moduli of isotropic rock of nu = 0.49 give that back; a stiff direction adds none."""
    nu = 0.49
    mu, lambda_ = 1 / (2 * (1 + nu)), nu / ((1 + nu) * (1 - 2 * nu))
    C = [[lambda_ + 2 * mu * (i == j) if i < 3 and j < 3 else mu * (i == j) for j in range(6)]
         for i in range(6)]  # fmt: skip
    case = anisotropic(C)
    assert largest_nu(case)[0] == pytest.approx(nu) and case.domain.elements == "quadratic"
    C[0][0] += 50.0
    assert largest_nu(anisotropic(C))[0] < 0.45


def test_check_says_which_elements_and_why() -> None:
    facts = {name: (value, why) for name, value, why in preview(plate("triangle")).facts}
    assert facts["elements"][0] == "quadratic" and "nu = 0.48" in facts["elements"][1]
    plain = preview(plate("triangle", "material.nu=0.3"))
    assert "elements" not in {name for name, *_ in plain.facts}
    # 5 cells across: 0.05 lambda/mu (1/5)^2, lambda/mu = 0.96/0.04
    kept = preview(plate("triangle", "domain.elements=linear", "domain.h=0.1"))
    assert any("about 4.6 % too stiff with 5 cells" in w for w in kept.warnings), kept.warnings
    assert not any("too stiff" in w for w in preview(plate("triangle")).warnings)


def test_below_the_limit_a_linear_displacement_is_what_it_was() -> None:
    """Its nodes are the vertices themselves, in the order of old checkpoints."""
    made = problem(plate("triangle", "material.nu=0.3"))
    spaces = linear_spaces(made.domain)
    assert spaces.nodes is spaces.alpha and not spaces.reduced
    order = Numbering(MPI.COMM_WORLD, spaces.alpha)
    geometry = made.domain.mesh.geometry
    whole = np.zeros_like(geometry.x)
    whole[geometry.input_global_indices] = geometry.x
    assert np.abs(order.points - whole).max() < 1e-15


def test_cells_without_such_elements_refuse_them() -> None:
    made = problem(plate("triangle", "material.nu=0.3"))
    with pytest.raises(InputError, match="triangle cells have no reduced elements; take quadratic"):
        spaces_on(made.domain, "reduced")


def test_a_run_of_an_older_staffa_is_not_gone_on_with_other_elements(tmp_path: Path) -> None:
    """Its manifest and its case tell of none: then they were linear."""
    cut_run(plate("quadrilateral"), tmp_path / "run", 6)
    file = tmp_path / "run" / "manifest.json"
    told = json.loads(file.read_text())
    assert told.pop("elements") == "reduced"
    file.write_text(json.dumps(told))
    assert read_manifest(tmp_path / "run").elements == "linear"
    with pytest.raises(InputError, match="was run with linear elements"):
        resume(tmp_path / "run")
