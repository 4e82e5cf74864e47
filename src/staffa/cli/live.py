"""Run of a case with its progress: a live line on a terminal, else one plain line a step."""

import sys
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter, sleep

from staffa.backend.stack import MPI

from rich.progress import BarColumn, Progress, TextColumn

from staffa.backend.parallel import on_root, require_together
from staffa.case.check.preview import preview
from staffa.case.schema.case import Case
from staffa.cli.results import print_pictures, print_summary, require_clean_audit
from staffa.cli.stopping import Stopping
from staffa.cli.terminal import out
from staffa.display_units import Shown
from staffa.errors import AloneError, StaffaError, printable
from staffa.io.run_directory import Run, append_log, open_run
from staffa.minimize.alternate import Sweep
from staffa.records.manifest import Manifest
from staffa.records.status import Status
from staffa.records.step import Moment, Step
from staffa.report.growing_page import GrowingPage, growing_run, stopped_with
from staffa.results.crack_network import networks
from staffa.results.csv_files import write_tables
from staffa.results.mesh_changes import cells_told
from staffa.results.radial import radial
from staffa.runs.resume import resume
from staffa.runs.run import Watcher, run


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
    follower = Follower(
        directory=directory, speaks=comm.rank == 0, quiet=quiet, warnings=tuple(warnings)
    )
    if follower.speaks and not quiet:
        follower.page = growing_run(directory, follower.said)
    with stopping.heeded(comm.size), follower.progress, stopped_with(follower.page):
        yield follower.watcher(stopping.reason)
    on_root(comm, lambda: _leave_results(open_run(directory), quiet=quiet))
    on_root(comm, lambda: require_clean_audit([open_run(directory)]))


def _leave_results(run: Run, *, quiet: bool) -> None:
    """Write tables and networks, and unless it is quiet also print and draw the results."""
    if quiet:
        write_tables(run, networks(run)[0])
    else:
        print_summary(run)
        print_pictures(run)


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


@dataclass(kw_only=True)
class Follower:
    """Printer and log of a run in progress.

    Attributes
    ----------
    directory : the run directory.
    speaks : True on rank 0, which alone prints.
    quiet : True to print errors only.
    name : name of this run among several; empty for one.
    warnings : warnings of `staffa check` on its case.
    manifest : description of the run; None before it starts.
    latest : cracks of the last step and the time left, as text.
    cells : number of cells that was told last.
    page : page that grows with the run; None for none.
    before : part of the run that was done when it was resumed.
    began : time (s) at which this process began it.
    """

    directory: Path
    speaks: bool
    quiet: bool
    name: str = ""
    warnings: tuple[str, ...] = ()
    manifest: Manifest | None = None
    latest: str = ""
    cells: int = 0
    page: GrowingPage | None = None
    before: float = 0.0
    began: float = field(default_factory=perf_counter)

    def __post_init__(self) -> None:
        shown = self.speaks and not self.quiet and out.is_terminal
        self.progress = Progress(
            TextColumn("{task.description}"),
            BarColumn(bar_width=10),
            TextColumn("{task.fields[now]}"),
            console=out,
            transient=True,
            disable=not shown,
        )
        self.task = self.progress.add_task("starting", total=None, now="")

    def watcher(self, stop: Callable[[], str | None]) -> Watcher:
        """Return the watcher that `run` calls; `stop` returns a reason to stop, or None."""
        return Watcher(
            started=self.started,
            said=self.said,
            resumed=self.resumed,
            swept=self.swept,
            stepped=self.stepped,
            stop=stop,
        )

    def started(self, manifest: Manifest) -> None:
        """Print the start of a run."""
        self.manifest = manifest
        self.progress.update(self.task, total=1.0)
        steps = "adaptive" if manifest.adaptive else f"{len(manifest.times)}"
        self._say(
            f"{self._named()}{manifest.title or 'run'}: {manifest.unknowns:,} unknowns"
            f"{' at the start' if manifest.refined else ''}, {steps} steps, {manifest.law}, "
            f"{manifest.ranks} rank(s), effective Gc {manifest.toughness_factor:.4f} Gc, "
            f"in {self.directory}{', where report.html grows' if self.page else ''}"
        )
        for sentence in self.warnings:
            self._say(f"  warning: {sentence}")
        if self.page:
            self.page.grow()

    def said(self, sentence: str) -> None:
        """Print a message."""
        self._say(f"  {sentence}")

    def resumed(self, steps: tuple[Step, ...]) -> None:
        """Print the step after which a run continues."""
        self.before = self._done(steps[-1]) if steps else 0.0
        self.cells = steps[-1].mesh.cells if steps and steps[-1].mesh else 0
        last = f"after step {steps[-1].index}, {self._clock(steps[-1])}" if steps else ""
        self._say(f"  goes on {last or 'from its start'}")

    def swept(self, moment: Moment, sweep: Sweep) -> None:
        """Refresh the live line."""
        self.progress.update(
            self.task,
            description=f"{self._named()}step {moment.index}, {self._clock(moment)}",
            now=f"sweep {sweep.number}, energy {self._energy(sweep.energies.total)}{self.latest}",
        )

    def stepped(self, step: Step) -> None:
        """Log and print one line a step, with violations of its audit."""
        if step.status == Status.REJECTED:
            self._say(f"  step {step.index} to {self._clock(step)} rejected: {step.reason}")
            return
        self.latest = "".join(f", {part}" for part in (*self._cracks(step), self._left(step)[1]))
        self.progress.update(self.task, completed=self._done(step))
        if step.returned:
            back = step.returned
            self._say(
                f"  went back from step {back.index} to step {step.index}: its damage lowers the "
                f"energy there from {self._energy(back.before, 6)} to {self._energy(back.found, 6)}"
            )
        self._say(self._line(step))
        for sentence in step.audit.violations if step.audit else (step.reason,):
            self._say(f"  {'audit: ' if step.audit else ''}{sentence}")
        notes = step.audit.notes if step.audit else ()
        for sentence in (*notes, *radial(step)):
            self._say(f"  note: {sentence}")
        if self.page:
            self.page.grow()
        if self.speaks and self.quiet and step.audit and step.status == Status.CONVERGED:
            for sentence in step.audit.violations:
                print(f"staffa: step {step.index}, audit: {printable(sentence)}", file=sys.stderr)

    def _named(self) -> str:
        return f"{self.name}, " if self.name else ""

    def _line(self, step: Step) -> str:
        energies, parts = step.energies, [f"step {step.index:3d}", self._clock(step)]
        unit = self._shown.energy
        rest = " since rest" if energies.at_rest else ""
        parts += [
            f"elastic {unit.of(energies.elastic):.6g}{rest}",
            f"surface {unit.of(energies.surface):.6g}",
            f"total {unit.text(energies.total, 6)}",
            f"{step.sweeps:3d} sweeps",
        ]
        if cells := cells_told(step, self.cells):
            self.cells = step.mesh.cells if step.mesh else 0
            parts.append(cells)
        return ", ".join([*parts, *self._cracks(step), *self._left(step)])

    def _cracks(self, step: Step) -> list[str]:
        if not step.measures or not step.measures.tips:
            return []
        assert self.manifest is not None
        count, front = len(step.measures.tips), self.manifest.deepest(step.measures)
        return [f"{count} crack{'s' * (count > 1)} to {self._shown.length.text(front, 3)}"]

    def _done(self, step: Step) -> float:
        """Return the finished part of the run: of its steps, or if not known, of its time."""
        assert self.manifest is not None
        if not self.manifest.adaptive:
            return (step.index + 1) / len(self.manifest.times)
        tau, last = step.tau, self.manifest.taus[-1]
        return step.time / self.manifest.times[-1] if not tau or not last else tau / last

    def _left(self, step: Step) -> tuple[str, str]:
        spent, done = perf_counter() - self.began, self._done(step)
        here = done - self.before
        left = f"{_clock(spent * (1 - done) / here)} left" if here > 0 else "just started"
        return f"{_clock(spent)} gone", left

    def _clock(self, moment: Moment | Step) -> str:
        assert self.manifest is not None
        time = f"t {self._shown.time.text(moment.time)}"
        if moment.tau is None:
            return time
        tau = f"tau {moment.tau:.4f}"
        return f"{tau} ({time})" if self.manifest.scaled else f"{time} ({tau})"

    @property
    def _shown(self) -> Shown:
        assert self.manifest is not None
        return self.manifest.shown

    def _energy(self, value: float, digits: int = 4) -> str:
        return self._shown.energy.text(value, digits)

    def _say(self, line: str) -> None:
        if not self.speaks:
            return
        with suppress(OSError):  # a disk that is full is told of by what matters more
            append_log(self.directory, line)
        if not self.quiet:
            out.print(line, markup=False, soft_wrap=True)


def _clock(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d}"
