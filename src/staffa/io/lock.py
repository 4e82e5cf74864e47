"""One writer a run directory: a lock that the kernel takes back with the process that holds it."""

import fcntl
import os
import socket
import stat
from contextlib import suppress
from errno import EACCES, EAGAIN
from pathlib import Path

from staffa.errors import InputError
from staffa.io.run_directory import LOCK


class Lock:
    """The lock of a run directory. Where it lies in a file, which tells who holds it."""

    def __init__(self, directory: Path) -> None:
        self._path = directory / LOCK
        self._file: int | None = None

    def take(self) -> str | None:
        """Hold it until `release`, or the end of this process; a sentence if there is something to
        say: that whoever held it is gone, or that this file system has no locks.

        Raises
        ------
        InputError
            Another process holds it, or it cannot be made.
        """
        try:
            self._file = os.open(
                self._path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o644
            )
        except OSError as error:
            raise InputError(
                f"{self._path.parent} cannot be written to ({error.strerror}); see to that first, "
                f"or go on with a copy of it"
            ) from None
        if not stat.S_ISREG(os.fstat(self._file).st_mode):
            self._close()
            raise InputError(f"{self._path} is no ordinary file; remove it")
        holder = os.pread(self._file, 200, 0).decode(errors="replace").strip()
        said = f"{holder} was cut while it wrote to {self._path.parent}" if holder else None
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if error.errno in (EACCES, EAGAIN):
                self._close()
                raise InputError(
                    f"{self._path.parent} is being written to by {holder or 'another process'}; "
                    f"wait for it, or stop it"
                ) from None
            said = (
                f"{self._path.parent} lies on a file system without locks: run nothing else in it"
            )
        with suppress(OSError):  # a full disk: what it says is for people only
            os.ftruncate(self._file, 0)
            os.pwrite(self._file, f"process {os.getpid()} on {socket.gethostname()}\n".encode(), 0)
        return said

    def release(self) -> None:
        """Let others write."""
        if self._file is not None:
            with suppress(OSError):
                os.ftruncate(self._file, 0)
            self._close()

    def _close(self) -> None:
        assert self._file is not None
        os.close(self._file)  # the lock goes with it
        self._file = None
