"""Studies that are run: side by side, extended, stopped and resumed, as jobs of an array."""

import os
import re
import signal
import subprocess
import time
from pathlib import Path

import pytest

from case.test_bad_input import files_in, staffa
from report.test_study import rows
from staffa.case.reading.read import read_case
from staffa.case.reading.ready_cases import ready_case
from staffa.io.run_directory import STEPS, open_run
from staffa.io.study_directory import PLAN, read_plan, read_study
from staffa.results.study_table import study_table
from support.paths import BIN
from support.restarting import SMALL, assert_same, started

SHORT = ("--set", "time.tau=[0.2,0.4]")
LONG = ("--set", "time.tau={start=0.03,stop=0.6,steps=20}")
OVER = ("--over", "temperature.severity=8,12")


@pytest.fixture(scope="module")
def real(tmp_path_factory) -> Path:
    """A folder with my.toml, and the study `s` of two points and two seeds, run side by side."""
    folder = tmp_path_factory.mktemp("study")
    (folder / "my.toml").write_text(SMALL)
    asked = ("study", "my.toml", *OVER, "--seeds", "2", *SHORT, "--out", "s", "--jobs", "2")
    done = staffa(folder, *asked)
    assert done.returncode == 0, done.stderr
    assert "point 2, seed 4 (member 4 of 4) is finished, 3 of 3 steps" in done.stdout
    assert "temperature.severity 12, in s/point-2/seed-3" in done.stdout
    assert "2 of 2 points have started; 4 of 4 runs finished" in done.stdout
    assert "s/report.html" in done.stdout and "s/pictures/response-1.png" in done.stdout
    assert "`staffa report s --members` also draws" in done.stdout
    return folder


@pytest.mark.slow
def test_a_member_is_an_ordinary_run(real: Path) -> None:
    """The same as `staffa run` with its settings, to the last bit."""
    settings = ("--set", "temperature.severity=12", "--set", "toughness.seed=4", *SHORT)
    done = staffa(real, "run", "my.toml", *settings, "--out", "alone", "--quiet")
    assert done.returncode == 0, done.stderr
    one, other = open_run(real / "alone"), open_run(real / "s" / "point-2" / "seed-4")
    assert one.case == other.case
    assert_same(other, one)
    assert result_files(other.path) == result_files(one.path)


def result_files(folder: Path) -> dict[str, bytes]:
    """Tables and networks of a run by their names; there must be some."""
    found = [*folder.glob("*.csv"), *(folder / "network").iterdir()]
    assert {"network.csv", "tips.csv"} <= {path.name for path in found}
    return {str(path.relative_to(folder)): path.read_bytes() for path in found}


@pytest.mark.slow
def test_one_command_draws_all_members(real: Path) -> None:
    done = staffa(real, "report", "s", "--members")
    assert done.returncode == 0, done.stderr
    for place in ("s", "s/point-1/seed-3", "s/point-2/seed-4"):
        assert f"{place}/report.html" in done.stdout.splitlines()
        assert (real / place / "report.html").is_file()
    assert (real / "s" / "point-2" / "seed-4" / "pictures" / "lengths.png").is_file()
    alone = staffa(real, "report", "s/point-1/seed-3", "--members")
    assert alone.returncode == 2 and "is one run; leave out --members" in alone.stderr


@pytest.mark.slow
def test_the_numbers_are_those_of_the_runs(real: Path) -> None:
    found = rows((real / "s" / "study.csv").read_text())
    assert [(row["point"], row["seed"], row["temperature.severity"]) for row in found] == [
        ("1", "3", "8.0"), ("1", "4", "8.0"), ("2", "3", "12.0"), ("2", "4", "12.0"),
    ]  # fmt: skip
    for row in found:
        run = open_run(real / "s" / f"point-{row['point']}" / f"seed-{row['seed']}")
        assert float(row["surface_energy"]) == run.steps[-1].energies.surface
        assert float(row["length"]) == pytest.approx(run.steps[-1].measures.length_surface / 0.4)
    assert len({row["total_energy"] for row in found}) == 4
    shown = staffa(real, "show", "s").stdout
    assert "Energies at the end" in shown and "±" in shown
    point = staffa(real, "show", "s/point-2").stdout
    assert "2 of 2 finished; seeds 3, 4" in point, "each point is an ensemble"


@pytest.mark.slow
def test_points_and_seeds_are_added_to_a_study_and_finished_runs_stay(
    real: Path, tmp_path: Path
) -> None:
    """Points keep their numbers, wherever the new values stand in the command."""
    subprocess.run(["cp", "-r", str(real / "s"), str(tmp_path / "s")], check=True)
    before = files_in(tmp_path / "s" / "point-1" / "seed-3")
    asked = ("--over", "temperature.severity=6,8,12", "--first", "3", *SHORT)
    done = staffa(real, "study", "my.toml", *asked, "--out", str(tmp_path / "s"))
    assert done.returncode == 0, done.stderr
    assert (
        done.stdout.count("is finished already") == 2 and "point 3 (member 1 of 3)" in done.stdout
    )
    plan = read_plan(tmp_path / "s")
    assert [(point.number, point.values) for point in plan.points] == [
        (1, (8,)),
        (2, (12,)),
        (3, (6,)),
    ]
    assert files_in(tmp_path / "s" / "point-1" / "seed-3") == before
    assert len(study_table(read_study(tmp_path / "s")).rows) == 5


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (("--over", "domain.h=0.05,0.04"), "a study over temperature.severity; choose another"),
        ((*OVER, "--set", "damage.ell=0.11"), "a study of another case, see its point 1"),
    ],
)
def test_a_study_of_another_case_is_refused(real: Path, arguments, part) -> None:
    before = files_in(real / "s")
    done = staffa(real, "study", "my.toml", *arguments, *SHORT, "--out", "s")
    assert done.returncode == 2 and part in done.stderr, done.stderr
    assert files_in(real / "s") == before
    done = staffa(real, "resume", "s")
    assert done.returncode == 2 and "`staffa study` command again" in done.stderr


@pytest.mark.slow
def test_a_failed_member_is_listed_and_the_others_go_on(real: Path, tmp_path: Path) -> None:
    """With one sweep for a step."""
    asked = ("study", "my.toml", "--over", "solver.sweeps=1,500", *SHORT, "--jobs", "2")
    done = staffa(real, *asked, "--out", str(tmp_path / "s"))
    assert done.returncode == 1, done.stderr
    assert done.stderr.count("\n") == 1 and "1 of 2 members failed (point 1): step 0" in done.stderr
    assert "point 1 (member 1 of 2) failed: step 0" in done.stdout
    found = rows((tmp_path / "s" / "study.csv").read_text())
    assert found[0]["length"] == "" and "not converged at step 0" in found[0]["status"]
    assert found[1]["status"] == "finished, 3 of 3 steps"


@pytest.mark.slow
def test_where_no_member_can_be_run_the_exit_code_is_that_of_bad_input(
    real: Path, tmp_path: Path
) -> None:
    """The random Poisson ratio of some cell is out of range, which the case does not tell."""
    ratio = "material.nu={mean=0.25,variation=0.22,length=0.06,seed=1}"
    asked = ("study", "my.toml", *OVER, "--set", ratio, *SHORT, "--jobs", "2")
    done = staffa(real, *asked, "--out", str(tmp_path / "s"))
    assert done.returncode == 2 and "in the middle of every cell" in done.stderr, done.stderr


def wait_for_steps(folder: Path, number: int, process: subprocess.Popen) -> None:
    """Wait until this number of runs have recorded a step."""
    until = time.monotonic() + 200
    while time.monotonic() < until and process.poll() is None:
        if sum(file.stat().st_size > 0 for file in folder.rglob(STEPS)) >= number:
            return
        time.sleep(0.01)
    raise AssertionError(f"{number} runs had no step: {process.communicate()}")


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_stops_all_members_which_go_on_with_the_same_command(
    real: Path, tmp_path: Path, number: signal.Signals
) -> None:
    asked = ("study", str(real / "my.toml"), *OVER, *LONG, "--out", str(tmp_path / "s"))
    process = started("staffa", *asked, "--jobs", "2")
    wait_for_steps(tmp_path / "s", 2, process)
    process.send_signal(number)
    _, said = process.communicate(timeout=100)
    assert process.returncode == 3, said
    assert f"stopped, since {number.name} asked for it: 0 of 2 members are finished" in said
    places = [tmp_path / "s" / f"point-{k}" / "seed-3" for k in (1, 2)]
    assert all(0 < len(open_run(place).steps) < 20 for place in places)
    assert not any((place / "lock").read_text() for place in places), "their processes have ended"
    done = staffa(real, *asked, "--quiet")
    assert done.returncode == 0 and done.stdout == "", done.stderr
    whole = staffa(real, "run", "my.toml", *LONG, "--out", str(tmp_path / "whole"), "--quiet")
    assert whole.returncode == 0, whole.stderr
    assert_same(open_run(places[0]), open_run(tmp_path / "whole"))


@pytest.mark.slow
def test_members_end_with_a_process_that_is_killed(real: Path, tmp_path: Path) -> None:
    asked = ("study", str(real / "my.toml"), *OVER, *LONG, "--out", str(tmp_path / "s"))
    process = started("staffa", *asked, "--jobs", "2")
    wait_for_steps(tmp_path / "s", 2, process)
    process.kill()
    process.communicate()
    locks = [tmp_path / "s" / f"point-{k}" / "seed-3" / "lock" for k in (1, 2)]
    until = time.monotonic() + 60
    while any(lock.read_text() for lock in locks):
        assert time.monotonic() < until, "a member goes on without the process that started it"
        time.sleep(0.05)
    assert all(len(open_run(lock.parent).steps) < 20 for lock in locks)


@pytest.mark.slow
def test_a_wall_time_that_is_over_stops_all_members(real: Path, tmp_path: Path) -> None:
    asked = ("study", "my.toml", *OVER, *LONG, "--jobs", "2", "--wall-time", "1 s")
    done = staffa(real, *asked, "--out", str(tmp_path / "s"))
    assert done.returncode == 3, done.stderr
    assert "its wall time is nearly over: 0 of 2 members are finished" in done.stderr


@pytest.mark.slow
def test_a_job_of_an_array_runs_one_member(real: Path, tmp_path: Path) -> None:
    """Without Slurm, which gives each job a number; again, since a run goes on."""
    script = tmp_path / "job.sh"
    asked = ("study", str(real / "my.toml"), *OVER, *SHORT, "--out", str(tmp_path / "a b"))
    done = staffa(tmp_path, *asked, "--slurm", str(script), "--wall-time", "30 min")
    assert done.returncode == 0 and "array of 2 jobs" in done.stdout, done.stderr
    assert (tmp_path / "a b" / PLAN).is_file() and not (tmp_path / "a b" / "point-1").exists()
    text = script.read_text()
    assert "#SBATCH --array=1-2\n" in text and "#SBATCH --time=42\n" in text
    assert "#SBATCH --job-name=a-b\n" in text
    assert all(re.match(r"#SBATCH --[a-z-]+=\S+$", line) for line in text.split("\n")[1:8])
    assert subprocess.run(["bash", "-n", script], capture_output=True).returncode == 0
    path = f"{BIN}:{os.environ['PATH']}"
    place = {**os.environ, "SLURM_ARRAY_TASK_ID": "2", "PATH": path}
    for said in ("step   2", "is finished already"):
        done = subprocess.run([script], capture_output=True, text=True, cwd=tmp_path, env=place)
        assert done.returncode == 0 and said in done.stdout, done.stdout + done.stderr
    assert open_run(tmp_path / "a b" / "point-2" / "seed-3").finished
    assert not (tmp_path / "a b" / "point-1").exists()
    done = staffa(tmp_path, "report", "a b")
    assert done.returncode == 0 and "1 of 2" not in done.stderr, done.stderr


@pytest.mark.slow
def test_an_ensemble_runs_its_members_side_by_side(real: Path, tmp_path: Path) -> None:
    """The numbers are those of one after another."""
    asked = ("ensemble", "my.toml", "--seeds", "2", *SHORT, "--quiet")
    for out, more in (("one", ()), ("both", ("--jobs", "2"))):
        done = staffa(real, *asked, *more, "--out", str(tmp_path / out))
        assert (done.returncode, done.stdout) == (0, ""), done.stderr
    one, both = (tmp_path / out / "ensemble.csv" for out in ("one", "both"))
    assert one.read_text() == both.read_text()


@pytest.mark.slow
def test_the_demonstration_is_the_ready_case_slab(tmp_path: Path) -> None:
    """Stopped at once; its files are those of a run that goes on."""
    done = staffa(tmp_path, "demo", "--set", "toughness.seed=2", "--wall-time", "1 s")
    assert done.returncode == 3 and "`staffa resume runs/demo` goes on" in done.stderr, done.stderr
    assert read_case(tmp_path / "runs" / "demo" / "case.toml") == ready_case(
        "slab", ["toughness.seed=2"]
    )
