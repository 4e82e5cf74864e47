"""The scripts of `make bench` on several ranks."""

import json
import subprocess
import sys
from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from support.paths import BIN, ROOT


@pytest.mark.slow
def test_a_side_alone_writes_down_its_step(tmp_path: Path) -> None:
    """The machinery of turns, on the smallest of the cases that run.py knows."""
    mpiexec = BIN / "mpiexec"
    command = [
        mpiexec,
        "-n",
        "2",
        sys.executable,
        "-m",
        "bench.yardstick.side",
        "alone",
        "A30k",
        tmp_path,
        "1",
    ]
    subprocess.run(command, check=True, timeout=300, cwd=ROOT)
    record = json.loads((tmp_path / "alone-0-0.json").read_text())
    assert (
        record["sweeps"] > 1
        and record["wall_s"] > 0
        and record["peak_MB"] > record["libraries_MB"] > 100
    )


@pytest.mark.slow
def test_a_run_of_the_scaling_is_counted_on_all_ranks() -> None:
    mpiexec = BIN / "mpiexec"
    runs = {}
    for ranks in (1, 2):
        command = [mpiexec, "-n", str(ranks), sys.executable, "-m", "bench.scaling.run"]
        done = subprocess.run(
            [*command, "--one", "4", "hexahedron"],
            check=True,
            timeout=300,
            capture_output=True,
            text=True,
            cwd=ROOT,
        )
        runs[ranks] = json.loads(done.stdout)
    one, two = runs[1], runs[2]
    assert one["unknowns"] == two["unknowns"] == 3 * 5 * 5 * 14
    assert one["energy"] == pytest.approx(two["energy"], rel=1e-5)
    assert two["ranks"] == 2 and two["peak_bytes"] > 1.5 * one["peak_bytes"]
