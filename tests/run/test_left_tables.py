"""Tables and networks that a command leaves in its runs, and the words on them."""

from dataclasses import replace
from pathlib import Path

import pytest

from report.test_report import rewritten
from run.test_ensemble import drawn_ensemble
from staffa.cli.results import leave_missing_tables
from staffa.io.ensemble_directory import read_ensemble
from staffa.io.run_directory import open_run
from staffa.records.status import Status
from support.commands import forked

SMALL = """
[domain]
size = [0.8, 0.4]
h = 0.05
[damage]
ell = 0.1
[toughness]
amplitude = 0.1
[temperature]
severity = 20.0
[time]
tau = [0.01, 0.2]
"""
PULLED = """
[domain]
size = [1.0, 0.3]
h = 0.05
[material]
E = 100.0
[damage]
ell = 0.1
[toughness]
amplitude = 0.05
[temperature]
profile = "none"
[supports]
left = { x = 0.0 }
right = { x = { t = [0.0, 1.0], u = [0.0, 0.25] } }
[time]
t = [0.1, 1.0]
[output]
steps = "all"
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "small.toml").write_text(SMALL)
    return tmp_path


def size_told(printed: str) -> str:
    (line,) = (line for line in printed.splitlines() if line.lstrip().startswith("crack length"))
    return line


@pytest.mark.slow
def test_a_run_tells_of_the_network_that_it_has_written(folder: Path) -> None:
    """So does one that is resumed, and one that failed tells of no network of an earlier state."""
    done = forked("run", "small.toml", "--out", "run", folder=folder)
    assert done.returncode == 0, done.stderr
    assert "in the network at step 1" in size_told(done.stdout)
    table, longer = folder / "run" / "network.csv", ("--set", "time.tau=[0.01, 0.2, 0.3]")
    failed = forked("resume", "run", *longer, "--set", "solver.sweeps=1", "--quiet", folder=folder)
    assert failed.returncode == 1 and open_run(folder / "run").unreached, failed.stderr
    assert not table.exists(), "its last row may be of a step that is no more"
    assert "`staffa report`" in forked("show", "run", folder=folder).stdout
    done = forked("resume", "run", "--set", "solver.sweeps=5000", folder=folder)
    assert done.returncode == 0, done.stderr
    assert "in the network at step 2" in size_told(done.stdout)


@pytest.mark.slow
def test_members_that_fail_or_are_taken_without_tables_get_them(folder: Path) -> None:
    """The first of two steps is elastic, the second breaks the bar in more than three sweeps."""
    (folder / "bar.toml").write_text(PULLED)
    words = ("ensemble", "bar.toml", "--seeds", "2", "--out", "e", "--set")
    failed = forked(*words, "solver.sweeps=3", folder=folder)
    assert failed.returncode == 1 and "2 of 2 members failed" in failed.stderr, failed.stderr
    tables = [folder / "e" / f"seed-{seed}" / "network.csv" for seed in (0, 1)]
    for table in tables:
        assert [step.index for step in open_run(table.parent).steps] == [0]
        assert table.read_text().splitlines()[-1].startswith("0,")
    assert "networks of steps with fields: 2, all that reached a step" in failed.stdout
    more = ("--set", "solver.sweeps=5000", "--quiet")
    done = forked("resume", "e/seed-1", *more, folder=folder)
    assert done.returncode == 0, done.stderr
    tables[1].unlink()
    taken = forked(*words, "solver.sweeps=3", folder=folder)
    assert taken.stdout.count("is finished already") == 1
    assert [table.read_text().splitlines()[-1][:2] for table in tables] == ["0,", "1,"]


def test_members_without_tables_get_them_if_they_reached_a_step(tmp_path: Path) -> None:
    runs = drawn_ensemble(tmp_path).runs
    first = replace(runs[1].steps[0], status=Status.FAILED, reason="a solver failed")
    rewritten(runs[1], [first])
    found = read_ensemble(tmp_path).runs
    said = leave_missing_tables(found.values())
    assert said.endswith("fields: 2, all that reached a step")
    kept = {seed: run.path / "network.csv" for seed, run in found.items()}
    assert [table.exists() for table in kept.values()] == [True, False, True]
    kept[2].write_text("as it was")
    leave_missing_tables(found.values())
    assert kept[2].read_text() == "as it was", "what is there is left unchanged"
