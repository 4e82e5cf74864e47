"""A case run from the command line leaves what a user needs, on any number of ranks."""

import json
import os
import subprocess
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import pyvista

from staffa.io.run_directory import SERIES, open_run
from staffa.io.vtkhdf import read_vtkhdf
from support.commands import forked
from support.paths import BIN, READY

CASES = READY


def launch(ranks: int, *arguments: str | Path) -> subprocess.CompletedProcess:
    """Run staffa in a separate process; with ranks, the installed one, one thread a rank."""
    if ranks == 1:
        return forked(*arguments, timeout=500)
    command = [BIN / "mpiexec", "-n", str(ranks), BIN / "staffa", *arguments]
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
    run = open_run(serial)
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
    run = open_run(serial)
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
    one, two = open_run(serial), open_run(tmp_path / "run")
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
    run = open_run(directory)
    assert run.steps == () and run.unreached.status == "not converged"
    assert (directory / run.unreached.fields).exists()
    assert "step-" not in (directory / "fields" / SERIES).read_text(), "it is in no animation"
    assert "step 0 to tau 0.0500 (t 0.000225) not reached: " in (directory / "run.log").read_text()


@pytest.mark.slow
def test_a_superseded_step_is_marked_and_not_erased(tmp_path: Path) -> None:
    directory = tmp_path / "run"
    settings = ("--set", "solver.backtracking=true", "--set", "output.steps=all")
    done = launch(1, "run", CASES / "bar.toml", *settings, "--out", directory)
    assert done.returncode == 0, done.stderr
    run = open_run(directory)
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
    run = open_run(adaptive)
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
def test_adaptive_steps_may_start_at_zero(tmp_path: Path) -> None:
    steps = "time={t={start=0.0,stop=0.4,shortest=0.01,longest=0.1,advance=6.0}}"
    settings = ("--set", steps, "--set", "output.at=[]", "--quiet")
    done = launch(1, "run", CASES / "bar.toml", *settings, "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    run = open_run(tmp_path / "run")
    assert run.finished and run.steps[0].time == 0.0


EARLY = "supports.right={x={t=[0.0,0.2],u=[0.0,0.05]}}"
SHORT = ("--set", "time={t=[0.2,0.3]}", "--set", "output.at=[]", "--set", EARLY)


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
    steps = open_run(tmp_path / "run").steps
    strains = [0.25 * step.time for step in steps]
    broken = next(k for k, step in enumerate(steps) if step.energies.surface > 0.2)
    assert strains[broken - 1] < (3 / (8 * 0.1 * 100)) ** 0.5 < strains[broken], strains[broken]
    assert steps[broken].energies.surface == pytest.approx(0.3 * 1.075, rel=0.05)
