"""A case run from the command line leaves what a user needs, on any number of ranks."""

import json
import os
import subprocess
import sys
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import pyvista

from staffa.io.run_directory import read_run
from staffa.io.vtkhdf import read_vtkhdf

BIN = Path(sys.executable).parent
CASES = Path(__file__).parent.parent / "src" / "staffa" / "case" / "ready"


def launch(ranks: int, *arguments: str | Path) -> subprocess.CompletedProcess:
    """staffa in a process of its own, one thread a rank."""
    command = [BIN / "staffa", *arguments]
    if ranks > 1:
        command = [BIN / "mpiexec", "-n", str(ranks), *command]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    return subprocess.run(command, capture_output=True, text=True, timeout=500, env=environment)


@pytest.fixture(scope="module")
def serial(tmp_path_factory) -> Path:
    directory = tmp_path_factory.mktemp("serial") / "run"
    done = launch(1, "run", CASES / "notched.toml", "--out", directory)
    assert done.returncode == 0, done.stderr
    return directory


@pytest.mark.slow
def test_run_directory_is_complete(serial: Path) -> None:
    run = read_run(serial)
    assert run.finished and len(run.steps) == 14
    assert {p.name for p in serial.iterdir()} >= {
        "case.toml",
        "manifest.json",
        "steps.jsonl",
        "run.log",
        "fields",
        "pictures",
        "report.html",
    }
    lines = (serial / "run.log").read_text().splitlines()
    assert len([line for line in lines if not line.startswith("  note: ")]) == 1 + 14
    assert run.steps[-1].measures.tips and run.steps[-1].audit.violations == ()
    assert not list(serial.rglob("*.staffa-part"))
    record = json.loads((serial / "steps.jsonl").read_text().splitlines()[0])
    energies = record["energies"]
    assert energies["total"] == energies["elastic"] + energies["surface"]


@pytest.mark.slow
def test_fields_are_read_by_pyvista_as_an_animation(serial: Path) -> None:
    reader = pyvista.get_reader(serial / "fields" / "fields.vtkhdf.series")
    run = read_run(serial)
    kept = [step for step in run.steps if step.fields]
    assert reader.time_values == pytest.approx([step.time for step in kept])
    for step in kept:
        reader.set_active_time_value(step.time)
        mesh = reader.read()
        mesh = mesh[0] if isinstance(mesh, pyvista.MultiBlock) else mesh
        grid, fields = read_vtkhdf(serial / step.fields)
        assert mesh.n_cells == run.manifest.cells
        assert np.array_equal(mesh.points, grid.points)
        assert mesh.point_data["u"].shape == (mesh.n_points, 3)
        for name in ("alpha", "T", "u"):
            assert np.array_equal(mesh.point_data[name], fields[name])
        # Every cell has its true area: the vertices are in VTK's order.
        areas = mesh.compute_cell_sizes(length=False, volume=False)["Area"]
        assert areas.sum() == pytest.approx(1.0 * 0.6, rel=1e-9) and areas.min() > 0


@pytest.mark.slow
@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.long)])
def test_ranks_agree(serial: Path, ranks: int, tmp_path: Path) -> None:
    """A ready case as it stands: energies to 1e-6, sweeps within 1, the same cracks and fields."""
    done = launch(ranks, "run", CASES / "notched.toml", "--quiet", "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    one, many = read_run(serial), read_run(tmp_path / "run")
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
def test_show_and_report(serial: Path) -> None:
    shown = launch(1, "show", serial)
    assert shown.returncode == 0 and "finished, 14 of 14 steps" in shown.stdout
    (serial / "pictures" / "cracks.png").unlink()
    drawn = launch(1, "report", serial)
    assert drawn.returncode == 0 and "cracks.png" in drawn.stdout
    assert (serial / "pictures" / "cracks.png").stat().st_size > 10_000


@pytest.mark.slow
def test_a_second_run_is_refused(serial: Path) -> None:
    before = (serial / "steps.jsonl").read_bytes()
    again = launch(1, "run", CASES / "notched.toml", "--out", serial)
    assert again.returncode == 2 and "holds a run already" in again.stderr
    assert (serial / "steps.jsonl").read_bytes() == before


@pytest.mark.slow
def test_the_resolved_case_runs_the_same(serial: Path, tmp_path: Path) -> None:
    """case.toml of a run, with every default written out, is the same case."""
    done = launch(1, "run", serial / "case.toml", "--out", tmp_path / "run", "--quiet")
    assert done.returncode == 0 and done.stdout == ""
    one, two = read_run(serial), read_run(tmp_path / "run")
    assert [s.energies for s in one.steps] == [s.energies for s in two.steps]
    for table in ("tips.csv", "reactions.csv", "network.csv"):
        assert (tmp_path / "run" / table).read_text() == (serial / table).read_text(), table
    assert not (tmp_path / "run" / "report.html").exists()


@pytest.mark.slow
def test_a_step_that_does_not_converge_is_saved_and_said(tmp_path: Path) -> None:
    directory = tmp_path / "run"
    done = launch(1, "run", CASES / "notched.toml", "--set", "solver.sweeps=1", "--out", directory)
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1 and "try shorter time steps" in done.stderr
    run = read_run(directory)
    assert run.steps[-1].status == "not converged" and (directory / run.steps[-1].fields).exists()


@pytest.mark.slow
@pytest.mark.mpi
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
@pytest.mark.mpi
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
        done = launch(ranks, "run", CASES / "brick.toml", *settings)
        assert done.returncode == 0, done.stderr
        runs.append(read_run(directory))
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
@pytest.mark.mpi
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
        done = launch(ranks, "run", CASES / "notched.toml", *whole, "--out", directory)
        assert done.returncode == 0, done.stderr
        energies.append(read_run(directory).steps[-1].energies.total)
    assert energies[1] == pytest.approx(energies[0], rel=1e-9)


@pytest.mark.slow
def test_a_superseded_step_is_marked_and_not_erased(tmp_path: Path) -> None:
    directory = tmp_path / "run"
    settings = ("--set", "solver.backtracking=true", "--set", "output.steps=all")
    done = launch(1, "run", CASES / "bar.toml", *settings, "--out", directory)
    assert done.returncode == 0, done.stderr
    run = read_run(directory)
    lines = [json.loads(line) for line in (directory / "steps.jsonl").read_text().splitlines()]
    returns = [line for line in lines if line["returned"]]
    assert returns and len(lines) == len(run.steps) + len(run.superseded) > 20
    assert run.finished and [step.index for step in run.steps] == list(range(20))
    assert all(line["returned"]["found"] < line["returned"]["before"] for line in returns)
    series = json.loads((directory / "fields" / "fields.vtkhdf.series").read_text())["files"]
    assert [file["time"] for file in series] == [step.time for step in run.steps]
    shown = launch(1, "show", directory).stdout
    assert f"went back {len(returns)} times, {len(run.superseded)} steps superseded" in shown
    assert f"went back from step {returns[0]['returned']['index']}" in done.stdout


ADAPTIVE = """
title = "Cooled glass, adaptive steps"
[domain]
size = ["20 mm", "10 mm"]
h = "0.5 mm"
[material]
E = "70 GPa"
Gc = "10 J/m^2"
expansion = "9e-6 1/K"
kappa = "0.5e-6 m^2/s"
[damage]
ell = "1.5 mm"
[toughness]
amplitude = 0.1
[temperature]
dT = "60 K"
[supports]
section = "fixed"
[time]
t = { start = "0.2 s", stop = "30 s", shortest = "0.05 s", longest = "10 s", advance = 1.5 }
[output]
at = ["7 s", "20 s"]
"""


@pytest.fixture(scope="module")
def adaptive(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("adaptive")
    (folder / "case.toml").write_text(ADAPTIVE)
    done = launch(1, "run", folder / "case.toml", "--quiet", "--out", folder / "run")
    assert done.returncode == 0, done.stderr
    return folder / "run"


@pytest.mark.slow
def test_adaptive_steps_in_seconds_from_case_to_report(adaptive: Path) -> None:
    run = read_run(adaptive)
    assert run.manifest.adaptive and run.finished
    assert run.manifest.times == (0.2, 7.0, 20.0, 30.0)
    times = [step.time for step in run.steps]
    assert times == sorted(times) and {7.0, 20.0, 30.0} <= set(times) and times[0] == 0.2
    assert run.rejected, "nothing was rejected: the test sees nothing"
    kept_fields = {step.time for step in run.steps if step.fields}
    assert kept_fields == {7.0, 20.0, 30.0}
    for before, after in pairwise(times):
        assert after - before <= 10 * (1 + 1e-9)
        grown = (after / before) ** 0.5 - 1
        assert grown <= 0.25 * (1 + 1e-9) or after - before <= 0.05 * (1 + 1e-9)
    log = (adaptive / "run.log").read_text()
    assert "adaptive steps" in log and log.count("rejected: cracks") == len(run.rejected)
    assert "taken again, shorter" in log and "1.5 ell" in log
    shown = launch(1, "show", adaptive).stdout
    assert f"finished, {len(run.steps)} steps" in shown and "rejected steps" in shown
    again = launch(1, "check", adaptive / "case.toml")
    assert again.returncode == 0 and "or more" in again.stdout


@pytest.mark.slow
@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.long)])
def test_adaptive_steps_are_the_same_on_more_ranks(adaptive: Path, tmp_path, ranks: int) -> None:
    done = launch(ranks, "run", adaptive / "case.toml", "--quiet", "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    alone, found = read_run(adaptive), read_run(tmp_path / "run")
    assert [s.time for s in found.steps] == [s.time for s in alone.steps]
    assert [s.time for s in found.rejected] == [s.time for s in alone.rejected]
    expected = [s.energies.total for s in alone.steps]
    assert [s.energies.total for s in found.steps] == pytest.approx(expected, rel=1e-6)


@pytest.mark.slow
def test_adaptive_steps_may_start_at_zero(tmp_path: Path) -> None:
    steps = "time={t={start=0.0,stop=0.4,shortest=0.01,longest=0.1,advance=6.0}}"
    settings = ("--set", steps, "--set", "output.at=[]", "--quiet")
    done = launch(1, "run", CASES / "bar.toml", *settings, "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    run = read_run(tmp_path / "run")
    assert run.finished and run.steps[0].time == 0.0


EARLY = "supports.right={x={t=[0.0,0.2],u=[0.0,0.05]}}"
SHORT = ("--set", "time={t=[0.2,0.3]}", "--set", "output.at=[]", "--set", EARLY)


@pytest.mark.slow
@pytest.mark.mpi
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
    assert (
        "warning: supports.right.x: the table ends" in checked and "nothing is off" not in checked
    )
    noted = launch(1, "check", CASES / "layered.toml").stdout
    assert "note: supports of left, right" in noted and "nothing is off" in noted


@pytest.mark.slow
def test_an_ensemble_says_it_once(tmp_path: Path) -> None:
    seeded = ("--seeds", "2", "--set", "toughness.amplitude=0.05")
    done = launch(1, "ensemble", CASES / "bar.toml", *SHORT, *seeded, "--out", tmp_path / "runs")
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("the table ends at t = 0.2") == 1, done.stdout


@pytest.mark.slow
def test_a_bar_breaks_where_it_should_at_the_loosest_tolerances(tmp_path: Path) -> None:
    """At sigma_c/E = sqrt(3 Gc/(8 ell E)) = .1936, by one crack of .3 times 1.075 Gc; with looser
    ones it did not break at all (residual 1e6), or not at once (change .1)."""
    loose = ("--set", "solver.residual=0.9", "--set", "solver.change=0.01", "--quiet")
    done = launch(1, "run", CASES / "bar.toml", *loose, "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    steps = read_run(tmp_path / "run").steps
    strains = [0.25 * step.time for step in steps]
    broken = next(k for k, step in enumerate(steps) if step.energies.surface > 0.2)
    assert strains[broken - 1] < (3 / (8 * 0.1 * 100)) ** 0.5 < strains[broken], strains[broken]
    assert steps[broken].energies.surface == pytest.approx(0.3 * 1.075, rel=0.05)
