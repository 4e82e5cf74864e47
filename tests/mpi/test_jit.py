"""A compiler that was killed, and ranks that need its form."""

import subprocess

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from run.test_jit import (
    COMMAND,
    Compiling,
    compiling,  # noqa: F401
)
from support.paths import BIN


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [1, 2])
def test_a_compilation_that_was_killed_is_done_again(ranks: int, compiling: Compiling) -> None:
    """Its half-made source does not keep others waiting, one rank or two."""
    compiling.kill()
    assert list(compiling.cache.glob("*/*.c")) and not list(compiling.cache.glob("*/*.cached"))
    mpiexec = BIN / "mpiexec"
    command = [mpiexec, "-n", str(ranks), *COMMAND]
    after = subprocess.run(
        command, env=compiling.places, capture_output=True, text=True, timeout=60
    )
    assert after.stdout == "compiled\n" * ranks, after.stderr
    assert len(list(compiling.cache.glob("*/*.cached"))) == 1
