"""Commands load what they need: help answers at once, and a check needs no finite elements."""

import json
import subprocess
import sys
from pathlib import Path

import meshio
import numpy as np
import pytest
import pyvista
import typer
from scipy.spatial import Delaunay

from staffa.cli.commands import app
from staffa.geometry.foreign import FORMATS as MESHES
from staffa.geometry.msh import SALOME
from staffa.properties.mesh_field import FORMATS as FIELDS
from support.circulation_cases import WALL
from support.meshes import square, written
from support.paths import READY

# Of VTK, a check reads fields with what loads in 0.1 s; its pictures are another library of it.
PICTURES = {"matplotlib", "pyvista", "vtk", "vtkmodules.vtkRenderingCore"}
HEAVY = {"dolfinx", "mpi4py", "petsc4py", "ufl", *PICTURES}
# Libraries that no help needs; Typer itself loads pydantic for the help of a command.
OF_CASES = {"gstools", "h5py", "jinja2", "numpy", "pint", "scipy"}
COMMANDS = sorted(typer.main.get_command(app).commands)  # type: ignore[attr-defined]
# Runs the command line for each list of arguments, and tells which modules are loaded then.
LOADED = """
import json, sys
from staffa.cli import main
for arguments in json.loads(sys.argv[1]):
    sys.argv = ["staffa", *arguments]
    try:
        main()
    except SystemExit as end:
        assert not end.code, arguments
print(*sys.modules, file=sys.stderr)
"""


def loaded_by(*commands: list[str], folder: Path | None = None) -> tuple[str, set[str]]:
    """Return what commands print, and the libraries that are loaded after them."""
    done = subprocess.run(
        [sys.executable, "-c", LOADED, json.dumps(commands)],
        capture_output=True,
        text=True,
        cwd=folder,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout, set(done.stderr.splitlines()[-1].split())


def test_help_of_all_commands_loads_no_library_of_numbers() -> None:
    said, loaded = loaded_by(["--help"])
    assert all(f" {name} " in said for name in COMMANDS)
    assert loaded & (HEAVY | OF_CASES | {"pydantic"}) == set()


def test_help_of_each_command_loads_no_library_of_numbers() -> None:
    said, loaded = loaded_by(*([name, "--help"] for name in COMMANDS))
    assert all(f"Usage: staffa {name} " in said for name in COMMANDS)
    assert loaded & (HEAVY | OF_CASES) == set()


def test_a_check_of_any_ready_case_loads_no_finite_elements_and_no_pictures() -> None:
    files = sorted(READY.glob("*.toml"))
    said, loaded = loaded_by(*(["check", str(file)] for file in files))
    assert said.count("effective Gc  ") == len(files)
    assert loaded & HEAVY == set()
    assert {"numpy", "pydantic"} <= loaded  # or this looks at the wrong process


RANDOM = "material.E={mean=1.0, variation=0.2, length=1.0, distribution='weibull', seed=3}"


def test_a_check_of_a_random_rock_stays_light() -> None:
    said, loaded = loaded_by(["check", str(READY / "slab.toml"), f"--set={RANDOM}"])
    assert "effective Gc  " in said
    assert loaded & HEAVY == set()


OF_A_MESH = """
domain = {{ mesh = "{mesh}" }}
material = {{ E = 1.0, nu = 0.2, Gc = 1.0, expansion = 1.0, kappa = 1.0 }}
damage.ell = 0.6
temperature = {{ profile = "formula", T = "-t*x" }}
time.t = [0.1]
"""
OF_GMSH = (".msh", *SALOME)


def write_mesh(file: Path) -> None:
    """Write a unit square of triangles."""
    if file.suffix in OF_GMSH:
        written(file, square, h=0.2)
        return
    x, y = (c.ravel() for c in np.meshgrid(*[np.linspace(0, 1, 6)] * 2))
    points = np.column_stack([x, y, 0 * x])
    cells = {"triangle": Delaunay(points[:, :2]).simplices}
    meshio.write(file, meshio.Mesh(points, cells), file_format=MESHES[file.suffix])


@pytest.mark.slow
def test_a_check_of_a_mesh_of_any_kind_stays_light(tmp_path: Path) -> None:
    files = [tmp_path / f"mesh{ending}" for ending in (*OF_GMSH, *MESHES)]
    for file in files:
        write_mesh(file)
        case = file.with_suffix(f"{file.suffix}.toml")
        case.write_text(OF_A_MESH.format(mesh=file.name), encoding="utf-8")
    said, loaded = loaded_by(*(["check", f"{file}.toml"] for file in files))
    assert said.count("effective Gc  ") == len(files)
    assert loaded & HEAVY == set()


# Cases with fields in files wherever one may name them: a heated plate, the rock of a reservoir,
# and temperatures that another simulator computed.
HEATED = """
domain = {{ size = [2.0, 1.0], h = 0.25 }}
material = {{ E = {field}, nu = 0.2, Gc = {field}, expansion = {field}, k = {field} }}
damage.ell = 0.75
temperature.profile = "heat"
supports.left = {{ x = {field} }}
time.t = [0.1]
[heat]
initial = {field}
stress_free = {field}
bottom = {{ T = {field} }}
"""
KNOWN = """
domain = {{ size = ["12 m", "6 m"], h = "0.5 m" }}
damage.ell = "1.5 m"
temperature.profile = "reservoir"
time.t = ["1 d"]
[material]
E = "40 GPa"
Gc = "100 J/m^2"
expansion = "8e-6 1/K"
k = "2.5 W/(m K)"
rho = "2700 kg/m^3"
c = "850 J/(kg K)"
[reservoir]
simulator = "fields"
fields = {{ t = ["0 s", "1 d"], files = ["{file}", "{file}"], T = "f", p = "f" }}
"""
ROCK = ("permeability={{file='{file}',name='f',field_unit='m^2'}}", "porosity={field}")


def write_field(file: Path) -> None:
    """Write the field f, linear, on a mesh that covers the bodies of these cases."""
    box = pyvista.ImageData(dimensions=(16, 17, 1), origin=(-1, -1, 0))
    box.point_data["f"] = 0.2 + 0.01 * box.points[:, 0]
    if file.suffix == ".csv":
        rows = np.column_stack([box.points[:, :2], box["f"]])
        np.savetxt(file, rows, delimiter=",", header="x,y,f", comments="")
    else:
        kind = {".vti": "", ".vtr": "cast_to_rectilinear_grid", ".vts": "cast_to_structured_grid"}
        cast = kind.get(file.suffix, "cast_to_unstructured_grid")
        (getattr(box, cast)() if cast else box).save(file)


@pytest.mark.slow
def test_a_check_of_fields_in_files_of_any_kind_stays_light(tmp_path: Path) -> None:
    """A modulus of each kind of file, and every key that may name one."""
    slab, checks = str(READY / "slab.toml"), []
    for ending in FIELDS:
        write_field(tmp_path / f"a{ending}")
        field = f"{{ file = '{tmp_path / f'a{ending}'}', name = 'f' }}"
        checks += [["check", slab, "--outside", f"--set=material.E={field}"]]
    names = {"file": "a.vtu", "field": "{ file = 'a.vtu', name = 'f' }"}
    for name, text in {"heated": HEATED.format(**names), "known": KNOWN.format(**names)}.items():
        (tmp_path / f"{name}.toml").write_text(text, encoding="utf-8")
        checks += [["check", f"{name}.toml"]]
    (tmp_path / "wall.toml").write_text(WALL, encoding="utf-8")
    checks += [["check", "wall.toml", *(f"--set=reservoir.{one.format(**names)}" for one in ROCK)]]
    said, loaded = loaded_by(*checks, folder=tmp_path)
    assert said.count("effective Gc  ") == len(checks)
    assert loaded & HEAVY == set()
