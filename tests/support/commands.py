"""Commands of staffa in a process that is forked from the tests, whose libraries are loaded.

Such a process starts in no time. It has a separate folder, streams, exit code and lock.
"""

import os
import signal
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from pathlib import Path
from typing import NoReturn


def forked(
    *arguments: str | Path, folder: Path | None = None, timeout: float = 300
) -> subprocess.CompletedProcess[str]:
    """Run `staffa ARGUMENTS` in a folder; return its exit code and what it printed.

    Raises
    ------
    TimeoutExpired
        It took longer than `timeout` (s), and was killed.
    """
    import staffa.cli.live
    import staffa.cli.members  # noqa: F401 (and all that they load, once and not in each child)

    words = ["staffa", *map(str, arguments)]
    with tempfile.TemporaryFile("w+") as said, tempfile.TemporaryFile("w+") as complained:
        sys.stdout.flush()
        with warnings.catch_warnings():
            # Threads of libraries do not go along; none of them holds what a command needs.
            warnings.simplefilter("ignore", DeprecationWarning)
            child = os.fork()
        if child == 0:
            _become(words, folder, said.fileno(), complained.fileno())
        code = _exit_code(child, words, timeout)
        said.seek(0)
        complained.seek(0)
        return subprocess.CompletedProcess(words, code, said.read(), complained.read())


def _exit_code(child: int, words: list[str], timeout: float) -> int:
    """Wait for a process to end."""
    last = time.monotonic() + timeout
    while time.monotonic() < last:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.01)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    raise subprocess.TimeoutExpired(words, timeout)


def _become(words: list[str], folder: Path | None, out: int, err: int) -> NoReturn:
    """Be the command, from its arguments to its exit code."""
    code: object = 1
    try:
        if folder is not None:
            os.chdir(folder)
        for number, stream in ((0, os.open(os.devnull, os.O_RDONLY)), (1, out), (2, err)):
            os.dup2(stream, number)
        sys.stdout = sys.__stdout__ = open(1, "w", closefd=False)  # noqa: SIM115 (till the end)
        sys.stderr = sys.__stderr__ = open(2, "w", closefd=False)  # noqa: SIM115
        sys.argv = words
        _filter_warnings()
        from staffa.cli import main

        main()
        code = 0
    except SystemExit as end:
        code = 0 if end.code is None else end.code
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code if isinstance(code, int) else 1)


def _filter_warnings() -> None:
    """Filter warnings as Python does by default, not as pytest does."""
    warnings.resetwarnings()
    for kind in (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning):
        warnings.simplefilter("ignore", kind)
