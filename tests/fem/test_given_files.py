"""Fields in files: their units, what they cover, and temperatures and sides by them."""

from collections.abc import Callable
from pathlib import Path

from staffa.backend.stack import MPI

import numpy as np
import pytest
import pyvista

from staffa.case.check.preview import preview
from staffa.case.reading.read import parse_case, read_case
from staffa.case.scales.surface_cooling import surface_exchanges
from staffa.case.schema.toml_text import to_toml
from staffa.case.values.attached_files import attached
from staffa.case.values.subdomains import averages, subdomains_of
from staffa.errors import InputError
from staffa.heat.thermal_body import Conduction
from staffa.io.run_directory import CASE
from staffa.runs.run import run
from staffa.setup.build import problem
from support import meshes
from support.bodies import needs_gmsh

METERS = """
[domain]
size = ["0.6 m", "0.3 m"]
h = "0.05 m"
[material]
E = { file = "E.vtu", name = "E" }
Gc = "100 J/m^2"
[damage]
ell = "0.15 m"
[temperature]
profile = "none"
[supports]
left = "rollers"
right = { x = "1e-6 m" }
[time]
t = ["1 s"]
"""
HEATED = """
[domain]
size = [2.0, 1.0]
h = 0.25
[damage]
ell = 0.75
[material]
nu = 0.2
[temperature]
profile = "heat"
[heat]
initial = { file = "T0.vtu", name = "T" }
bottom = { T = 0.0 }
[time]
t = [0.1]
"""
PULLED = """
[domain]
size = [2.0, 1.0]
h = 0.25
[damage]
ell = 0.75
[material]
nu = 0.2
[temperature]
profile = "none"
[supports]
left = { x = { file = "u.vtu", name = "u", component = "x" } }
right = { x = { file = "u.vtu", name = "u", component = "x", t = [0.0, 2.0], factor = [0.0, 1.0] } }
bottom = { y = 0.0 }
[time]
t = [1.0, 2.0]
"""


def grid(
    path: Path,
    lower: tuple[float, ...],
    size: tuple[float, ...],
    cells: int,
    of_cells: bool = False,
    **fields: Callable[[np.ndarray], np.ndarray],
) -> Path:
    """A file with a grid of squares and fields of place on it, points of shape (n, 3)."""
    spacing = (*(s / cells for s in size), 1.0)
    counts = (cells + 1, cells + 1, 1)
    shape = pyvista.ImageData(dimensions=counts, spacing=spacing, origin=(*lower, 0.0))
    mesh = shape.cast_to_unstructured_grid()
    places = mesh.cell_centers().points if of_cells else mesh.points
    for name, field in fields.items():
        (mesh.cell_data if of_cells else mesh.point_data)[name] = field(np.array(places))
    mesh.save(path)
    return path


# F5: units, and what is covered


def test_a_field_in_the_unit_of_the_mesh_is_told_or_counted_so(tmp_path: Path) -> None:
    """F5: a field in mm over a body in m was taken from one cell, E 7.13e10 in place of 9.53e10."""

    def stiff(x: np.ndarray) -> np.ndarray:
        return 70e9 * (1 + 0.5 * np.hypot(*x[:, :2].T) / 300)

    grid(tmp_path / "E.vtu", (0, 0), (600, 300), 40, of_cells=True, E=stiff)
    with pytest.raises(InputError) as error:
        parse_case(METERS, folder=tmp_path)
    for part in (
        "material.E = ",
        "the body, 0.6 x 0.3 m, is smaller than one cell of its mesh, 15 x 7.5 m",
        'say so, like unit = "1 mm"',
    ):
        assert part in str(error.value), str(error.value)
    grid(tmp_path / "corner.vtu", (-300, -300), (600, 600), 40, of_cells=True, E=stiff)
    corner = ["domain.size=['9 m', '4 m']", "domain.h='0.5 m'", "damage.ell='1.5 m'"]
    with pytest.raises(InputError, match="the body, 9 x 4 m, is smaller than one cell"):
        parse_case(METERS, [*corner, "material.E.file=corner.vtu"], folder=tmp_path)
    case = parse_case(METERS, ['material.E.unit="1 mm"'], folder=tmp_path)
    x = np.random.default_rng(0).uniform((0, 0), (0.6, 0.3), (100_000, 2))
    mean = 70e9 * (1 + 0.5 * np.hypot(*x.T) / 0.3).mean()
    assert pytest.approx(mean, rel=0.01) == averages(subdomains_of(case)[0]).E
    assert parse_case(to_toml(case), folder=tmp_path) == case
    grid(tmp_path / "m.vtu", (0, 0), (0.6, 0.3), 40, of_cells=True, E=lambda x: stiff(1000 * x))
    meters = parse_case(METERS, ["material.E.file=m.vtu"], folder=tmp_path)
    found, known = (run(c, tmp_path / f"run{k}")[-1] for k, c in enumerate((case, meters)))
    assert found.energies.elastic == pytest.approx(known.energies.elastic, rel=1e-9)


def test_values_count_in_the_unit_that_is_said(tmp_path: Path) -> None:
    """A mesh in centimeters and values in GPa, as where two programs differ in both:
    https://github.com/neams-th-coe/cardinal/issues/177."""
    grid(tmp_path / "E.vtu", (0, 0), (60, 30), 4, E=lambda x: 70 + x[:, 0])
    more = ['material.E.unit="1 cm"', 'material.E.field_unit="GPa"']
    E = problem(parse_case(METERS, more, folder=tmp_path), comm=MPI.COMM_SELF).material.E
    x = np.array([[0.1, 0.5], [0.1, 0.2], [0.0, 0.0]])
    assert E(x) == pytest.approx([80e9, 120e9])
    with pytest.raises(InputError, match="'K' does not measure a stress"):
        parse_case(METERS, ['material.E.field_unit="K"'], folder=tmp_path)


def test_what_a_file_does_not_cover_is_told_with_how_far_it_reaches(tmp_path: Path) -> None:
    """A point outside of the data, since lengths counted in another unit:
    https://github.com/ladybug-tools/butterfly/issues/191."""
    grid(tmp_path / "E.vtu", (0, 0), (0.4, 0.3), 4, E=lambda x: 1 + x[:, 0])
    with pytest.raises(InputError) as error:
        parse_case(METERS, folder=tmp_path)
    told = str(error.value)
    assert "nor 33% of the places; it reaches from [0.0, 0.0] to [0.4, 0.3]" in told, told
    with pytest.raises(InputError, match=r"its mesh does not reach \[0.0142.*nor 100% of"):
        parse_case(METERS, ['material.E.unit="1 mm"'], folder=tmp_path)


# Temperatures


def warm(x: np.ndarray) -> np.ndarray:
    return 1 + x[:, 0] + 2 * x[:, 1]


def test_an_initial_temperature_of_a_file_is_that_of_its_formula(tmp_path: Path) -> None:
    grid(tmp_path / "T0.vtu", (0, 0), (2, 1), 4, T=warm)
    formula = ['heat.initial={formula="1 + x + 2*y"}']
    file, same = (parse_case(HEATED, more, folder=tmp_path) for more in ([], formula))
    assert attached(file) == (tmp_path / "T0.vtu",) and attached(same) == ()
    (found,), (known,) = (run(c, tmp_path / f"run{k}") for k, c in enumerate((file, same)))
    assert found.heat.stored == pytest.approx(known.heat.stored, rel=1e-9)
    assert found.energies.elastic == pytest.approx(known.energies.elastic, rel=1e-9)
    assert read_case(tmp_path / "run0" / CASE) == file
    (cooled,) = surface_exchanges(file)
    assert cooled.drop == pytest.approx(2.0), "the mean of 1 + x along the bottom"
    assert preview(file).facts


def test_temperatures_of_files_say_how_they_count(tmp_path: Path) -> None:
    """Kelvin, or degrees: a file in degrees read as kelvin would be colder than any rock."""
    grid(tmp_path / "T0.vtu", (0, 0), (2, 1), 4, T=lambda x: 20 + x[:, 0])
    text = HEATED.replace("2.0, 1.0", '"2 m", "1 m"').replace("0.25", '"0.25 m"')
    text = text.replace("0.75", '"0.75 m"').replace("[0.1]", '["1 h"]').replace("0.0 }", '"5 °C" }')
    text = text.replace(
        "nu = 0.2", 'E="60 GPa"\nGc="1e9 J/m^2"\nexpansion="8e-6 1/K"\nk="3 W/(m K)"'
    )
    text = text.replace("[temperature]", 'rho="2700 kg/m^3"\nc="800 J/(kg K)"\n[temperature]')
    with pytest.raises(
        InputError, match=r'heat.initial.field_unit is missing.*field_unit = "°C", or "K"'
    ):
        parse_case(text, folder=tmp_path)
    case = parse_case(text, ['heat.initial.field_unit="°C"'], folder=tmp_path)
    load = problem(case, comm=MPI.COMM_SELF).load
    assert isinstance(load, Conduction)
    assert load.initial(np.array([[0.5], [0.5], [0.0]])) == pytest.approx([293.65])
    with pytest.raises(InputError, match="scaled; leave it out"):
        parse_case(HEATED, ['heat.initial.field_unit="K"'], folder=tmp_path)


def test_a_side_is_held_at_temperatures_of_a_file(tmp_path: Path) -> None:
    grid(tmp_path / "T0.vtu", (0, 0), (2, 1), 4, T=warm)
    file = ['heat.top={T={file="T0.vtu", name="T"}}', "heat.initial=3.0"]
    formula = ['heat.top={T={formula="3 + x"}}', "heat.initial=3.0"]
    found, known = (
        run(parse_case(HEATED, more, folder=tmp_path), tmp_path / f"run{k}")[-1]
        for k, more in enumerate((file, formula))
    )
    assert found.heat.entered == pytest.approx(known.heat.entered, rel=1e-9)


def quarter(gmsh) -> None:
    """A disc with a name for its rim."""
    tag = gmsh.model.occ.addDisk(0, 0, 0, 1, 1)
    gmsh.model.occ.synchronize()
    gmsh.model.addPhysicalGroup(2, [tag], name="rock")
    gmsh.model.addPhysicalGroup(1, [t for _, t in gmsh.model.getEntities(1)], name="rim")


@needs_gmsh
def test_vertices_beside_the_mesh_of_a_round_file_have_the_nearest_value(tmp_path: Path) -> None:
    """Points on a boundary came out as outside of the mesh of a restart, and were given zero:
    https://github.com/ExtremeFLOW/neko/pull/1001."""
    for name, h in (("coarse", 0.4), ("fine", 0.1)):
        meshes.written(tmp_path / f"{name}.msh", quarter, h=h)
    coarse = _as_grid(tmp_path / "coarse.msh")
    coarse.point_data["T"] = 1 + coarse.points[:, 0]
    coarse.save(tmp_path / "T0.vtu")
    text = HEATED.replace("size = [2.0, 1.0]\nh = 0.25", 'mesh = "fine.msh"').replace("0.75", "0.3")
    text = text.replace("bottom =", "rim =").replace('"heat"', '"heat"\nface = "rim"')
    load = problem(parse_case(text, folder=tmp_path), comm=MPI.COMM_SELF).load
    assert isinstance(load, Conduction)
    angle = np.linspace(0, 2 * np.pi, 50)
    x = np.array([np.cos(angle), np.sin(angle), 0 * angle])
    assert load.initial(x) == pytest.approx(1 + x[0], abs=0.03)
    with pytest.raises(InputError, match="its mesh does not reach"):
        parse_case(text.replace('name = "T"', 'name = "T", unit = 0.9'), folder=tmp_path)


def _as_grid(path: Path) -> pyvista.UnstructuredGrid:
    from staffa.case.reading.inspect_mesh import mesh_of

    mesh = mesh_of(path, 1.0, path.name)
    x = np.column_stack([mesh.x, np.zeros(len(mesh.x))])
    return pyvista.UnstructuredGrid({pyvista.CellType.TRIANGLE: mesh.cells}, x)


# Sides


def moved(x: np.ndarray) -> np.ndarray:
    """Pulled along x by 0.1 of itself and bent a little."""
    return np.column_stack([0.1 * x[:, 0] + 0.02 * x[:, 0] * x[:, 1], 0 * x[:, 0], 0 * x[:, 0]])


def test_sides_follow_the_displacements_of_a_file(tmp_path: Path) -> None:
    """As from another program's mesh, in a vector: the numbers of the same by constant values."""
    grid(tmp_path / "u.vtu", (-0.1, -0.1), (2.2, 1.2), 6, u=lambda x: moved(x) * [1, 1, 1])
    made = problem(parse_case(PULLED, folder=tmp_path), comm=MPI.COMM_SELF)
    by_side = {support.side: support.components for support in made.sides}
    x = np.array([[2.0, 2.0], [0.0, 1.0], [0.0, 0.0]])
    assert by_side["right"][0](x, 1.0) == pytest.approx([0.1, 0.12])
    assert by_side["right"][0](x, 5.0) == pytest.approx([0.2, 0.24])
    assert by_side["left"][0](0 * x, 1.0) == pytest.approx([0.0, 0.0], abs=1e-12)


LINE = "supports.right={x={file='line.vtu', name='u'}}"


def test_a_file_of_the_side_alone_will_do(tmp_path: Path) -> None:
    """A line of points on the side, as measured along it; and the energy of an even pull."""
    points = np.array([[2.0, y, 0.0] for y in np.linspace(0, 1, 5)])
    line = pyvista.lines_from_points(points).cast_to_unstructured_grid()
    line.point_data["u"] = np.full(5, 0.02)
    line.save(tmp_path / "line.vtu")
    grid(tmp_path / "u.vtu", (0, 0), (2, 1), 4, u=lambda x: 0 * x)
    more = [LINE, "supports.left=rollers", "supports.bottom=rollers"]
    case = parse_case(PULLED, more, folder=tmp_path)
    assert attached(case) == (tmp_path / "line.vtu",)
    energy = run(case, tmp_path / "run")[-1].energies.elastic
    assert energy == pytest.approx(0.5 * 0.01**2 * 2.0, rel=1e-5)
    assert read_case(tmp_path / "run" / CASE) == case


REFUSED = {
    "not there": ("name='v'", "the file has no field 'v'; it has u"),
    "a vector": ("name='u'", "'u' is not one number at each place"),
    "no such component": ("name='ux', component='y'", "'ux' has no such component"),
    "half a table": ("name='ux', t=[0.0]", "factor is missing: a table needs both"),
    "uneven": ("name='ux', t=[0.0, 1.0], factor=[1.0]", "supports.right.x"),
    "too small": ("name='ux', unit=0.5", "its mesh does not reach [2.0, 0."),
}


@pytest.mark.parametrize("what", REFUSED)
def test_a_side_that_a_file_does_not_give_is_refused_in_one_sentence(
    tmp_path: Path, what: str
) -> None:
    grid(tmp_path / "u.vtu", (0, 0), (2, 1), 4, u=moved, ux=lambda x: 0.1 * x[:, 0])
    given, said = REFUSED[what]
    with pytest.raises(InputError) as error:
        parse_case(PULLED, [f"supports.right={{x={{file='u.vtu', {given}}}}}"], folder=tmp_path)
    assert said in str(error.value), str(error.value)


def test_sides_that_meet_must_move_alike_there(tmp_path: Path) -> None:
    grid(tmp_path / "u.vtu", (0, 0), (2, 1), 4, ux=lambda x: 0.1 * x[:, 0])
    file = "{x={file='u.vtu', name='ux'}}"
    alike = [f"supports={{right={file}, top={file}, left={{x=0.0}}}}"]
    assert parse_case(PULLED, alike, folder=tmp_path)
    with pytest.raises(InputError, match=r"supports.right and supports.top meet, and hold x"):
        parse_case(PULLED, [f"supports={{right={file}, top={{x=0.0}}}}"], folder=tmp_path)
