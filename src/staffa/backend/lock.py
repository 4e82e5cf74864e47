"""The lock of a folder, which the kernel takes back with the process that holds it."""

import fcntl
import os
import socket
import stat
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from errno import EACCES, EAGAIN
from pathlib import Path

from staffa.errors import InputError

LOCK = "lock"  # the file that it lies on


class Lock:
    """The lock of a run directory, or of the cache of compiled forms.

    The file that it lies on is not followed if it is a symbolic link. Each use of a `Lock` is by
    one rank alone.
    """

    def __init__(self, folder: Path) -> None:
        """Name the folder, which exists when the lock is taken."""
        self._path = folder / LOCK
        self._file: int | None = None

    def take(self) -> str | None:
        """Hold it until `release`, or the end of this process; the file tells who holds it.

        Returns
        -------
        str or None
            A sentence if there is something to say: that whoever held it is gone, or that this file
            system has no locks.

        Raises
        ------
        InputError
            Another process holds it, or it cannot be made.
        """
        folder = self._path.parent
        try:
            self._file = self._opened()
        except OSError as error:
            raise InputError(
                f"{folder} cannot be written to ({error.strerror}); see to that first, or go on "
                f"with a copy of it"
            ) from None
        if not stat.S_ISREG(os.fstat(self._file).st_mode):
            self._close()
            raise InputError(f"{self._path} is no ordinary file; remove it")
        holder = os.pread(self._file, 200, 0).decode(errors="replace").strip()
        said = f"{holder} was cut while it wrote to {folder}" if holder else None
        refused = _refused(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if refused in (EACCES, EAGAIN):
            self._close()
            raise InputError(
                f"{folder} is being written to by {holder or 'another process'}; wait for it, or "
                f"stop it"
            )
        if refused:
            said = f"{folder} lies on a file system without locks: run nothing else in it"
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

    @contextmanager
    def held(self, *, shared: bool = False, wait: bool = True) -> Iterator[bool]:
        """Hold it for a while; yield False where that fails.

        It fails where another holds it, where the file system has no locks, and where the file
        cannot be made.

        Parameters
        ----------
        shared : whether others may share it.
        wait : whether to wait for those who have it.
        """
        kind = fcntl.LOCK_SH if shared else fcntl.LOCK_EX
        try:
            self._file = self._opened()
        except OSError:
            yield False
            return
        try:
            yield not _refused(self._file, kind if wait else kind | fcntl.LOCK_NB)
        finally:
            self._close()

    def is_held(self) -> bool:
        """Return True if it is held; False also where that cannot be told.

        It cannot be told where the file cannot be read, and where the file system has no locks.
        """
        try:
            file = os.open(self._path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
        except OSError:
            return False
        try:
            if not os.fstat(file).st_size:  # who holds it writes a name into it
                return False
            return _refused(file, fcntl.LOCK_SH | fcntl.LOCK_NB) in (EACCES, EAGAIN)
        finally:
            os.close(file)

    def _opened(self) -> int:
        flags = os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC
        return os.open(self._path, flags, 0o644)

    def _close(self) -> None:
        assert self._file is not None
        os.close(self._file)  # the lock goes with it
        self._file = None


def _refused(file: int, kind: int) -> int:
    """Lock an open file; return the number of the error, 0 if there was none."""
    try:
        fcntl.flock(file, kind)
    except OSError as error:
        return error.errno or EAGAIN
    return 0
