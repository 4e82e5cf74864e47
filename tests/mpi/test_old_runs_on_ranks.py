"""Runs of 0.1.0 go on, on two ranks."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from staffa.io.run_directory import open_run

DATA = Path(__file__).parents[1] / "data" / "runs-0.1.0"
BIN = Path(sys.executable).parent


@pytest.mark.mpi
@pytest.mark.slow
@pytest.mark.parametrize("name", ["slab", "granite"])
def test_it_is_resumed_on_two_ranks(name: str, tmp_path: Path) -> None:
    run = shutil.copytree(DATA / name, tmp_path / name)
    command = [BIN / "mpiexec", "-n", "2", BIN / "staffa", "resume", run, "--quiet"]
    done = subprocess.run(
        [str(word) for word in command],
        capture_output=True,
        text=True,
        timeout=300,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    found = open_run(run)
    assert found.finished and found.manifest.ranks == 2
    ends = json.loads((DATA / "ends.json").read_text(encoding="utf-8"))[name]
    # To the tolerance of the minimization: sums over ranks round otherwise.
    assert [step.energies.total for step in found.steps] == pytest.approx(ends, rel=1e-6)
