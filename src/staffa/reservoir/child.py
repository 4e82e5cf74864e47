"""Process of a simulator: asked by messages, within a time, and ended by its id."""

import os
import signal
import socket
import subprocess
import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from staffa.reservoir.message_frames import FrameError, pack, unpack

# Of a launcher of ranks, of this Python, and libraries that go before the simulator's own.
STRIPPED = ("PMI", "HYDI", "HYDRA", "MPI", "OMPI", "PRTE", "PMIX", "PYTHON", "LD_PRELOAD")
PATIENCE = 600.0  # s that an answer may take
MORE_THAN_LAST = 20.0  # times that the last answer took


class ChildError(Exception):
    """A process that ended, was silent for too long, or said what is no message."""


class Child:
    """A process that answers one question after another.

    It is in a separate session, so an interrupt of the terminal reaches the caller alone, and in a
    separate folder, which is deleted with it. Its file 0 is a socket: a write to a process that
    has ended is an error, and no signal, for which PETSc would end all ranks.

    Parameters
    ----------
    command : the program and its arguments.
    patience : time within which it answers (s), or `MORE_THAN_LAST` times as long as the last time.
    """

    def __init__(self, command: Sequence[str | Path], *, patience: float = PATIENCE) -> None:
        self.patience = patience
        self.last = 0.0
        self.folder = TemporaryDirectory(prefix="staffa-reservoir-")
        self.said = Path(self.folder.name) / "said.txt"
        self.line, theirs = socket.socketpair()
        try:
            with self.said.open("wb") as said:
                self.process = subprocess.Popen(
                    [str(word) for word in command], cwd=self.folder.name, env=environment(),
                    stdin=theirs.fileno(), stdout=said, stderr=said, start_new_session=True,
                )  # fmt: skip
        except OSError as error:
            self.line.close()
            self.folder.cleanup()
            raise ChildError(f"{command[0]} cannot be started ({error.strerror})") from None
        finally:
            theirs.close()

    def ask(self, head: Any, arrays: Sequence[np.ndarray] = ()) -> tuple[Any, list[np.ndarray]]:
        """Send a message and return the answer.

        Parameters
        ----------
        head : content of the message.
        arrays : its arrays.

        Raises
        ------
        ChildError
            There is no answer. The process is ended.
        """
        start = time.monotonic()
        limit = max(self.patience, MORE_THAN_LAST * self.last)
        try:
            self.line.settimeout(limit)
            self.line.sendall(pack(head, arrays), socket.MSG_NOSIGNAL)
            answer = unpack(lambda n: self._read(n, start + limit))
        except TimeoutError:
            raise self._ended(f"it gave no answer within {limit:g} s") from None
        except FrameError as error:
            raise self._ended(f"it sent {error}") from None
        except (OSError, EOFError):
            raise self._ended("") from None
        self.last = time.monotonic() - start
        return answer

    def close(self) -> None:
        """End the process, and delete its folder."""
        if self.process.poll() is None:
            os.killpg(self.process.pid, signal.SIGKILL)
            self.process.wait()
        self.line.close()
        self.folder.cleanup()

    def _read(self, n: int, until: float) -> bytes:
        """Return n bytes, or raise."""
        data, got = bytearray(n), 0
        while got < n:
            self.line.settimeout(max(until - time.monotonic(), 1e-3))
            more = self.line.recv_into(memoryview(data)[got:])
            if not more:
                raise EOFError
            got += more
        return bytes(data)

    def _ended(self, why: str) -> ChildError:
        """End the process and return the error that says why, with its last lines."""
        if not why:
            try:
                code = self.process.wait(5.0)
                name = signal.Signals(-code).name if code < 0 else f"exit code {code}"
                why = f"it ended with {name}"
            except subprocess.TimeoutExpired:
                why = "it closed its side"
        lines = self.said.read_text(errors="replace").split("\n") if self.said.exists() else []
        last = [line.strip() for line in lines if line.strip()][-3:]
        self.close()
        return ChildError(why + (f"; it said last: {' | '.join(last)}" if last else ""))


def environment() -> dict[str, str]:
    """Return the environment of the process: no rank, one thread, nothing of this Python."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(STRIPPED)}
    return kept | {"OMP_NUM_THREADS": "1"}
