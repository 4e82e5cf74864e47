"""The cache of compiled forms."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

ONE_FORM = """
from staffa.backend.stack import MPI
import ufl
from dolfinx import mesh
from staffa.backend import jit
square = mesh.create_unit_square(MPI.COMM_WORLD, 4, 4)
jit.form(ufl.SpatialCoordinate(square)[0] ** 7 * ufl.dx(square), MPI.COMM_WORLD)
print("compiled\\n", end="")
"""
COMMAND = [sys.executable, "-c", ONE_FORM]
# A compiler that never ends, and says where it was called.
SLOW = """#!/bin/sh
echo $$ > "$CALLED"
exec sleep 60
"""


@dataclass
class Compiling:
    """A process that compiles for ever, until it is killed; others find its cache in places."""

    process: subprocess.Popen
    compiler: int
    places: dict[str, str]
    cache: Path

    def kill(self) -> None:
        self.process.kill()
        self.process.wait(timeout=10)
        os.kill(self.compiler, signal.SIGKILL)


@pytest.fixture
def compiling(tmp_path: Path) -> Iterator[Compiling]:
    compiler, called = tmp_path / "cc", tmp_path / "called"
    compiler.write_text(SLOW)
    compiler.chmod(0o755)
    places = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / "cache"), "CALLED": str(called)}
    process = subprocess.Popen(COMMAND, env={**places, "CC": str(compiler)})
    while process.poll() is None and not (called.exists() and called.read_text()):
        time.sleep(0.05)
    yield Compiling(process, int(called.read_text()), places, tmp_path / "cache/staffa")
    process.kill()


@pytest.mark.slow
def test_who_waits_for_a_compilation_that_is_killed_does_it(compiling: Compiling) -> None:
    waiting = subprocess.Popen(COMMAND, env=compiling.places, stdout=subprocess.PIPE, text=True)
    with pytest.raises(subprocess.TimeoutExpired):
        waiting.wait(timeout=8)
    compiling.kill()
    assert waiting.communicate(timeout=60)[0] == "compiled\n"
