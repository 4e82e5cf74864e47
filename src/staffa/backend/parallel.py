"""The only place where ranks reduce, gather, or wait for one another. All of it is collective."""

import pickle
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from time import perf_counter, sleep
from typing import Any

from staffa.backend.stack import MPI

import numpy as np

from staffa.errors import AloneError, StaffaError

# Seconds in which ranks that meet an error together all come to know of it.
TOGETHER = 20.0


def sum_over_ranks[N: (float, np.ndarray)](comm: MPI.Comm, value: N) -> N:
    """Return the sum over all ranks of a number, or of an array of one shape. Collective."""
    total: N = comm.allreduce(value, op=MPI.SUM)
    return total


def max_over_ranks(comm: MPI.Comm, values: np.ndarray | float) -> float:
    """Return the largest entry over all ranks; a rank may hold none; NaN gives NaN. Collective."""
    values = np.atleast_1d(values)
    here = float(values.max()) if values.size else -np.inf
    found_nan = comm.allreduce(bool(np.isnan(here)), op=MPI.LOR)
    return float("nan") if found_nan else float(comm.allreduce(here, op=MPI.MAX))


def any_over_ranks(comm: MPI.Comm, flag: bool) -> bool:
    """Return True on every rank if the argument is true on one. Collective."""
    return bool(comm.allreduce(bool(flag), op=MPI.LOR))


def gather(comm: MPI.Comm, part: np.ndarray) -> list[np.ndarray] | None:
    """Return the ranks' arrays in the order of the ranks, on rank 0; None elsewhere. Collective."""
    found: list[np.ndarray] | None = comm.gather(part, root=0)
    return found


def everywhere(comm: MPI.Comm, part: np.ndarray) -> list[np.ndarray]:
    """Return the ranks' arrays in the order of the ranks, on every rank. Collective."""
    found: list[np.ndarray] = comm.allgather(part)
    return found


def scatter(comm: MPI.Comm, parts: list[np.ndarray] | None) -> np.ndarray:
    """Return each rank's array from the arrays of rank 0, which are in order of the ranks.
    Collective."""
    return np.asarray(comm.scatter(parts, root=0))


def best_candidate[C: tuple[object, ...]](comm: MPI.Comm, candidate: C | None) -> C | None:
    """Return the largest tuple that any rank proposes, the same on all ranks. Collective."""
    found = [c for c in comm.allgather(candidate) if c is not None]
    return max(found) if found else None


def require_together(comm: MPI.Comm, error: StaffaError) -> None:
    """Wait until every other rank has met the error too, but no longer than `TOGETHER`.

    Raises
    ------
    AloneError
        Not all have, or this is known already.
    """
    if isinstance(error, AloneError):
        raise error
    everyone, until = comm.Ibarrier(), perf_counter() + TOGETHER
    while not everyone.Test():
        if perf_counter() > until:
            raise AloneError(f"rank {comm.rank}: {error}", error.exit_code) from error
        sleep(0.01)


def on_root[R](comm: MPI.Comm, action: Callable[[], R]) -> R:
    """Act on rank 0 only; give the result, or raise the error, on every rank. Collective."""
    outcome: tuple[Any, Exception | None] = (None, None)
    if comm.rank == 0:
        try:
            outcome = (action(), None)
        except Exception as error:
            outcome = (None, _portable(error))
    value, failure = comm.bcast(outcome, root=0)
    if failure is not None:
        raise failure
    result: R = value
    return result


@contextmanager
def after_error(comm: MPI.Comm, action: Callable[[], object]) -> Iterator[None]:
    """Act on rank 0 if this context ends with an error that all ranks meet. Collective.

    The others wait as long as it takes, and an error of the action itself is dropped. If one rank
    alone has an error, nobody waits: rank 0 acts if the error is its own.

    Parameters
    ----------
    comm : communicator of all ranks.
    action : what rank 0 does.

    Raises
    ------
    AloneError
        Not all ranks have met an error of staffa's.
    """

    def act() -> None:
        with suppress(Exception):
            action()

    try:
        yield
    except StaffaError as error:
        require_together(comm, error)
        on_root(comm, act)
        raise
    except BaseException:
        if comm.rank == 0:
            act()
        raise


def _portable(error: Exception) -> Exception:
    """Return an error if it can be sent to another rank, else one with the same words."""
    try:
        copy: Exception = pickle.loads(pickle.dumps(error))
        return copy
    except Exception:
        return RuntimeError(f"{type(error).__name__}: {error}")
