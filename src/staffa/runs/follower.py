"""Follower of a run: its log, its messages, and a live line of its progress."""

import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter

from staffa.backend.stack import MPI

from staffa.arguments import require
from staffa.backend.parallel import on_root
from staffa.display_units import Shown
from staffa.errors import printable
from staffa.io.run_directory import append_log
from staffa.measure.radial import radial
from staffa.minimize.alternate import Sweep
from staffa.records.manifest import Manifest
from staffa.records.status import Status
from staffa.records.step import Moment, Step
from staffa.runs.run_observers import Watcher
from staffa.runs.screens import NoScreen, Screen, screen_of_python


@dataclass(kw_only=True)
class Follower:
    """Printer and log of a run in progress.

    Attributes
    ----------
    directory : the run directory.
    speaks : True on rank 0, which alone writes and shows.
    quiet : True to print violations of the audit alone.
    screen : where progress is shown.
    name : name of this run among several; empty for one.
    warnings : warnings of `staffa check` on its case.
    grown : called after the start of the run and after each step, to draw what grows with it.
    manifest : description of the run; None before it starts.
    latest : cracks of the last step and the time left, as text.
    cells : number of cells that was told last.
    before : part of the run that was done when it was resumed.
    done : finished part of the run, from 0 to 1.
    began : time (s) at which this process began it.
    """

    directory: Path
    speaks: bool
    quiet: bool = False
    screen: Screen = field(default_factory=NoScreen)
    name: str = ""
    warnings: Sequence[str] = ()
    grown: Callable[[], None] = lambda: None
    manifest: Manifest | None = None
    latest: str = ""
    cells: int = 0
    before: float = 0.0
    done: float = 0.0
    began: float = field(default_factory=perf_counter)

    def watcher(self, stop: Callable[[], str | None] = lambda: None) -> Watcher:
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
        """Tell of the start of a run."""
        self.manifest = manifest
        steps = "adaptive" if manifest.adaptive else f"{len(manifest.times)}"
        self._say(
            f"{self._named()}{manifest.title or 'run'}: {manifest.unknowns:,} unknowns"
            f"{' at the start' if manifest.refined else ''}, {steps} steps, {manifest.law}, "
            f"{manifest.ranks} rank(s), effective Gc {manifest.toughness_factor:.4f} Gc, "
            f"in {self.directory}"
        )
        for sentence in self.warnings:
            self._say(f"  warning: {sentence}")
        self.grown()

    def said(self, sentence: str) -> None:
        """Show a message."""
        self._say(f"  {sentence}")

    def resumed(self, steps: tuple[Step, ...]) -> None:
        """Tell of the step after which a run continues."""
        self.before = self.done = self._part(steps[-1]) if steps else 0.0
        self.cells = steps[-1].mesh.cells if steps and steps[-1].mesh else 0
        last = f"after step {steps[-1].index}, {self._clock(steps[-1])}" if steps else ""
        self._say(f"  goes on {last or 'from its start'}")

    def swept(self, moment: Moment, sweep: Sweep) -> None:
        """Refresh the live line."""
        self.screen.show(
            self.done,
            f"{self._named()}step {moment.index}, {self._clock(moment)}, sweep {sweep.number}, "
            f"energy {self._energy(sweep.energies.total)}{self.latest}",
        )

    def stepped(self, step: Step) -> None:
        """Log and show one line a step, with violations of its audit."""
        if step.status == Status.REJECTED:
            self._tell(f"  step {step.index} to {self._clock(step)} rejected: {step.reason}")
            return
        if not step.reached:
            self._say(f"  step {step.index} to {self._clock(step)} not reached: {step.reason}")
            self._say_violations(step)
            self.grown()
            return
        self.latest = "".join(f", {part}" for part in (*self._cracks(step), self._left(step)[1]))
        self.done = self._part(step)
        if step.returned:
            back = step.returned
            self._tell(
                f"  went back from step {back.index} to step {step.index}: its damage lowers the "
                f"energy there from {self._energy(back.before, 6)} to {self._energy(back.found, 6)}"
            )
        self._tell(self._line(step))
        self._say_violations(step)
        notes = step.audit.notes if step.audit else ()
        for sentence in (*notes, *radial(step)):
            self._say(f"  note: {sentence}")
        self.grown()
        if self.speaks and self.quiet and step.audit:
            for sentence in step.audit.violations:
                print(f"staffa: step {step.index}, audit: {printable(sentence)}", file=sys.stderr)
        if self.done == 1.0:
            self.screen.show(1.0, self._summary(step))

    def _say_violations(self, step: Step) -> None:
        for sentence in step.audit.violations if step.audit else ():
            self._say(f"  audit: {sentence}")

    def _summary(self, step: Step) -> str:
        """Return the line that stays in a notebook."""
        parts = [f"{step.index + 1} steps", self._left(step)[0], *self._cracks(step)]
        return f"{self._named()}finished: {', '.join(parts)}"

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
        if step.mesh and step.mesh.cells != self.cells:
            self.cells = step.mesh.cells
            parts.append(f"{self.cells:,} cells")
        return ", ".join([*parts, *self._cracks(step), *self._left(step)])

    def _cracks(self, step: Step) -> list[str]:
        if not step.tips:
            return []
        assert self.manifest is not None and step.measures is not None
        count, front = len(step.tips), self.manifest.deepest(step.measures)
        return [f"{count} crack{'s' * (count > 1)} to {self._shown.length.text(front, 3)}"]

    def _part(self, step: Step) -> float:
        """Return the finished part of the run: of its steps, or if not known, of its time."""
        assert self.manifest is not None
        if not self.manifest.adaptive:
            return (step.index + 1) / len(self.manifest.times)
        tau, last = step.tau, self.manifest.taus[-1]
        return step.time / self.manifest.times[-1] if not tau or not last else tau / last

    def _left(self, step: Step) -> tuple[str, str]:
        spent, done = perf_counter() - self.began, self._part(step)
        here = done - self.before
        left = f"{_minutes(spent * (1 - done) / here)} left" if here > 0 else "just started"
        return f"{_minutes(spent)} gone", left

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
        """Log a line and show it."""
        self._log(line)
        if self.speaks and not self.quiet:
            self.screen.say(printable(line))

    def _tell(self, line: str) -> None:
        """Log a line of a step, and show it where each step has one."""
        self._log(line)
        if self.speaks and not self.quiet and self.screen.each_step:
            self.screen.say(printable(line))

    def _log(self, line: str) -> None:
        if self.speaks:
            with suppress(OSError):  # a disk that is full is told of by what matters more
                append_log(self.directory, line)


def _minutes(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes}:{rest:02d}"


@contextmanager
def followed(
    watcher: Watcher | None,
    comm: MPI.Comm,
    directory: Path,
    warnings: Callable[[], Sequence[str]] = tuple,
) -> Iterator[Watcher]:
    """Yield the watcher of a script, or one that logs a run and shows its progress. Collective.

    Parameters
    ----------
    watcher : watcher of the script; None if it gives none.
    comm : communicator of all ranks.
    directory : the run directory.
    warnings : returns the warnings of `staffa check` on the case.
    """
    if watcher is not None:
        require(watcher, Watcher, "watcher", "give a staffa.runs.run.Watcher")
        yield watcher
        return
    screen = screen_of_python(speaks=comm.rank == 0)
    found = on_root(comm, warnings)
    follower = Follower(
        directory=directory, speaks=comm.rank == 0, screen=screen, warnings=tuple(found)
    )
    with screen:
        yield follower.watcher()
