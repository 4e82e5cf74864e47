"""Real faults during a run: it ends in a sentence, and never hangs."""

import subprocess
import sys
from pathlib import Path

import pytest

from restarting import SMALL, assert_steps, launch
from staffa.io.run_directory import read_run

pytestmark = pytest.mark.timeout(300)

SHORT = ("--set", "time.tau=[0.1,0.3,0.6]", "--set", "output.at=[]", "--quiet")


@pytest.fixture
def case(tmp_path: Path) -> Path:
    (tmp_path / "my.toml").write_text(SMALL)
    return tmp_path / "my.toml"


def failed(done: subprocess.CompletedProcess, *parts: str) -> None:
    """True if a run ended with code 1 and one sentence of these parts."""
    assert (done.returncode, done.stdout) == (1, ""), done
    assert done.stderr.count("staffa: ") == 1 and "Traceback" not in done.stderr, done.stderr
    for part in parts:
        assert part in done.stderr, done.stderr


NO_DAMAGE = "-alpha_tao_tao_max_it 1 -alpha_snes_snes_max_it 1"
STOPPED = "-u_iterative_ksp_max_it 1 -u_direct_ksp_max_it 1 -u_direct_pc_type jacobi"
STAGNANT = {
    "the linear solvers": ("solver.displacement=iterative", STOPPED),
    "both solvers of the damage": ("solver.acceleration=none", NO_DAMAGE),
    "the whole, below round-off": ("solver={residual=1e-30,change=1e-29}", ""),
}


@pytest.mark.long
@pytest.mark.parametrize("what", STAGNANT)
def test_a_solver_that_gets_no_further_ends_the_run(case: Path, what: str, monkeypatch) -> None:
    setting, options = STAGNANT[what]
    monkeypatch.setenv("PETSC_OPTIONS", options)
    out = case.with_name("run")
    done = launch("staffa", "run", case, "--out", out, *SHORT, "--set", setting, timeout=200)
    failed(done, "step 0 (time 0.0004) failed: ", "not ", "try ")
    (step,) = read_run(out).steps
    assert step.status == "failed" and step.reason in done.stderr and step.audit is None


@pytest.mark.slow
def test_an_option_that_petsc_does_not_know_ends_the_run(case: Path, monkeypatch) -> None:
    monkeypatch.setenv("PETSC_OPTIONS", "-u_direct_ksp_type nonsense")
    done = launch("staffa", "run", case, "--out", case.with_name("run"), *SHORT)
    failed(done, "the solvers could not be made; see what PETSC_OPTIONS asks for")
    assert not case.with_name("run").exists()


@pytest.mark.mpi
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


@pytest.mark.mpi
def test_what_is_not_a_number_on_one_rank_ends_all(case: Path) -> None:
    """In the second step, at one vertex: what was finished before it is on disk. (At the first and
    the last time a load is tried before anything is computed.)"""
    failed(on_two_ranks(case.parent, "nan"), "step 1 (time ", "not finite")
    assert [step.status for step in read_run(case.with_name("run")).steps] == [
        *("converged", "failed")
    ]


@pytest.mark.mpi
def test_a_directory_that_is_removed_ends_all_ranks(case: Path) -> None:
    failed(on_two_ranks(case.parent, "gone"), "it is gone, and with it the run; begin again")


CLOCK = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <time.h>
/* The clock of the day goes back by an hour each time that it is looked at. */
int clock_gettime(clockid_t id, struct timespec *now)
{
    static long looks;
    static int (*real)(clockid_t, struct timespec *);
    if (!real) real = (int (*)(clockid_t, struct timespec *))dlsym(RTLD_NEXT, "clock_gettime");
    int failed = real(id, now);
    if (id == CLOCK_REALTIME) now->tv_sec -= 3600 * ++looks;
    return failed;
}
"""


@pytest.mark.long
def test_a_clock_that_is_set_back_changes_nothing(case: Path, monkeypatch) -> None:
    """Not the steps, nor their seconds, nor the wall time, nor when the run is saved."""
    folder = case.parent
    (folder / "clock.c").write_text(CLOCK)
    compile_it = ["cc", "-shared", "-fPIC", "clock.c", "-o", "clock.so", "-ldl"]
    subprocess.run(compile_it, cwd=folder, check=True, timeout=60)
    limits = ("--wall-time", "1 h", "--set", "output.checkpoint={steps=1000,minutes=30}")
    ended = []
    for name, library in (("right", ""), ("back", str(folder / "clock.so"))):
        monkeypatch.setenv("LD_PRELOAD", library)
        done = launch("staffa", "run", case, "--quiet", "--out", folder / name, *SHORT, *limits)
        assert (done.returncode, done.stderr) == (0, ""), done.stderr
        ended.append(read_run(folder / name))
    code = "import time; before = time.time(); print(time.time() < before - 3000)"
    assert launch(Path(sys.executable).name, "-c", code).stdout == "True\n", "nothing was tested"
    right, back = ended
    assert_steps(back.steps, right.steps, rel=0.0)
    assert all(0 < step.seconds < 60 for step in back.steps), [s.seconds for s in back.steps]
    assert [p.name for p in (folder / "back" / "checkpoint").glob("*.json")] == ["000003.json"]
