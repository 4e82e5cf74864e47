"""staffa from Python: the example of its page, a law and a load of one's own, another build."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import staffa
from support.paths import DOCS

PAGE = DOCS / "how-to" / "python.md"


@pytest.mark.slow
def test_the_example_of_the_page_runs(tmp_path: Path) -> None:
    (example,) = re.findall(
        r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL
    )
    assert len(example.strip().splitlines()) <= 16
    done = subprocess.run(
        [sys.executable, "-c", example], capture_output=True, text=True, cwd=tmp_path, timeout=300
    )
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) >= 3, "a line a step"


def small() -> "staffa.Case":
    quick = ["time.tau=[0.1, 0.2]", "output.at=[0.2]", "measures.depths=[]", "domain.h=0.02"]
    from staffa.case.reading.ready_cases import text

    return staffa.parse_case(text("notched"), quick)


def energies(**own) -> list[float]:
    problem = staffa.problem(small(), **own)
    system = staffa.build(problem)
    found = [step.energies.total for step in staffa.march(problem, system)]
    system.destroy()
    return found


def test_a_law_of_ones_own_that_is_a_known_one_gives_its_numbers() -> None:
    class Mine:
        name = "mine"
        c_w = 2 / 3

        def a(self, alpha):
            return (1 - alpha) * (1 - alpha)

        def w(self, alpha):
            return 1 - (1 - alpha)

    assert energies(damage=Mine()) == pytest.approx(energies(), rel=1e-6)


def test_a_law_of_ones_own_changes_the_numbers() -> None:
    class Stiffer:
        """Its stiffness falls more slowly: the problem for the damage is no longer quadratic."""

        name = "stiffer"
        c_w = 2 / 3

        def a(self, alpha):
            return (1 - alpha) ** 2 * (1 + alpha)

        def w(self, alpha):
            return alpha

    assert abs(energies(damage=Stiffer())[-1] / energies()[-1] - 1) > 1e-3


def test_a_load_of_ones_own() -> None:
    class Mild:
        def temperature(self, x, t):
            return np.full(x.shape[1], -1e-3)

    assert energies(temperature=Mild())[-1] < energies()[-1]


def test_unknown_name_is_said() -> None:
    with pytest.raises(AttributeError, match="staffa has no 'rum'; it has"):
        _ = staffa.rum


def test_runs_where_the_wheels_bootstrap_is_absent() -> None:
    """As on a DOLFINx from conda-forge or Spack: nothing needs the module `dolfinx_solver`."""
    code = (
        "import importlib.util, sys\n"
        "true = importlib.util.find_spec\n"
        "hide = lambda name, *rest: None if name == 'dolfinx_solver' else true(name, *rest)\n"
        "importlib.util.find_spec = hide\n"
        "import staffa.runs.run\n"
        "assert 'dolfinx_solver' not in sys.modules\n"
        "from staffa.model.domain import block\n"
        "from staffa.backend.stack import MPI\n"
        "print(block(MPI.COMM_WORLD, size=(1., 1.), h=.5, cells='triangle').identity)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("name", ["build", "march", "problem", "run"])
def test_whatever_is_imported_first_finds_its_libraries(name: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", f"from staffa import {name}"], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
