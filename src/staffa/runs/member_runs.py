"""Runs of the members of an ensemble or a study, one after another, each on all ranks."""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path

from staffa.backend.stack import MPI

from staffa.case.schema.case import Case
from staffa.errors import InputError, SolveError
from staffa.runs.resume import resume
from staffa.runs.run import Watcher, run


@dataclass(frozen=True, kw_only=True, eq=False)
class Member:
    """One run of several.

    Attributes
    ----------
    number : its number among those of the command, from 1.
    label : its name: "seed 3".
    case : its case.
    place : its run directory.
    finished : True if it is finished, False if it has started, None if it has not.
    warns : True if the messages of `staffa check` on its case are shown.
    said : its parameters in words; empty without any.
    """

    number: int
    label: str
    case: Case
    place: Path
    finished: bool | None
    warns: bool
    said: str = ""


def require_number(number: int | None, count: int) -> None:
    """Refuse the number of a member that a command does not have.

    Parameters
    ----------
    number : the number, from 1; None for all members.
    count : number of members.

    Raises
    ------
    InputError
        There is no such member.
    """
    if number is not None and not 1 <= number <= count:
        raise InputError(
            f"--member {number}: this command has {count} members; give a number from 1 to {count}"
        )


def run_members(
    members: Sequence[Member],
    *,
    comm: MPI.Comm,
    follow: Callable[[Member], AbstractContextManager[Watcher]] = lambda one: nullcontext(
        Watcher()
    ),
    taken: Callable[[Member], None] = lambda one: None,
) -> dict[Member, str]:
    """Run each member, and return the errors of those that failed. Collective.

    A member that fails does not stop the others. One that is finished is left unchanged; one that
    has started is resumed.

    Parameters
    ----------
    members : the members.
    comm : communicator of all ranks.
    follow : function of a member that returns a context with its watcher; called on every rank.
    taken : called with a member that is finished already; on every rank.

    Raises
    ------
    InputError
        No member can be run; none has been.
    StoppedError
        A watcher asked to stop; finished members stay so, and others are resumed next time.
    """
    failures: dict[Member, str] = {}  # not the errors: they hold on to meshes
    refused: list[InputError] = []
    for member in members:
        if member.finished:
            taken(member)
            continue
        try:
            with follow(member) as watcher:
                run_member(member, comm=comm, watcher=watcher)
        except (SolveError, InputError) as error:
            failures[member] = str(error)
            if isinstance(error, InputError):  # a seed whose rock cannot be
                refused.append(error.with_traceback(None))
    if len(refused) == len(members):
        raise refused[0]
    return failures


def run_member(member: Member, *, comm: MPI.Comm, watcher: Watcher) -> None:
    """Run a member, or resume it where it has started. Collective.

    Parameters
    ----------
    member : the member.
    comm : communicator of all ranks.
    watcher : follows the run.

    Raises
    ------
    InputError, SolveError, StoppedError
        See `run`.
    """
    if member.finished is None:
        run(member.case, member.place, comm=comm, watcher=watcher)
    else:
        resume(member.place, comm=comm, watcher=watcher)
