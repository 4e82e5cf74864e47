"""Run of an ensemble with its progress: its members one after another, then means and errors."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from staffa.backend.stack import MPI

from staffa.backend.parallel import on_root
from staffa.case.check.preview import preview
from staffa.case.schema.case import Case
from staffa.cli.live import Follower, ending_all_ranks
from staffa.cli.results import print_ensemble, print_ensemble_pictures, require_clean_audit
from staffa.cli.stopping import Stopping
from staffa.cli.terminal import out
from staffa.errors import SolveError
from staffa.io.ensemble_directory import is_ensemble, member_path, read_ensemble
from staffa.report.growing_page import growing_ensemble, stopped_with
from staffa.results.csv_files import write_pooled
from staffa.results.ensemble_means import write_results
from staffa.runs.ensemble import run_ensemble, seeds_from
from staffa.runs.run import Watcher


def run_members_and_follow(
    read: Callable[[], Case],
    directory: Path,
    *,
    count: int,
    first: int | None,
    quiet: bool,
    wall_time: float | None = None,
) -> None:
    """Read the case on rank 0, run each member on all ranks, and print on rank 0. Collective.

    Parameters
    ----------
    read : returns the case.
    directory : directory of the ensemble.
    count : number of members.
    first : first seed; None for the case's own.
    quiet : True to print errors only.
    wall_time : longest time of all (s); None for any.

    Raises
    ------
    SolveError
        Members failed; the others are finished, and the results are written.
    AuditError
        All are finished, but the audit of one is violated.
    """
    comm = MPI.COMM_WORLD
    stopping = Stopping(wall_time)
    with ending_all_ranks(comm, directory), stopping.heeded(comm.size):
        case = on_root(comm, read)
        seeds = on_root(comm, lambda: seeds_from(case, count=count, first=first))
        warnings = on_root(comm, lambda: preview(case).warnings)
        shown = comm.rank == 0 and not quiet
        page = growing_ensemble(directory, out.print) if shown else None

        def name(seed: int) -> str:
            return f"seed {seed} (member {seeds.index(seed) + 1} of {count})"

        @contextmanager
        def follow(seed: int) -> Iterator[Watcher]:
            follower = Follower(
                directory=member_path(directory, seed),
                speaks=comm.rank == 0,
                quiet=quiet,
                name=name(seed),
                warnings=warnings if seed == seeds[0] else (),
            )
            with follower.progress:
                yield follower.watcher(stopping.reason)
            if page:
                page.grow()

        def taken(seed: int) -> None:
            if comm.rank == 0 and not quiet:
                out.print(f"{name(seed)} is finished already", markup=False, soft_wrap=True)

        with stopped_with(page):
            failures = run_ensemble(case, seeds, directory, comm=comm, follow=follow, taken=taken)
        on_root(comm, lambda: _leave_results(directory, quiet=quiet))
        if failures:
            raise SolveError(_told(failures, count))
        on_root(comm, lambda: require_clean_audit(list(read_ensemble(directory).finished.values())))


def _leave_results(directory: Path, *, quiet: bool) -> None:
    if not is_ensemble(directory):
        return  # every member failed before it began
    ensemble = read_ensemble(directory)
    write_results(ensemble)
    write_pooled(ensemble)
    if not quiet:
        print_ensemble(ensemble)
        print_ensemble_pictures(ensemble)


def _told(failures: dict[int, str], count: int) -> str:
    seeds = ", ".join(str(seed) for seed in failures)
    first, error = next(iter(failures.items()))
    which = "" if len(failures) == 1 else f", seed {first} because"
    return f"{len(failures)} of {count} members failed (seed {seeds}){which}: {error}"
