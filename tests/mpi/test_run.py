"""Whole runs under mpiexec: the results of one rank, and failures of one of several."""

import subprocess
import sys
from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest
import pyvista

from run.test_run import CASES, SHORT, adaptive, launch, serial  # noqa: F401
from staffa.io.run_directory import open_run
from staffa.io.vtkhdf import read_vtkhdf
from support.paths import BIN
from support.ranks import staffa_on


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.long)])
def test_ranks_agree(serial: Path, ranks: int, tmp_path: Path) -> None:
    """A ready case as it stands: energies to 1e-6, sweeps within 1, the same cracks and fields."""
    done = launch(ranks, "run", CASES / "notched.toml", "--quiet", "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    one, many = open_run(serial), open_run(tmp_path / "run")
    assert many.manifest.ranks == ranks and len(many.steps) == len(one.steps)
    for a, b in zip(one.steps, many.steps, strict=True):
        assert b.energies.total == pytest.approx(a.energies.total, rel=1e-6)
        assert b.energies.elastic == pytest.approx(a.energies.elastic, rel=1e-6)
        assert abs(a.sweeps - b.sweeps) <= 1, f"{a.sweeps} sweeps against {b.sweeps}"
        assert [s.cracks for s in a.measures.sections] == [s.cracks for s in b.measures.sections]
        assert b.measures.length_surface == pytest.approx(a.measures.length_surface, rel=1e-5)
        assert b.measures.length_geometry == pytest.approx(a.measures.length_geometry, rel=1e-5)
        assert [t.depth for t in a.measures.tips] == pytest.approx(
            [t.depth for t in b.measures.tips]
        )
    (_, here), (_, there) = (
        read_vtkhdf(d / one.steps[-1].fields) for d in (serial, tmp_path / "run")
    )
    assert np.sort(there["alpha"]) == pytest.approx(np.sort(here["alpha"]), abs=1e-3)


@pytest.mark.slow
def test_a_rank_that_fails_alone_ends_all(tmp_path: Path) -> None:
    """An exception on one rank only: the others do not wait for it for ever."""
    code = (
        "from pathlib import Path\n"
        "from staffa.backend.stack import MPI\n"
        "from staffa.runs import run as experiment\n"
        "from staffa.case.reading.read import read_case\n"
        "from staffa.cli import live\n"
        "true_build = experiment.build\n"
        "def build(problem):\n"
        "    if MPI.COMM_WORLD.rank == 1: raise RuntimeError('rank one is ill')\n"
        "    return true_build(problem)\n"
        "experiment.build = build\n"
        f"live.run_and_follow(lambda: read_case(Path({str(CASES / 'notched.toml')!r})), "
        f"Path({str(tmp_path / 'run')!r}), quiet=True)\n"
    )
    done = subprocess.run(
        [BIN / "mpiexec", "-n", "2", sys.executable, "-c", code],
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode != 0 and "rank one is ill" in done.stderr


SMALL_BRICK = [
    *("--set", "domain.size=[0.6, 0.6, 0.6]"),
    *("--set", "domain.h=0.06", "--set", "damage.ell=0.15", "--set", "measures.depths=[]"),
    *("--set", "temperature.severity=4.65", "--set", "time.tau=[0.2, 0.4, 0.6]"),
    *("--set", "output.at=[0.6]"),
    *("--set", "solver.change=1e-5"),
    *("--set", "solver.residual=1e-3"),
]


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize(
    ("cells", "displacement"), [("hexahedron", "iterative"), ("tetrahedron", "direct")]
)
def test_brick_cracks_the_same_on_two_ranks(cells: str, displacement: str, tmp_path: Path) -> None:
    """The same code in 3-D: cracks, measures, fields; one rank and two agree.

    Multigrid makes other aggregates of another partition, so that Newton's moves, which are
    truncated early, take another way: to the same state here, where no step is brutal. The direct
    solver takes the same way on any number of ranks.
    """
    runs = []
    for ranks in (1, 2):
        directory = tmp_path / str(ranks)
        solver = ("--set", f"solver.displacement={displacement}")
        settings = [*SMALL_BRICK, *solver, "--set", f"domain.cells={cells}", "--out", directory]
        settings.append("--quiet")
        staffa_on(ranks, "run", CASES / "brick.toml", *settings)
        runs.append(open_run(directory))
    for a, b in zip(runs[0].steps, runs[1].steps, strict=True):
        assert a.audit.violations == b.audit.violations == ()
        assert b.energies.total == pytest.approx(a.energies.total, rel=1e-6)
        assert b.energies.elastic == pytest.approx(a.energies.elastic, rel=3e-5)
        assert b.energies.surface == pytest.approx(a.energies.surface, rel=3e-5, abs=1e-9)
        assert displacement == "iterative" or abs(a.sweeps - b.sweeps) <= 1
    last = runs[0].steps[-1]
    _, fields = read_vtkhdf(runs[0].path / last.fields)
    assert fields["alpha"].max() > 0.95 and last.measures.length_surface > 0
    mesh = pyvista.read(runs[0].path / last.fields)
    mesh = mesh[0] if isinstance(mesh, pyvista.MultiBlock) else mesh
    volumes = mesh.compute_cell_sizes(length=False, area=False)["Volume"]
    assert volumes.sum() == pytest.approx(0.6**3, rel=1e-9) and volumes.min() > 0


@pytest.mark.slow
def test_more_ranks_than_cells(tmp_path: Path) -> None:
    """A rank that owns nothing takes part."""
    whole = [
        *("--set", "domain.size=[0.1, 0.1]", "--set", "domain.h=0.1", "--set", "damage.ell=0.1"),
        *("--set", "cracks=[]", "--set", "toughness.bands=[]", "--set", "measures.depths=[0.05]"),
        *("--set", "time.tau=[0.5]", "--set", "output.at=[]", "--quiet"),
    ]
    energies = []
    for ranks in (1, 3):
        directory = tmp_path / str(ranks)
        staffa_on(ranks, "run", CASES / "notched.toml", *whole, "--out", directory)
        energies.append(open_run(directory).steps[-1].energies.total)
    assert energies[1] == pytest.approx(energies[0], rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.long)])
def test_adaptive_steps_are_the_same_on_more_ranks(adaptive: Path, tmp_path, ranks: int) -> None:
    staffa_on(ranks, "run", adaptive / "case.toml", "--quiet", "--out", tmp_path / "run")
    alone, found = open_run(adaptive), open_run(tmp_path / "run")
    assert [s.time for s in found.steps] == [s.time for s in alone.steps]
    assert [s.time for s in found.rejected] == [s.time for s in alone.rejected]
    expected = [s.energies.total for s in alone.steps]
    assert [s.energies.total for s in found.steps] == pytest.approx(expected, rel=1e-6)


@pytest.mark.slow
def test_run_says_what_check_warns_of(tmp_path: Path) -> None:
    """Once, on one rank, and in the log."""
    warned = "warning: supports.right.x: the table ends at t = 0.2, and the run at t = 0.3"
    for ranks in (1, 2):
        where = tmp_path / str(ranks)
        done = launch(ranks, "run", CASES / "bar.toml", *SHORT, "--out", where)
        assert done.returncode == 0, done.stderr
        assert done.stdout.count(warned) == 1, done.stdout
        assert (where / "run.log").read_text().count(warned) == 1
    checked = launch(1, "check", CASES / "bar.toml", *SHORT).stdout
    assert "warning: supports.right.x: the table ends" in checked
    assert checked.splitlines()[-1].startswith("1 warning")
