"""Runs on several ranks that are stopped, or lose a rank."""

import signal
import sys
from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from restart.test_killed import begin, expected, lines, place, wait_for  # noqa: F401
from staffa.io.run_directory import open_run
from staffa.runs.resume import resume
from support.paths import TESTS
from support.restarting import assert_same, launch


@pytest.mark.slow
def test_two_ranks_stop_together_and_a_rank_that_dies_ends_all(place, expected) -> None:
    """mpiexec passes SIGTERM on; then rank 1 alone is killed, and the lock is free."""
    directory = place / "two"
    process = begin(place, directory, ranks=2)
    assert wait_for(lambda: lines(directory) > 1, process)
    process.send_signal(signal.SIGTERM)
    _, said = process.communicate(timeout=120)
    assert said.count("stopped, since SIGTERM asked for it") == 1, said
    code = (
        "import os, signal\n"
        "from pathlib import Path\n"
        "from staffa.backend.stack import MPI\n"
        "from staffa.runs.run import Watcher\n"
        "from staffa.runs.resume import resume\n"
        "def die(moment, sweep):\n"
        f"    if MPI.COMM_WORLD.rank == 1 and moment.index == {lines(directory) + 1}:\n"
        "        os.kill(os.getpid(), signal.SIGKILL)\n"
        f"resume(Path({str(directory)!r}), watcher=Watcher(swept=die))\n"
    )
    before = lines(directory)
    died = launch(Path(sys.executable).name, "-c", code, ranks=2, timeout=120)
    assert died.returncode != 0 and lines(directory) == before + 1
    resume(directory)
    assert_same(open_run(directory), expected, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("error", "said"),
    [
        ("RuntimeError('rank one is ill')", "RuntimeError: rank one is ill"),
        ("StaffaError('rank one is ill')", "staffa: rank 1: rank one is ill"),
        ("PETSc.Error(77)", "staffa: rank 1: it broke: PETSc stopped with error 77"),
    ],
)
def test_a_rank_that_fails_alone_in_the_middle_ends_all(tmp_path: Path, error, said) -> None:
    """In a sweep; it waits for the others neither to write the step nor to destroy the solvers."""
    code = (
        "import sys\n"
        "from pathlib import Path\n"
        f"sys.path.insert(0, {str(TESTS)!r})\n"
        "from staffa.backend.stack import MPI, PETSc\n"
        "from support.restarting import small\n"
        "from staffa.backend import parallel\n"
        "from staffa.runs.run import Watcher, run\n"
        "from staffa.cli.live import ending_all_ranks\n"
        "from staffa.errors import StaffaError\n"
        "from staffa.backend.petsc_options import petsc_errors\n"
        "parallel.TOGETHER = 2\n"
        "def fall_ill(*met):\n"
        "    if MPI.COMM_WORLD.rank == 1:\n"
        "        with petsc_errors('it broke', PETSc.Comm(MPI.COMM_WORLD)):\n"
        f"            raise {error}\n"
        f"directory = Path({str(tmp_path / 'run')!r})\n"
        "with ending_all_ranks(MPI.COMM_WORLD, directory):\n"
        "    run(small(), directory, watcher=Watcher(swept=fall_ill))\n"
    )
    ended = launch(Path(sys.executable).name, "-c", code, ranks=2, timeout=60)
    assert ended.returncode != 0 and ended.stderr.count(said) == 1, ended
