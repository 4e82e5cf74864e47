"""The house: imports point down, packages on a floor are strangers, the light half stays light."""

import subprocess
import sys
from pathlib import Path

import pytest

from floors import FLOORS, LIGHT, files, place, pointing_up
from support.paths import ROOT

SOURCE = ROOT / "src" / "staffa"

FILES = files(SOURCE)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(SOURCE)))
def test_imports_point_down(path: Path) -> None:
    assert pointing_up(path, SOURCE) == []


def test_every_module_has_a_floor() -> None:
    assert {place(path, SOURCE) for path in FILES} <= set().union(*FLOORS)


def test_light_half_loads_without_the_finite_element_stack() -> None:
    code = (
        "import sys, importlib\n"
        f"for name in {LIGHT!r}: importlib.import_module(name)\n"
        "heavy = {'dolfinx', 'petsc4py', 'mpi4py', 'ufl', 'dolfinx_solver'} & set(sys.modules)\n"
        "sys.exit(', '.join(sorted(heavy)) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, f"the light half loads {done.stderr}"
