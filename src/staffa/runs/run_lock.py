"""Right to write to a run directory: what it must contain, and its lock."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from staffa.backend.stack import MPI

from staffa.backend.lock import Lock
from staffa.backend.parallel import on_root
from staffa.errors import InputError
from staffa.io import run_directory
from staffa.runs.checkpoints import on_disk


def require_new(directory: Path) -> None:
    """Refuse a directory that contains a run, or in which none can be made."""
    way_out = f"go on with `staffa resume {directory}` if it is not finished, or choose another one"
    run_directory.require_free(directory, way_out)


@contextmanager
def hold_run_lock(comm: MPI.Comm, directory: Path, *, new: bool = False) -> Iterator[str | None]:
    """Hold the lock of a run directory, and yield its message if it has one. Collective.

    Parameters
    ----------
    comm : communicator of all ranks.
    directory : the run directory.
    new : True if it must not contain a run, and is made.

    Raises
    ------
    InputError
        Another process writes to it, or it cannot be written to.
    """
    lock = Lock(directory)

    def take() -> str | None:
        if new:
            directory.mkdir(parents=True, exist_ok=True)
        said = lock.take()
        if new:
            require_new(directory)
        return said

    with on_disk(directory, started=False):
        said = on_root(comm, take)
    try:
        yield said
    finally:
        if comm.rank == 0:  # an error may be one rank's alone: nothing is waited for here
            lock.release()


def require_run(directory: Path) -> None:
    """Refuse a folder without a run, before a lock is made in it."""
    if not directory.is_dir():
        raise InputError(f"there is no folder {directory}; name that of a run")
    if not (directory / run_directory.MANIFEST).is_file():
        raise InputError(
            f"{directory} is no run directory: it has no {run_directory.MANIFEST}; name one or, if "
            f"a run was cut in it before it began, remove it and run the case again"
        )
