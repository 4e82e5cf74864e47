"""Real faults during a run: it ends in a sentence, and never hangs."""

import subprocess
import sys
from pathlib import Path

import pytest

from staffa.io.run_directory import open_run
from support.restarting import SMALL, assert_steps, launch

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
    found = open_run(out)
    step = found.unreached
    assert found.steps == () and step is not None
    assert step.status == "failed" and step.reason in done.stderr and step.audit is None


@pytest.mark.slow
def test_an_option_that_petsc_does_not_know_ends_the_run(case: Path, monkeypatch) -> None:
    monkeypatch.setenv("PETSC_OPTIONS", "-u_direct_ksp_type nonsense")
    done = launch("staffa", "run", case, "--out", case.with_name("run"), *SHORT)
    failed(done, "the solvers could not be made; see what PETSC_OPTIONS asks for")
    assert not case.with_name("run").exists()


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
        ended.append(open_run(folder / name))
    code = "import time; before = time.time(); print(time.time() < before - 3000)"
    assert launch(Path(sys.executable).name, "-c", code).stdout == "True\n", "nothing was tested"
    right, back = ended
    assert_steps(back.steps, right.steps, rel=0.0)
    assert all(0 < step.seconds < 60 for step in back.steps), [s.seconds for s in back.steps]
    assert [p.name for p in (folder / "back" / "checkpoint").glob("*.json")] == ["000003.json"]
