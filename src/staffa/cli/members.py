"""Runs of an ensemble or a study with their progress, then means and errors."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from staffa.backend.stack import MPI

from staffa.backend.parallel import on_root
from staffa.case.check.preview import preview
from staffa.case.schema.case import Case
from staffa.cli.jobs import SideBySide, member_name
from staffa.cli.live import ending_all_ranks, stopped_with, terminal_screen
from staffa.cli.results import (
    describe_results,
    leave_missing_tables,
    leave_tables,
    print_ensemble,
    print_ensemble_pictures,
    print_study,
    print_study_pictures,
    require_clean_audit,
)
from staffa.cli.slurm_script import write_slurm_script
from staffa.cli.stopping import Stopping
from staffa.cli.terminal import out
from staffa.errors import SolveError
from staffa.io.ensemble_directory import is_ensemble, read_ensemble
from staffa.io.run_directory import MANIFEST, Run, open_run
from staffa.io.study_directory import Parameter, Point, has_started, read_study, write_plan
from staffa.report.growing_page import (
    GrowingPage,
    growing_ensemble,
    growing_study,
)
from staffa.results.csv_files import write_ensemble, write_study
from staffa.results.member_numbers import bounded
from staffa.runs.ensemble import ensemble_members, seeds_from
from staffa.runs.follower import Follower
from staffa.runs.member_runs import Member, run_member, run_members
from staffa.runs.run import Watcher
from staffa.runs.study import planned_study

Follow = Callable[[Member], AbstractContextManager[Watcher]]
Taken = Callable[[Member], None]


@dataclass(frozen=True, kw_only=True)
class Way:
    """Choice of how the members of a command run.

    Attributes
    ----------
    quiet : True to print errors only.
    wall_time : longest time of all (s); None for any.
    jobs : number of processes side by side; 1 for this process and its ranks.
    member : number of the one member that runs; None for all.
    words : arguments of the command, without those of one member, for other processes.
    script : where a script for Slurm is written, in place of any run; None to run.
    """

    quiet: bool = False
    wall_time: float | None = None
    jobs: int = 1
    member: int | None = None
    words: Sequence[str] = ()
    script: Path | None = None


def run_members_and_follow(
    read: Callable[[], Case], directory: Path, *, count: int, first: int | None, way: Way
) -> None:
    """Read the case on rank 0, run each member on all ranks, and print on rank 0. Collective.

    Parameters
    ----------
    read : returns the case.
    directory : directory of the ensemble.
    count : number of members.
    first : first seed; None for the case's own.
    way : choice of how they run.

    Raises
    ------
    SolveError
        Members failed; the others are finished, and the results are written.
    AuditError
        All are finished, but the audit of one is violated.
    """

    def planned() -> tuple[Member, ...]:
        case = read()
        seeds = seeds_from(case, count=count, first=first)
        members = ensemble_members(case, seeds, directory, only=way.member)
        if way.script is not None:
            _write_script(way, members, directory)
        return members

    def leave() -> None:
        if not is_ensemble(directory):
            return  # every member failed before it began
        found = read_ensemble(directory)
        said = leave_missing_tables(found.runs.values())
        if way.quiet:
            write_ensemble(found)
            describe_results(directory)
        else:
            print_ensemble(found)
            print_ensemble_pictures(found)
            _tell_of_members(directory, said)

    def finished() -> list[Run]:
        return [*read_ensemble(directory).finished.values()]

    _run(planned, leave, finished, growing_ensemble, directory, way)


def run_study_and_follow(
    read: Callable[[Sequence[str]], Case],
    directory: Path,
    *,
    over: Callable[[], tuple[tuple[Parameter, ...], tuple[Point, ...]]],
    count: int,
    first: int | None,
    way: Way,
) -> None:
    """Read the cases on rank 0, run each member of a study, and print on rank 0. Collective.

    Parameters
    ----------
    read : function of settings that returns the case with them.
    directory : directory of the study.
    over : returns the parameters and the points.
    count : number of seeds of each point.
    first : first seed; None for that of the case.
    way : choice of how the members run.

    Raises
    ------
    SolveError, AuditError
        See `run_members_and_follow`.
    """

    def planned() -> tuple[Member, ...]:
        parameters, points = over()
        plan, members = planned_study(
            read, parameters, points, directory, count=count, first=first, only=way.member
        )
        if way.script is not None:
            _write_script(way, members, directory)
        said = write_plan(directory, plan)
        if said and not way.quiet:
            out.print(said, markup=False, soft_wrap=True)
        return members

    def leave() -> None:
        if not has_started(directory):
            return
        found = read_study(directory)
        said = leave_missing_tables(found.runs.values())
        if way.quiet:
            write_study(found)
        else:
            print_study(found)
            print_study_pictures(found)
            _tell_of_members(directory, said)

    _run(planned, leave, lambda: read_study(directory).finished, growing_study, directory, way)


def _run(
    planned: Callable[[], tuple[Member, ...]],
    leave: Callable[[], None],
    finished: Callable[[], list[Run]],
    growing: Callable[[Path, Callable[[str], None]], GrowingPage],
    directory: Path,
    way: Way,
) -> None:
    """Run the members, leave the results, and tell of those that failed. Collective.

    Parameters
    ----------
    planned : returns the members, and writes the script for them; called on rank 0.
    leave : writes and prints the results; called on rank 0.
    finished : returns the finished runs; called on rank 0.
    growing : returns the page of those that are computed; called on rank 0.
    directory : directory of all of them.
    way : choice of how they run.
    """
    comm = MPI.COMM_WORLD
    stopping = Stopping(way.wall_time)
    with ending_all_ranks(comm, directory), stopping.heeded(comm.size):
        members = on_root(comm, planned)
        if way.script is not None:
            return
        shown = comm.rank == 0 and not way.quiet and way.member is None
        page = growing(directory, partial(out.print, markup=False)) if shown else None
        follow = partial(_followed, comm, members, way.quiet, stopping, page)
        taken = partial(_say_taken, comm, members, way.quiet)
        if way.member is not None:
            _run_alone(comm, members[way.member - 1], follow, taken)
            return
        with stopped_with(comm, page):
            if way.jobs > 1:
                failures = SideBySide(
                    members=members,
                    words=way.words,
                    jobs=way.jobs,
                    stopping=stopping,
                    quiet=way.quiet,
                    page=page,
                ).run()
            else:
                failures = run_members(members, comm=comm, follow=follow, taken=taken)
        on_root(comm, leave)
        if failures:
            raise SolveError(_told(failures, len(members)))
        on_root(comm, lambda: require_clean_audit(finished()))


def _write_script(way: Way, members: Sequence[Member], directory: Path) -> None:
    assert way.script is not None
    write_slurm_script(way.script, way.words, len(members), directory, way.wall_time)
    if not way.quiet:
        out.print(
            f"{way.script} is an array of {len(members)} jobs: sbatch {way.script}; once they are "
            f"over, staffa report {directory}",
            markup=False,
            soft_wrap=True,
        )


def _run_alone(comm: MPI.Comm, member: Member, follow: Follow, taken: Taken) -> None:
    """Run one member, with the exit code of its run. Collective."""
    if member.finished:
        taken(member)
        on_root(comm, lambda: leave_missing_tables([open_run(member.place)]))
    else:
        with follow(member) as watcher:
            run_member(member, comm=comm, watcher=watcher)
    on_root(comm, lambda: require_clean_audit([open_run(member.place)]))


@contextmanager
def _followed(
    comm: MPI.Comm,
    members: Sequence[Member],
    quiet: bool,
    stopping: Stopping,
    page: GrowingPage | None,
    member: Member,
) -> Iterator[Watcher]:
    """Yield a watcher that prints and logs the run of a member. Collective."""
    warnings = on_root(comm, lambda: preview(member.case).warnings) if member.warns else ()
    follower = Follower(
        directory=member.place,
        speaks=comm.rank == 0,
        quiet=quiet,
        screen=terminal_screen(shown=comm.rank == 0 and not quiet),
        name=", ".join(filter(None, (member_name(member, len(members)), member.said))),
        warnings=warnings,
    )
    try:
        with follower.screen:
            yield follower.watcher(stopping.reason)
    except SolveError:
        on_root(comm, lambda: _leave_reached(member.place))
        raise
    on_root(comm, lambda: leave_tables(open_run(member.place)))
    if page:
        page.grow()


def _leave_reached(place: Path) -> None:
    """Write the tables of a member that failed, if it reached a step."""
    if (place / MANIFEST).is_file():
        leave_missing_tables([open_run(place)])


def _tell_of_members(directory: Path, said: str) -> None:
    out.print(
        f"{said}; `staffa report {directory} --members` also draws the pictures and the page of "
        f"each",
        markup=False,
        soft_wrap=True,
    )


def _say_taken(comm: MPI.Comm, members: Sequence[Member], quiet: bool, member: Member) -> None:
    if comm.rank == 0 and not quiet:
        name = member_name(member, len(members))
        out.print(f"{name} is finished already", markup=False, soft_wrap=True)


def _told(failures: dict[Member, str], count: int) -> str:
    """Return the message on the members that failed."""
    labels = [member.label for member in failures]
    seeds = all(label.startswith("seed ") for label in labels)
    names = labels[:1] + [label.removeprefix("seed ") if seeds else label for label in labels[1:]]
    told = bounded(names, ", " if seeds else "; ")
    first, error = next(iter(failures.items()))
    which = "" if len(failures) == 1 else f", {first.label} because"
    return f"{len(failures)} of {count} members failed ({told}){which}: {error}"
