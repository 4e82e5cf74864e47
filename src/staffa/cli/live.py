"""Run of a case from the command line: its progress, its results, and its end."""

import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path
from time import sleep

from staffa.backend.stack import MPI

from staffa.backend.parallel import after_error, on_root, require_together
from staffa.case.check.preview import preview
from staffa.case.schema.case import Case
from staffa.cli.results import (
    leave_tables,
    print_pictures,
    require_clean_audit,
)
from staffa.cli.stopping import Stopping
from staffa.cli.terminal import out
from staffa.errors import AloneError, StaffaError, printable
from staffa.io.research_object import describe_stopped
from staffa.io.run_directory import Run, open_run
from staffa.report.growing_page import GrowingPage, growing_run
from staffa.runs.follower import Follower
from staffa.runs.resume import resume
from staffa.runs.run import Watcher, run
from staffa.runs.screens import NoScreen, Screen, TerminalScreen


def run_and_follow(
    read: Callable[[], Case], directory: Path, *, quiet: bool, wall_time: float | None = None
) -> None:
    """Read the case on rank 0, run it on all ranks, and print on rank 0. Collective.

    Parameters
    ----------
    read : returns the case.
    directory : the run directory.
    quiet : True to print errors only.
    wall_time : longest time of the run (s); None for any.
    """
    comm = MPI.COMM_WORLD
    with ending_all_ranks(comm, directory):
        case = on_root(comm, read)
        warnings = on_root(comm, lambda: preview(case).warnings)
        with following(
            comm, directory, quiet=quiet, wall_time=wall_time, warnings=warnings
        ) as watcher:
            run(case, directory, comm=comm, watcher=watcher)


def resume_and_follow(
    directory: Path, *, settings: Sequence[str], quiet: bool, wall_time: float | None = None
) -> None:
    """Resume a run on all ranks, and print on rank 0. Collective.

    Parameters
    ----------
    directory : the run directory.
    settings : changes of the case, see `resume`.
    quiet : True to print errors only.
    wall_time : longest time of the run (s); None for any.
    """
    comm = MPI.COMM_WORLD
    with (
        ending_all_ranks(comm, directory),
        following(comm, directory, quiet=quiet, wall_time=wall_time) as watcher,
    ):
        resume(directory, settings=settings, comm=comm, watcher=watcher)


@contextmanager
def following(
    comm: MPI.Comm,
    directory: Path,
    *,
    quiet: bool,
    wall_time: float | None,
    warnings: Sequence[str] = (),
) -> Iterator[Watcher]:
    """Yield a watcher that prints and logs a run, and write the results after it. Collective.

    Parameters
    ----------
    comm : communicator of all ranks.
    directory : the run directory.
    quiet : True to print errors only.
    wall_time : longest time of the run (s); None for any.
    warnings : messages of `staffa check`, shown before the first step.
    """
    stopping = Stopping(wall_time)
    speaks = comm.rank == 0
    follower = Follower(
        directory=directory,
        speaks=speaks,
        quiet=quiet,
        screen=terminal_screen(shown=speaks and not quiet),
        warnings=tuple(warnings),
    )
    page = growing_run(directory, follower.said) if speaks and not quiet else None
    if page:
        follower.grown = page.grow
    with stopping.heeded(comm.size), follower.screen, stopped_with(comm, page):
        yield follower.watcher(stopping.reason)
    on_root(comm, lambda: _leave_results(open_run(directory), quiet=quiet))
    on_root(comm, lambda: require_clean_audit([open_run(directory)]))


def stopped_with(comm: MPI.Comm, page: GrowingPage | None) -> AbstractContextManager[None]:
    """Return what stops a page if what it shows ends with an error. Collective.

    The description of the files comes after the page, which is one of them. If all goes well, the
    last page is drawn over this one.

    Parameters
    ----------
    comm : communicator of all ranks.
    page : the page; None for none, and on other ranks than 0.
    """

    def stop() -> None:
        if page and page.written:
            page.stop()
            describe_stopped(page.folder)

    return after_error(comm, stop)


def terminal_screen(*, shown: bool) -> Screen:
    """Return the screen of the command line: a line a step, and on a terminal a live one."""
    return TerminalScreen(out, each_step=True) if shown else NoScreen()


def _leave_results(run: Run, *, quiet: bool) -> None:
    """Write tables and networks, and unless it is quiet also print and draw the results."""
    if quiet:
        leave_tables(run)
    else:
        print_pictures(run, summed_up=True)


# Seconds that mpiexec is left to pass on a traceback: an abort at once can lose it.
FORWARDED = 0.5


@contextmanager
def ending_all_ranks(comm: MPI.Comm, directory: Path) -> Iterator[None]:
    """End all ranks if only one has an error, after its message.

    For an error that is not staffa's the message is its traceback.
    """
    try:
        yield
    except StaffaError as error:
        try:
            require_together(comm, error)
        except AloneError as alone:
            print(f"staffa: {alone}", file=sys.__stderr__, flush=True)
            sleep(FORWARDED)
            comm.Abort(alone.exit_code)
        raise
    except (Exception, KeyboardInterrupt) as error:
        if _was_interrupted(error):
            raise SystemExit(_interrupted(directory, speaks=comm.rank == 0)) from None
        traceback.print_exc(file=sys.__stderr__)
        if comm.size > 1:
            sleep(FORWARDED)
            comm.Abort(1)
        raise SystemExit(1) from None


def _was_interrupted(error: BaseException | None) -> bool:
    """Return True for Ctrl-C, also if PETSc turned it into another error."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return True
        error = error.__cause__ or error.__context__
    return False


def _interrupted(directory: Path, *, speaks: bool) -> int:
    if speaks:
        print(
            printable(f"staffa: interrupted; the finished steps are in {directory}"),
            file=sys.stderr,
        )
    return 130
