"""Ranks that wait for scripts: mpiexec starts once for all tests, not once for each.

A rank waits on a socket and not in MPI, whose waiting ranks would take all of their cores.
"""

import atexit
import contextlib
import io
import os
import subprocess
import sys
import tempfile
import traceback
import warnings
from functools import cache
from multiprocessing.connection import Client, Connection, Listener
from pathlib import Path

from support.paths import BIN, TESTS

# Seconds that a script may take, and that the other ranks have once one has failed.
PATIENCE, AFTER_A_FAILURE = 300.0, 5.0
KEY = os.urandom(16)
# Ranks of MPICH that wait for others keep their core. Where there are more ranks than cores, this
# makes them give it away: 500 sums over three ranks on two cores take 0.7 s in place of 2.
GIVING_WAY = {"MPIR_CVAR_ENABLE_HEAVY_YIELD": "1"}


class Ranks:
    """Processes under one mpiexec; scripts run on all of them, one after the other."""

    def __init__(self, number: int) -> None:
        with (
            tempfile.TemporaryDirectory() as folder,
            Listener(str(Path(folder) / "socket"), authkey=KEY) as listener,
        ):
            crowded = GIVING_WAY if number > (os.cpu_count() or 1) else {}
            here = {"OMP_NUM_THREADS": "1", "STAFFA_RANKS_KEY": KEY.hex(), **crowded}
            mpiexec = [str(BIN / "mpiexec"), "-n", str(number)] if number > 1 else []
            self.process = subprocess.Popen(
                [*mpiexec, sys.executable, "-m", "support.ranks", listener.address],
                cwd=TESTS,
                env={**os.environ, **here},
            )
            met = [listener.accept() for _ in range(number)]
        self.ranks = [rank for _, rank in sorted((rank.recv(), rank) for rank in met)]

    def run(self, code: str) -> str:
        """Run a script on all ranks, and return what they print, rank by rank.

        Raises
        ------
        AssertionError
            The script failed on a rank, or took too long; no script can follow.
        """
        for rank in self.ranks:
            rank.send(code)
        printed, failures, patience = [], [], PATIENCE
        for number, rank in enumerate(self.ranks):
            text, failure = _answer(rank, patience)
            printed.append(text)
            if failure:
                failures.append(f"rank {number}: {failure}")
                patience = AFTER_A_FAILURE
        if failures:
            self.end()
            raise AssertionError("\n".join(failures))
        return "".join(printed)

    def end(self) -> None:
        """End the processes."""
        for rank in self.ranks:
            rank.close()
        try:
            self.process.wait(AFTER_A_FAILURE)
        except subprocess.TimeoutExpired:
            self.process.terminate()
            self.process.wait()
        waiting.cache_clear()


def _answer(rank: Connection, patience: float) -> tuple[str, str]:
    """Return what a rank printed, and how it failed where it did."""
    try:
        return rank.recv() if rank.poll(patience) else ("", "it did not end")
    except (EOFError, OSError):
        return "", "its process ended"


@cache
def waiting(number: int) -> Ranks:
    """Return as many ranks, which are started when they are first asked for."""
    ranks = Ranks(number)
    atexit.register(ranks.end)
    return ranks


def printed_on(ranks: int, code: str) -> list[list[str]]:
    """Return the words of each line that a script prints on ranks, in the folder of the tests."""
    return [line.split() for line in waiting(ranks).run(code).splitlines()]


def staffa_on(ranks: int, *arguments: str | Path) -> str:
    """Run a command of staffa on ranks, which must succeed; return what it prints."""
    words = ["staffa", *map(str, arguments)]
    code = f"import sys\nfrom staffa.cli import main\nsys.argv = {words!r}\nmain()"
    return waiting(ranks).run(code)


def serve(address: str) -> None:
    """Run scripts as they come, until the tests are over."""
    from staffa.backend.stack import MPI

    import support.compiling  # noqa: F401

    with Client(address, authkey=bytes.fromhex(os.environ["STAFFA_RANKS_KEY"])) as tests:
        tests.send(MPI.COMM_WORLD.rank)
        with contextlib.suppress(EOFError):
            while True:
                tests.send(_outcome(tests.recv()))


def _outcome(code: str) -> tuple[str, str]:
    """Run a script; return what it prints, and its traceback where it fails."""
    said, failure = io.StringIO(), ""
    with contextlib.redirect_stdout(said), warnings.catch_warnings():
        try:
            exec(compile(code, "<on ranks>", "exec"), {"__name__": "__main__"})
        except BaseException as end:
            if not (isinstance(end, SystemExit) and end.code in (None, 0)):
                failure = traceback.format_exc()
    return said.getvalue(), failure


if __name__ == "__main__":
    serve(sys.argv[1])
