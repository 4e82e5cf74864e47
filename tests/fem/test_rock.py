"""Rock of a case that varies, has directions and differs by region, as the objects of a problem."""

from dataclasses import fields
from pathlib import Path

from staffa.backend.stack import MPI

import numpy as np
import pytest
import pyvista

from staffa.case.check.preview import preview
from staffa.case.reading.read import parse_case, read_case
from staffa.case.scales.case_scales import derived_numbers
from staffa.case.schema.toml_text import to_toml
from staffa.case.values.attached_files import attached
from staffa.case.values.subdomains import averages, subdomains_of
from staffa.compare.differences import case_differences
from staffa.compare.open_pair import read_pair
from staffa.errors import InputError
from staffa.evolution.problem import Problem
from staffa.heat.thermal_body import Conduction, Conductor, Dirichlet
from staffa.heat.transient import HeatEquation
from staffa.io.run_directory import CASE
from staffa.model.domain import block, middles
from staffa.model.fields import linear_spaces, vertices
from staffa.physics.elasticity import Full, Isotropic, Orthotropic, TransverselyIsotropic
from staffa.runs.run import run as write_run
from staffa.setup.build import problem
from support.bodies import needs_gmsh, run
from support.meshes import plate, written

PLATE = """
[domain]
size = [2.0, 1.0]
h = 0.25
[damage]
ell = 0.5
[temperature]
dT = 3.0
[time]
tau = [0.1, 0.2, 0.4]
"""
BOX = ("domain.size=[1.0, 1.0, 1.0]", "domain.h=0.5")
HEATED = ('temperature={profile="heat"}', "heat={initial=1.0, bottom={T=0.0}}", "time={t=[0.1]}")
TOP = "lower=[0.0, 0.5], upper=[2.0, 1.0]"
SHALE = "E=4.0, nu=0.2, E_axis=2.0, nu_axis=0.25, G_axis=0.9"
X = np.array([[0.1, 1.3, 1.9], [0.2, 0.5, 0.9], [0.0, 0.0, 0.0]])


def built(*settings: str, folder: Path = Path()) -> Problem:
    return problem(parse_case(PLATE, settings, folder=folder), comm=MPI.COMM_SELF)


def test_a_formula_is_a_function_of_position() -> None:
    rock = built('material={E={formula="1 + x"}, nu={formula="0.1 + 0.1*y"}, Gc={formula="2*y"}}')
    assert rock.material.E(X) == pytest.approx(1 + X[0])
    assert rock.material.nu(X) == pytest.approx(0.1 + 0.1 * X[1])
    assert rock.material.Gc * rock.material.toughness(X) == pytest.approx(2 * X[1])


def test_a_random_property_has_its_own_field_and_one_seed_moves_two_together() -> None:
    random = "{mean=%s, variation=0.2, length=0.5, seed=%d}"
    m = built(
        f"material={{E={random % (3.0, 1)}, Gc={random % (5.0, 1)}, expansion={random % (2.0, 2)}}}"
    ).material
    E, Gc, expansion = m.E(X) / 3, m.Gc * m.toughness(X) / 5, m.expansion(X) / 2
    assert pytest.approx(Gc) == E and np.abs(expansion - E).max() > 0.01
    assert m.Gc == 5.0


def test_what_stands_in_toughness_multiplies_a_toughness_that_varies() -> None:
    band = "toughness.bands=[{lower=[1.0,0.0], upper=[2.0,1.0], factor=3.0}]"
    m = built('material.Gc={formula="2*y"}', band, f"regions.cap={{{TOP}, Gc=7.0}}")
    factor = np.array([1.0, 3.0, 3.0])
    assert m.material.Gc * m.material.toughness(X) == pytest.approx(2 * X[1] * factor)
    cap = m.regions["cap"]
    assert cap.Gc * cap.toughness(X) == pytest.approx(7 * factor)


def test_a_field_of_a_file_counts_from_the_case_and_is_interpolated(tmp_path) -> None:
    folder = tmp_path / "deep"
    folder.mkdir()
    (folder / "my.toml").write_text(PLATE + '[material]\nE = { file = "E.vtu", name = "E" }\n')
    _write_field(folder / "E.vtu")
    case = read_case(folder / "my.toml")
    assert problem(case, comm=MPI.COMM_SELF).material.E(X) == pytest.approx(1 + X[0] + 2 * X[1])
    assert pytest.approx(3.0) == averages(subdomains_of(case)[0]).E, "the mean over the plate"
    assert case.material.E.file == "E.vtu" and attached(case) == (folder / "E.vtu",)
    assert parse_case(to_toml(case), folder=folder) == case


def test_a_run_keeps_the_files_of_its_fields_and_is_read_and_compared_without_them(
    tmp_path,
) -> None:
    (tmp_path / "data").mkdir()
    _write_field(tmp_path / "data" / "E.vtu")
    (tmp_path / "my.toml").write_text(
        SLAB.replace("[1.0, 0.5]", "[2.0, 1.0]").replace("0.05", "0.2").replace("0.1\n", "0.4\n")
        + '[material]\nE = { file = "data/E.vtu", name = "E" }\n'
    )
    case = read_case(tmp_path / "my.toml")
    for name in ("one", "other"):
        write_run(case, tmp_path / name, comm=MPI.COMM_SELF)
    (tmp_path / "data" / "E.vtu").unlink()
    assert read_case(tmp_path / "one" / CASE) == case
    pair = read_pair(tmp_path / "one", tmp_path / "other")
    assert pair.second.case == case and not case_differences(pair).rows
    _write_field(tmp_path / "other" / "E.vtu", width=3.0)
    ((name, first, second),) = case_differences(read_pair(*(s.run.path for s in pair.sides))).rows
    assert name == "E.vtu" and first != second


def test_files_of_one_name_are_refused(tmp_path) -> None:
    for place in (tmp_path, tmp_path / "deep"):
        place.mkdir(exist_ok=True)
        _write_field(place / "E.vtu")
    given = [f'material.{p}={{file="{place}E.vtu", name="E"}}' for p, place in TWO_PLACES.items()]
    with pytest.raises(InputError, match="have one name, by which a run keeps them; rename one"):
        parse_case(PLATE, given, folder=tmp_path)
    assert parse_case(PLATE, [given[0], given[0].replace("E=", "Gc=", 1)], folder=tmp_path)


TWO_PLACES = {"E": "", "Gc": "deep/"}


def _write_field(path, width: float = 2.0) -> None:
    points = np.array([[0.0, 0, 0], [width, 0, 0], [width, 1, 0], [0, 1, 0]])
    cells, types = np.array([3, 0, 1, 2, 3, 0, 2, 3]), np.array([5, 5], dtype=np.uint8)
    mesh = pyvista.UnstructuredGrid(cells, types, points)
    mesh.point_data["E"] = 1 + points[:, 0] + 2 * points[:, 1]
    mesh.save(path)


def test_a_file_that_does_not_cover_the_body_is_refused_by_check(tmp_path) -> None:
    _write_field(tmp_path / "E.vtu", width=1.0)
    given = 'material.E={file="E.vtu", name="E"}'
    with pytest.raises(InputError, match=r"material.E = .*its mesh does not reach \[1"):
        parse_case(PLATE, [given], folder=tmp_path)
    left = f"regions.left={{lower=[0,0], upper=[1,1], {given.removeprefix('material.')}}}"
    assert built(left, folder=tmp_path).regions["left"].E(X[:, :1]) == pytest.approx([1.5])


def test_a_region_has_its_own_numbers_and_the_bodys_others() -> None:
    found = built("material={E=2.0, nu=0.3, Gc=5.0}", f"regions.cap={{{TOP}, E=7.0}}")
    cap = found.regions["cap"]
    assert (found.material.E, cap.E, cap.nu, cap.Gc) == (2.0, 7.0, 0.3, 5.0)
    same = {f.name for f in fields(cap)} - {"E"}
    assert {n for n in same if getattr(cap, n) is not getattr(found.material, n)} <= {
        "Gc", "nu", "expansion", "toughness", "laws"
    }  # fmt: skip
    x = middles(found.domain.mesh)
    assert np.all(x[1, found.domain.cells("cap")] > 0.5)
    assert len(found.domain.cells("cap")) == 16


def test_of_regions_that_overlap_the_last_one_counts() -> None:
    more = "regions.lens={lower=[0.0,0.5], upper=[1.0,0.75], E=9.0}"
    found = built(f"regions.cap={{{TOP}, E=7.0}}", more).domain
    assert (len(found.cells("cap")), len(found.cells("lens"))) == (12, 4)


LAYERS = """
[domain]
h = 0.1
[domain.shape]
kind = "layers"
base = [2.0]
layers = [{ region = "sand", thickness = 0.4 }, { region = "shale", thickness = 0.6 }]
[damage]
ell = 0.3
[temperature]
dT = 3.0
[time]
t = [0.1]
"""
BOTH = ("regions.sand={E=2.0}", "regions.shale={}")
FLOOR = ('temperature.face="floor"', "regions.sand={}", "regions.shale={}")


@needs_gmsh
def test_the_regions_of_a_shape_go_by_their_names() -> None:
    found = problem(parse_case(LAYERS, BOTH), comm=MPI.COMM_SELF)
    assert {name: rock.E for name, rock in found.regions.items()} == {"sand": 2.0, "shale": 1.0}
    assert np.all(middles(found.domain.mesh)[1, found.domain.cells("sand")] < 0.4)


@needs_gmsh
def test_where_a_shape_has_no_rock_a_formula_need_not_be_a_number() -> None:
    hole = 'domain={shape={kind="plate with hole", size=[2.0,2.0], radius=0.3}, h=0.1}'
    pole = "1/where((x-1)**2 + (y-1)**2 > 0.05, 1, 0)"
    settings = (hole, f'material.E={{formula="{pole}"}}')
    text = LAYERS[LAYERS.index("[damage]") :]
    case = parse_case(text, settings)
    assert (
        problem(case, comm=MPI.COMM_SELF).domain.dim == 2
        and averages(subdomains_of(case)[0]).E == 1.0
    )
    band = "where(abs(x - 0.31) < 0.02, -1, 1)"  # between the places that are looked at at first
    with pytest.raises(InputError, match=r"material.E = .*in the middle of every cell"):
        problem(parse_case(text, (hole, f'material.E={{formula="{band}"}}')))


@pytest.mark.parametrize(
    ("body", "setting", "said"),
    [
        ("hole", 'material.E={formula="y - 5"}', r"material.E = .* it is .* larger than zero"),
        ("hole", 'material.Gc={formula="0*x"}', r"material.Gc = .* it is 0 somewhere"),
        ("hole", 'material.E={formula="where(x,1,2)"}', r"it cannot be computed"),
        ("hole", 'material.E={formula="x<9"}', r"it is true or false and no number"),
        ("hole", 'material.nu={formula="0.7+0*x"}', r"material.nu = .* between -1 and 0.5"),
        ("layers", 'regions.sand.Gc={formula="0.2 - y"}', r"regions.sand.Gc = .* larger than zero"),
        ("mesh", 'material.E={formula="x - 2"}', r"material.E = .* larger than zero"),
        ("mesh", 'regions.shale.nu={formula="y - 1.5"}', r"regions.shale.nu = .* between -1 and"),
    ],
)
@needs_gmsh
def test_what_varies_on_a_shape_or_a_mesh_is_looked_at_first(tmp_path, body, setting, said) -> None:
    written(tmp_path / "plate.msh", plate, h=0.3)
    text = LAYERS if body == "layers" else LAYERS[LAYERS.index("[damage]") :]
    hole = 'domain={shape={kind="plate with hole", size=[2.0,2.0], radius=0.3}, h=0.1}'
    settings = {
        "hole": (hole, "regions={}"),
        "layers": BOTH,
        "mesh": ('domain.mesh="plate.msh"', 'cracks=[{name="fault"}]', *FLOOR),
    }
    with pytest.raises(InputError, match=said):
        parse_case(text, (*settings[body], setting), folder=tmp_path)


@needs_gmsh
def test_around_a_hole_a_formula_need_be_a_number_where_there_is_rock_only() -> None:
    hole = 'domain={shape={kind="plate with hole", size=[2.0,2.0], radius=0.3}, h=0.1}'
    away = "log((x-1)**2 + (y-1)**2)"
    text = LAYERS[LAYERS.index("[damage]") :]
    heat = ('temperature={profile="heat"}', f'heat={{initial={{formula="{away}"}},hole={{T=0.0}}}}')
    assert parse_case(text, (hole, *heat)).heat is not None
    assert parse_case(text, (hole, f'forces.prestress.xx={{formula="{away}"}}')).forces is not None
    with pytest.raises(InputError, match="not finite at x = 1, y = 1; it must be so everywhere"):
        parse_case(
            text, ("domain={size=[2.0,2.0],h=0.1}", *heat[:1], heat[1].replace("hole", "top"))
        )


@needs_gmsh
def test_a_face_may_be_called_like_a_key_of_its_table(tmp_path) -> None:
    def named(gmsh) -> None:
        plate(gmsh, fault=None)
        groups = {gmsh.model.getPhysicalName(*g): g for g in gmsh.model.getPhysicalGroups(1)}
        gmsh.model.removePhysicalName("west")
        gmsh.model.setPhysicalName(*groups["west"], "crack_prestress")

    written(tmp_path / "plate.msh", named, h=0.3)
    text = LAYERS[LAYERS.index("[damage]") :]
    load = 'forces.crack_prestress.pressure={formula="0.1*x*t"}'
    case = parse_case(text, ('domain.mesh="plate.msh"', *FLOOR, load), folder=tmp_path)
    assert case.forces is not None and case.forces.on("crack_prestress") is not None


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        (BOTH[:1], r"the body has a region 'shale', of which the case says nothing"),
        ((*BOTH, "regions.silt={}"), r"regions.silt: the body has no such region; it has sand"),
        ((*BOTH, "regions.sand.lower=[0,0]"), r"\[regions.sand\] has a box"),
    ],
)
def test_regions_that_a_shape_does_not_have_are_refused(settings, said) -> None:
    with pytest.raises(InputError, match=said):
        parse_case(LAYERS, settings)


def test_a_region_takes_elasticity_and_directions_each_as_a_whole() -> None:
    body = f"material={{{SHALE}, axis=[0.0,1.0], Gc=[3.0,1.0]}}"
    found = built(
        body,
        f"regions.turned={{{TOP}, axis=[1.0,0.0]}}",
        "regions.clay={lower=[0,0], upper=[1,0.25], E=1.0, nu=0.4, Gc=2.0}",
    )
    turned, clay = found.regions["turned"], found.regions["clay"]
    C, D = (m.elasticity.stiffness(X[:, :1])[0] for m in (found.material, turned))
    assert D[0, 0] == pytest.approx(C[1, 1]) and D[0, 0] != pytest.approx(C[0, 0])
    assert np.diag(turned.roughness) == pytest.approx([1, 9, 9])
    assert clay.elasticity is None and (clay.E, clay.nu, clay.roughness) == (1.0, 0.4, None)


CLASSES = [
    (f"material={{{SHALE}, axis=[0,1]}}", TransverselyIsotropic),
    ("material={E=[3,2], nu=[0.2], G=[1], angle=30}", Orthotropic),
    ('material={E=[3,2,1], nu=[0.2,0.1,0.2], G=[1,1,1], angle="0.5 rad"}', Orthotropic),
    (f"material={{stiffness={np.diag([3.0, 2, 1, 1, 1, 1]).tolist()}, angle=30}}", Full),
    ('material={E=[{formula="3 + x"},2], nu=[0.2], G=[1]}', Orthotropic),
]


@pytest.mark.parametrize(("given", "kind"), CLASSES, ids=lambda v: str(v)[:40])
def test_every_class_of_elasticity_arrives_as_one_and_is_definite(given, kind) -> None:
    case = parse_case(PLATE, [given])
    found = problem(case, comm=MPI.COMM_SELF).material
    assert type(found.elasticity) is kind
    C = found.elasticity.stiffness(X)
    assert C.shape == (3, 6, 6) and np.linalg.eigvalsh(C).min() > 0
    mean = averages(subdomains_of(case)[0])
    assert (found.E, found.nu) == (mean.E, mean.nu) and derived_numbers(case).sigma_c > 0
    assert parse_case(to_toml(case)) == case
    assert "has directions" in str(preview(case).facts)


def in_plane(C: np.ndarray) -> np.ndarray:
    """Compliance of stresses in the plane."""
    return np.linalg.inv(C)[np.ix_([0, 1, 5], [0, 1, 5])]


def test_in_plane_stress_what_is_left_out_along_the_third_axis_has_no_effect() -> None:
    few, all_ = (
        built(f"material={{{keys}, angle=30}}").material.elasticity.stiffness(X[:, :1])[0]
        for keys in (
            "E=[3,2], nu=[0.2], G=[1]",
            "E=[3,2,1.3], nu=[0.2,0.15,0.1], G=[1,0.4,0.7]",
        )
    )
    assert in_plane(few) == pytest.approx(in_plane(all_), rel=1e-12)


def test_bedding_is_the_same_by_axis_as_by_three_lists_and_an_angle() -> None:
    c, s = np.cos(np.radians(30)), np.sin(np.radians(30))
    bedded = built(f"material={{{SHALE}, axis=[{-s},{c}], expansion=[1,2], Gc=[3,1]}}").material
    # along the bedding, across it, out of the plane; nu12 = nu21 E1/E2
    lists = "E=[4,2,4], nu=[0.5,0.25,0.2], G=[0.9,0.9,1.6666666666666667]"
    listed = built(f"material={{{lists}, angle=30, expansion=[1,2,1], Gc=[3,1]}}").material
    C, D = (m.elasticity.stiffness(X[:, :1]) for m in (bedded, listed))
    assert pytest.approx(D, rel=1e-9, abs=1e-12) == C
    assert bedded.expansion == pytest.approx(listed.expansion)
    assert bedded.roughness[:2, :2] == pytest.approx(listed.roughness[:2, :2])
    assert pytest.approx(listed.E) == bedded.E and bedded.Gc == listed.Gc == 1.0


@pytest.mark.parametrize(("angle", "axis"), [(0.0, 0), (90.0, 1), (30.0, 0), (-75.0, 1)])
def test_a_crack_across_an_axis_costs_its_toughness(angle: float, axis: int) -> None:
    """Gc sqrt(n . A n), n the axis itself."""
    m = built(f"material={{Gc=[4.0, 2.5], angle={angle}}}").material
    radians = np.radians(angle + 90 * axis)
    n = np.array([np.cos(radians), np.sin(radians), 0.0])
    assert m.Gc == 2.5
    assert m.Gc * np.sqrt(n @ m.roughness @ n) == pytest.approx([4.0, 2.5][axis])


def test_in_3d_toughness_and_expansion_lie_along_the_axes() -> None:
    axes = "axes=[[0,0,2],[1,0,0]]"
    m = built(*BOX, f"material={{Gc=[6.0,4.0,2.0], expansion=[1.0,2.0,3.0], {axes}}}").material
    assert m.expansion == pytest.approx(np.diag([2.0, 3.0, 1.0]))
    assert m.roughness == pytest.approx(np.diag([4.0, 1.0, 9.0])) and m.Gc == 2.0


def test_the_conductivity_of_bedding_turns_with_it() -> None:
    load = built(*HEATED, "material={k=[4.0,2.0], axis=[1.0,1.0]}").load
    assert np.array(load.k) == pytest.approx(np.array([[3.0, -1.0], [-1.0, 3.0]]))
    turned = built(*HEATED, "material={k=[4.0,2.0], angle=-45}").load
    assert np.array(turned.k) == pytest.approx(np.array([[3.0, -1.0], [-1.0, 3.0]]))


def test_each_region_conducts_and_stores_heat_in_its_way() -> None:
    load = built(
        *HEATED,
        'material={k={formula="1 + x"}, rho=2.0, c={formula="3 + y"}}',
        f"regions.cap={{{TOP}, k=[4.0,2.0]}}",
        "heat.bands=[{lower=[0,0], upper=[1,1], k=0.5, capacity=0.1}]",
    ).load
    band = np.where(X[0] < 1, (0.5, 0.5, 0.5), 1.0)
    k = np.array(load.k)[0, 0] * load.k_factor(X)
    assert k == pytest.approx((1 + X[0]) * band)
    cap = load.regions["cap"]
    assert cap.k == ((4.0, 0.0), (0.0, 2.0)) and cap.k_factor(X) == pytest.approx(band)
    stored = np.where(X[0] < 1, 0.1, 1.0) * 2 * (3 + X[1])
    assert load.rho_c * load.rho_c_factor(X) == pytest.approx(stored)
    assert cap.rho_c * cap.rho_c_factor(X) == pytest.approx(stored)


def test_heat_crosses_two_layers_as_their_conductivities_share_the_drop() -> None:
    """Steady: T in the middle is k2/(k1 + k2) of what is held at the top, exact on these cells."""
    parts = {"cap": lambda x: x[1] > 0.5}
    domain = block(MPI.COMM_SELF, size=(0.5, 1.0), h=0.25, cells="quadrilateral", parts=parts)
    spaces = linear_spaces(domain)
    conduction = Conduction(
        k=((1.0, 0.0), (0.0, 1.0)),
        rho_c=1.0,
        regions={"cap": Conductor(k=((9.0, 0.0), (0.0, 3.0)), rho_c=2.0)},
        initial=lambda x: np.zeros(x.shape[1]),
        sides=(
            Dirichlet(side="bottom", T=lambda x, t: 0.0),
            Dirichlet(side="top", T=lambda x, t: 1.0),
        ),
    )
    heat = HeatEquation(domain, spaces, conduction)
    assert heat.operators.capacity.sum() == pytest.approx(0.25 * 1.0 + 0.25 * 2.0)
    T, _ = heat.advance(heat.start(), np.zeros_like(heat.start()), 0.0, 100.0)
    y = vertices(spaces.alpha)[:, 1]
    assert pytest.approx(np.where(y < 0.5, 1.5 * y, 0.5 + 0.5 * y), abs=1e-6) == T


def test_the_drop_at_which_damage_starts_is_that_of_the_weakest_region() -> None:
    """Plane stress: sigma_c/(E expansion), which goes as sqrt(Gc/E)/expansion."""
    sound, weak = (
        preview(parse_case(PLATE, [f"regions.cap={{{TOP}, Gc={Gc}}}"])) for Gc in (4.0, 0.25)
    )
    assert (
        derived_numbers(parse_case(PLATE)).dT_c
        == derived_numbers(parse_case(PLATE, [f"regions.cap={{{TOP}, Gc=4.0}}"])).dT_c
    )
    case = parse_case(PLATE, [f"regions.cap={{{TOP}, Gc=0.25}}"])
    assert derived_numbers(case).dT_c == pytest.approx(derived_numbers(parse_case(PLATE)).dT_c / 2)
    assert "in region 'cap'" in str(weak.facts) and "in region" not in str(sound.facts)


def test_a_property_that_no_rock_has_in_some_cell_is_refused_with_the_mesh() -> None:
    """Between the places at which a formula is tried."""
    spike = "where((x > 1.1) & (x < 1.15), -1, 1)"
    assert parse_case(PLATE, [f'material.E={{formula="{spike}"}}'])
    with pytest.raises(InputError, match=r"material.E = .*larger than zero in the middle"):
        built(f'material.E={{formula="{spike}"}}', "domain.h=0.05")


def test_isotropic_numbers_stay_numbers() -> None:
    found = built(f"regions.cap={{{TOP}, E=7.0}}")
    for material in (found.material, *found.regions.values()):
        assert material.elasticity is None and material.roughness is None
        assert type(material.E) is float and type(material.nu) is float


SLAB = """
[domain]
size = [1.0, 0.5]
h = 0.05
[damage]
ell = 0.1
[temperature]
profile = "slab"
dT = 8.0
[supports]
left = "rollers"
[time]
tau = [0.1, 0.3]
"""


def energies(*settings: str) -> np.ndarray:
    """Elastic and surface energy of each step of the slab."""
    steps = run(problem(parse_case(SLAB, settings), comm=MPI.COMM_SELF))
    return np.array([(step.energies.elastic, step.energies.surface) for step in steps])


@pytest.mark.slow
def test_a_full_stiffness_that_is_isotropic_gives_the_isotropic_runs_numbers() -> None:
    C = Isotropic(E=1.0, nu=0.2).stiffness(X[:, :1])[0].tolist()
    expected = energies()
    assert expected[-1, 1] > 0.1, "it cracks"
    assert energies(f"material.stiffness={C}") == pytest.approx(expected, rel=1e-10)
    assert energies("regions.a={lower=[0,0.25], upper=[1,0.5], nu=0.2}") == pytest.approx(
        expected, rel=1e-10
    )
