"""Commands load what they need: help answers at once, and a check needs no finite elements."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
import typer

from staffa.cli.commands import app
from support.meshes import plate, written
from support.paths import READY

PICTURES = {"matplotlib", "pyvista", "vtk", "vtkmodules"}
HEAVY = {"dolfinx", "mpi4py", "petsc4py", "ufl", *PICTURES}
# Libraries that no help needs; Typer itself loads pydantic for the help of a command.
OF_CASES = {"gstools", "h5py", "jinja2", "numpy", "pint", "scipy"}
COMMANDS = sorted(typer.main.get_command(app).commands)  # type: ignore[attr-defined]
# Runs the command line for each list of arguments, and tells which libraries are loaded then.
LOADED = """
import json, sys
from staffa.cli import main
for arguments in json.loads(sys.argv[1]):
    sys.argv = ["staffa", *arguments]
    try:
        main()
    except SystemExit as end:
        assert not end.code, arguments
print(*{name.partition(".")[0] for name in sys.modules}, file=sys.stderr)
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


RANDOM = ["material.E={mean=1.0, variation=0.2, length=1.0, distribution='weibull', seed=3}"]
OF_A_FILE = """
domain = { mesh = "plate.msh" }
material = { E = 1.0, nu = 0.2, Gc = 1.0, expansion = 1.0, kappa = 1.0 }
damage.ell = 0.3
temperature = { dT = 54.0, face = "floor" }
time.t = [0.1]
cracks = [{ name = "fault" }]
regions = { sand = {}, shale = {} }
"""


@pytest.mark.parametrize("settings", [RANDOM, []], ids=["random field", "mesh of a file"])
def test_a_check_of_a_random_rock_or_a_mesh_stays_light(
    settings: list[str], tmp_path: Path
) -> None:
    case = READY / "slab.toml"
    if not settings:
        written(tmp_path / "plate.msh", plate, h=0.1)
        case = tmp_path / "my.toml"
        case.write_text(OF_A_FILE, encoding="utf-8")
    said, loaded = loaded_by(["check", str(case), *(f"--set={one}" for one in settings)])
    assert "effective Gc  " in said
    assert loaded & HEAVY == set()
