"""Faults of one rank of several: all end, with one sentence."""

import subprocess
import sys
from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from run.test_faults import (
    case,  # noqa: F401
    failed,
)
from staffa.io.run_directory import open_run
from support.restarting import launch

pytestmark = pytest.mark.timeout(300)


@pytest.mark.parametrize(
    ("wrong", "words"), [("--wall-time=soon", "--wall-time soon: it must"), ("--fast", "--fast")]
)
def test_a_wrong_command_is_told_of_once(case: Path, wrong: str, words: str) -> None:
    done = launch("staffa", "run", case, wrong, ranks=2)
    assert done.returncode == 2 and done.stderr.count(words) == 1, done


RANKS = """
import shutil
from pathlib import Path
from staffa.backend.stack import MPI
import numpy as np
from staffa.runs.run import Watcher, run
from staffa.case.reading.read import read_case
from staffa.cli import commands, live
from staffa.loads.closed_form import Face, Slab
comm, folder = MPI.COMM_WORLD, Path({folder!r})
case = read_case(folder / "my.toml", ["time.tau=[0.1,0.3,0.6]", "output.at=[]"])

class Ill(Slab):
    def temperature(self, x, t):
        T = np.array(super().temperature(x, t))
        if 0.003 < t < 0.01 and comm.rank == comm.size - 1:
            T[-1:] = np.nan
        return T

def leave(step):
    if step.index == 1 and comm.rank == 0:
        shutil.rmtree(folder / "run")

ill = Ill(dT=12.6, kappa=1.0, face=Face(axis=1, position=0.0, inward=1.0), L=0.4)
works = {{"nan": {{"temperature": ill}}, "gone": {{"watcher": Watcher(stepped=leave)}}}}

def app():
    with live.ending_all_ranks(comm, folder / "run"):
        run(case, folder / "run", **works[{name!r}])

commands.app = app
commands.main()
"""


def on_two_ranks(folder: Path, name: str) -> subprocess.CompletedProcess:
    """A run with such a fault, ended as the command ends it."""
    code = RANKS.format(folder=str(folder), name=name)
    return launch(Path(sys.executable).name, "-c", code, ranks=2, timeout=120)


def test_what_is_not_a_number_on_one_rank_ends_all(case: Path) -> None:
    """In the second step, at one vertex: what was finished before it is on disk. (At the first and
    the last time a load is tried before anything is computed.)"""
    failed(on_two_ranks(case.parent, "nan"), "step 1 (time ", "not finite")
    run = open_run(case.with_name("run"))
    assert [step.status for step in run.audited] == ["converged", "failed"] and run.unreached


def test_a_directory_that_is_removed_ends_all_ranks(case: Path) -> None:
    failed(on_two_ranks(case.parent, "gone"), "it is gone, and with it the run; start it again")
