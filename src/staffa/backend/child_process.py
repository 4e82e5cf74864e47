"""Child processes, in which something may crash or hang."""

import os
import signal
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryFile
from threading import Timer

from staffa.errors import StaffaError


def output_of(
    command: Sequence[str | Path],
    *,
    seconds: float,
    folder: Path | None = None,
    asked: str = "",
    heard: Callable[[], None] = lambda: None,
) -> str:
    """Run a command and return its standard output.

    Parameters
    ----------
    command : the program and its arguments.
    seconds : time after which it is killed, its own children with it.
    folder : in which it runs; None for the current one.
    asked : its standard input.
    heard : called after each line of its output.

    Raises
    ------
    StaffaError
        It cannot be started, fails, or takes longer.
    """
    name, lines = Path(command[0]).name, []
    with TemporaryFile("w+") as into, TemporaryFile("w+", errors="replace") as errors:
        into.write(asked)
        into.seek(0)
        try:
            child = subprocess.Popen(
                [str(word) for word in command], cwd=folder, stdin=into, stdout=subprocess.PIPE,
                stderr=errors, text=True, errors="replace",
                start_new_session=True,  # so that its own children can be killed with it
            )  # fmt: skip
        except OSError as error:
            raise StaffaError(f"{name} cannot be started ({error.strerror})") from None
        limit = Timer(seconds, os.killpg, (child.pid, signal.SIGKILL))
        limit.start()
        with child:
            for line in child.stdout or ():
                lines.append(line)
                heard()
        expired = limit.finished.is_set()
        limit.cancel()
        errors.seek(0)
        said = errors.read()
    if expired:
        raise StaffaError(f"{name} did not end within {seconds:g} s")
    if child.returncode < 0:
        raise StaffaError(f"{name} was ended by {signal.Signals(-child.returncode).name}")
    if child.returncode:
        raise StaffaError(last_words(said) or last_words("".join(lines)) or f"{name} failed")
    return "".join(lines)


def last_words(text: str) -> str:
    """Return the line that tells most: the last that names an error, or the last of all."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    telling = [line for line in lines if "rror:" in line or line.startswith("staffa:")]
    return (telling or lines or [""])[-1]
