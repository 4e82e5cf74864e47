"""Files that staffa writes: atomic, and never through a symbolic link."""

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO

from staffa.errors import InputError

HALF = ".staffa-part"  # of a name, while the file is being written
PICTURES, PAGE, NETWORK = "pictures", "report.html", "network.csv"
GENERATOR = '<meta name="generator" content="staffa">'  # by which a page is known as one of ours
NEW = os.O_CREAT | os.O_EXCL | os.O_NOFOLLOW | os.O_CLOEXEC


def write_aside(path: Path, content: str | bytes) -> None:
    """Write a file atomically, power failures included; a symbolic link there is replaced."""
    with opened_aside(path) as file:
        file.write(content.encode() if isinstance(content, str) else content)


@contextmanager
def opened_aside(path: Path) -> Iterator[IO[bytes]]:
    """Yield a file to write, which then takes its place as `write_aside` does; none after an error.

    Parameters
    ----------
    path : its place.
    """
    aside = path.with_name(f".{path.name}{HALF}")
    try:
        aside.unlink(missing_ok=True)  # of a run that was killed
        with os.fdopen(os.open(aside, os.O_WRONLY | NEW, 0o666), "wb") as file:
            yield file
            file.flush()
            os.fsync(file.fileno())
    except BaseException:
        with suppress(OSError):
            aside.unlink(missing_ok=True)  # on a full disk it takes the room of what is needed
        raise
    aside.replace(path)
    keep_names(path.parent)


def to_append(path: Path) -> IO[str]:
    """A file to append lines to, made if it is not there; never what a symbolic link leads to, nor
    a pipe that nobody reads."""
    flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC
    return os.fdopen(os.open(path, flags, 0o666), "a", encoding="utf-8")


def make_folder(folder: Path) -> None:
    """Make a folder of a run, and its parents, if it is missing.

    Raises
    ------
    InputError
        There is a symbolic link in its place: it is not followed.
    """
    if folder.is_symlink():
        raise InputError(
            f"{folder} is a symbolic link, which is not followed; remove it, or put there what it "
            f"leads to"
        )
    folder.mkdir(parents=True, exist_ok=True)


def remove_halves(path: Path) -> None:
    """Remove unfinished files of a killed run in its own folders."""
    inside = (folder for folder in path.iterdir() if folder.is_dir() and not folder.is_symlink())
    for folder in (path, *inside):
        for half in folder.glob(f".*{HALF}"):
            if half.is_symlink() or not half.is_dir():
                half.unlink()


def keep_names(path: Path) -> None:
    """Write the list of files of a folder to disk (fsync): a file's name is stored there."""
    folder = os.open(path, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)
