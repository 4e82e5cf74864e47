"""Other processes, in which what is looked at may crash or hang."""

import os
import signal
import subprocess
from collections.abc import Sequence
from pathlib import Path

from staffa.backend import isolation
from staffa.errors import StaffaError


def spoken(command: Sequence[str | Path], *, seconds: float, folder: Path | None = None) -> str:
    """What a process prints.

    Raises
    ------
    StaffaError
        It cannot be started, fails, or takes longer than so many seconds.
    """
    name = Path(command[0]).name
    try:
        process = subprocess.Popen(
            [str(word) for word in command],
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            errors="replace",
            start_new_session=True,  # so that its own children can be ended with it
        )
    except OSError as error:
        raise StaffaError(f"{name} cannot be started ({error.strerror})") from None
    try:
        out, err = process.communicate(timeout=seconds)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        process.communicate()
        raise StaffaError(f"{name} did not end within {seconds:g} s") from None
    if process.returncode < 0:
        raise StaffaError(f"{name} was ended by {signal.Signals(-process.returncode).name}")
    if process.returncode:
        raise StaffaError(_last_words(err) or _last_words(out) or f"{name} failed")
    return out


def python(code: str, *, seconds: float = 60, launcher: Sequence[str] = ()) -> str:
    """What this Python prints in another process, or in several; errors as of `spoken`."""
    command = [*launcher, *isolation.isolated_python(code)]
    return spoken(command, seconds=seconds, folder=Path(isolation.NOWHERE))


def _last_words(text: str) -> str:
    """The line that tells most: the last that names an error, or the last of all."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    telling = [line for line in lines if "rror:" in line or line.startswith("staffa:")]
    return (telling or lines or [""])[-1]
