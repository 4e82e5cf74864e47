"""Members of an ensemble or a study side by side, each in a separate process."""

import ctypes
import os
import signal
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from tempfile import TemporaryFile
from time import perf_counter, sleep
from typing import IO

from rich.progress import BarColumn, Progress, TaskID, TextColumn

from staffa.backend.child_process import last_words
from staffa.backend.isolation import isolated_python
from staffa.case.check.preview import preview
from staffa.cli.stopping import Stopping
from staffa.cli.terminal import out
from staffa.errors import AuditError, InputError, StaffaError, StoppedError
from staffa.io.run_directory import open_run
from staffa.io.run_progress import run_progress
from staffa.report.growing_page import GrowingPage
from staffa.runs.member_runs import Member

LOOK = 0.1  # s between two looks at the processes
TOLD = 1.0  # s between two readings of their progress
PRCTL = getattr(ctypes.CDLL(None), "prctl", None)  # of Linux; loaded before any fork
DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of prctl
CODE = "from staffa.cli import main; main()"


@dataclass(kw_only=True)
class Job:
    """Process that runs a member.

    Attributes
    ----------
    member : the member.
    process : the process.
    errors : file with its last words.
    task : its line on the terminal.
    """

    member: Member
    process: subprocess.Popen[bytes]
    errors: IO[str]
    task: TaskID

    def reason(self) -> str:
        """Return the sentence with which the process ended."""
        self.errors.seek(0)
        said = last_words(self.errors.read()).removeprefix("staffa: ")
        code = self.process.returncode
        if code < 0:
            return f"its process was ended by {signal.Signals(-code).name}"
        return said or f"its process ended with code {code}"


@dataclass(kw_only=True)
class SideBySide:
    """Processes that run members, at most `jobs` at a time.

    Attributes
    ----------
    members : the members.
    words : arguments of the command, without those of one member.
    jobs : number of processes at a time.
    stopping : requests to stop.
    quiet : True to print errors only.
    page : page that grows when a member is finished; None for none.
    failures : errors of the members that failed.
    refused : number of these that could not be run.
    stopped : reason to start no more; empty without one.
    asked : True once all processes were asked to stop.
    """

    members: Sequence[Member]
    words: Sequence[str]
    jobs: int
    stopping: Stopping
    quiet: bool
    page: GrowingPage | None = None
    failures: dict[Member, str] = field(default_factory=dict)
    refused: int = 0
    stopped: str = ""
    asked: bool = False

    def run(self) -> dict[Member, str]:
        """Run the members, and return the errors of those that failed.

        Raises
        ------
        InputError
            No member can be run; none has been.
        StoppedError
            It was asked to stop; all processes have ended, and the same command goes on.
        """
        self._told = perf_counter()
        waiting, running = list(self.members), list[Job]()
        self.progress = Progress(
            TextColumn("{task.description}", markup=False),
            BarColumn(bar_width=20),
            TextColumn("{task.fields[now]}", markup=False),
            console=out,
            transient=True,
            disable=self.quiet or not out.is_terminal,
        )
        self.whole = self.progress.add_task("all", total=len(self.members), now="")
        with self.progress:
            while waiting or running:
                self._look_for_reasons(running)
                while waiting and len(running) < self.jobs and not self.stopped:
                    self._begin(waiting.pop(0), running)
                if self.stopped:
                    waiting.clear()
                for job in [job for job in running if job.process.poll() is not None]:
                    running.remove(job)
                    self._end(job)
                self._tell(running)
                sleep(LOOK if running else 0.0)
        if self.stopped:
            raise StoppedError(self._how_to_go_on())
        if self.refused == len(self.members):
            raise InputError(next(iter(self.failures.values())))
        return self.failures

    def _look_for_reasons(self, running: Sequence[Job]) -> None:
        """Ask all processes to stop, once, if there is a reason to."""
        reason = None if self.asked else self.stopping.reason()
        if reason:
            self.asked, self.stopped = True, self.stopped or reason
            for job in running:
                job.process.send_signal(signal.SIGTERM)

    def _begin(self, member: Member, running: list[Job]) -> None:
        """Start the process of a member, or count it if it is finished."""
        if member.finished:
            self._say(f"{self._name(member)} is finished already")
            self.progress.advance(self.whole)
            return
        words = [*self.words, "--member", str(member.number), "--quiet"]
        if (left := self.stopping.left()) is not None:
            words += ["--wall-time", f"{max(left, 1.0):.0f} s"]
        errors = TemporaryFile("w+", errors="replace")  # noqa: SIM115 (till the process ends)
        process = subprocess.Popen(
            isolated_python(CODE, *words),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=errors,
            env={"OMP_NUM_THREADS": "1"} | os.environ,  # threads would compete with the others
            start_new_session=True,  # Ctrl-C comes to this process alone, which passes it on
            preexec_fn=PRCTL and partial(_end_with_parent, PRCTL, os.getpid()),
        )
        task = self.progress.add_task(member.label, total=1.0, now="starting")
        running.append(Job(member=member, process=process, errors=errors, task=task))
        begins = "begins" if member.finished is None else "goes on"
        said = f": {member.said}" if member.said else ""
        self._say(f"{self._name(member)} {begins}{said}, in {member.place}")
        for sentence in preview(member.case).warnings if member.warns else ():
            self._say(f"  warning: {sentence}")

    def _end(self, job: Job) -> None:
        """Note how a member ended."""
        code, name = job.process.returncode, self._name(job.member)
        with job.errors:
            said = job.reason()
        self.progress.remove_task(job.task)
        done = run_progress(job.member.place)
        steps = f"{done.steps} of {done.planned} steps" if done and done.planned else "its steps"
        if code in (0, AuditError.exit_code):
            self.progress.advance(self.whole)
            self._say(f"{name} is finished, {steps if done and done.planned else 'all its steps'}")
            if self.page:
                self.page.grow()
        elif code == StoppedError.exit_code:
            self.stopped = self.stopped or said.removeprefix("stopped, since ").split(":")[0]
            self._say(f"{name} stopped after {steps}")
        else:
            self.progress.advance(self.whole)
            self.failures[job.member] = said
            self.refused += code == InputError.exit_code
            self._say(f"{name} failed: {said}")

    def _tell(self, running: Sequence[Job]) -> None:
        """Refresh the lines of the terminal."""
        if perf_counter() - self._told < TOLD or self.progress.disable:
            return
        self._told = perf_counter()
        for job in running:
            if done := run_progress(job.member.place):
                of = f" of {done.planned}" if done.planned else ""
                self.progress.update(
                    job.task, completed=done.part, now=f"step {done.steps}{of}, {job.member.said}"
                )
        count = int(self.progress.tasks[0].completed)
        self.progress.update(self.whole, now=f"{count} of {len(self.members)} members")

    def _name(self, member: Member) -> str:
        return member_name(member, len(self.members))

    def _say(self, line: str) -> None:
        if not self.quiet:
            out.print(line, markup=False, soft_wrap=True)

    def _how_to_go_on(self) -> str:
        ended = [one for one in self.members if one.finished or _is_complete(one)]
        return (
            f"stopped, since {self.stopped}: {len(ended)} of {len(self.members)} members are "
            f"finished; the same command goes on"
        )


def member_name(member: Member, count: int) -> str:
    """Return the name of a member among all of a command: "seed 3 (member 1 of 4)"."""
    return f"{member.label} (member {member.number} of {count})"


def _is_complete(member: Member) -> bool:
    try:
        return open_run(member.place).finished
    except StaffaError:
        return False  # it has not started, or it cannot be read


def _end_with_parent(prctl: Callable[[int, int], int], parent: int) -> None:
    """Let the kernel ask this process to stop and save when its parent ends, however it does.

    It is called between fork and exec, where another thread may have held a lock: it loads nothing.

    Parameters
    ----------
    prctl : function of libc.
    parent : number of the process that started this one.
    """
    prctl(DEATH_SIGNAL, signal.SIGTERM)
    if os.getppid() != parent:  # it ended before the kernel knew
        os._exit(128 + signal.SIGTERM)
