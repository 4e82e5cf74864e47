"""Observers of a run: who follows it, and what is read off and written at each step."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from staffa.backend.stack import MPI

import numpy as np

from staffa.backend.parallel import any_over_ranks, best_candidate, on_root
from staffa.case.schema.case import Case
from staffa.case.schema.probe_keys import Line
from staffa.errors import StoppedError
from staffa.evolution.measures import measured, releasing
from staffa.evolution.observers import Observers
from staffa.evolution.output_fields import field_values
from staffa.evolution.schedule import Schedule
from staffa.evolution.session import Session
from staffa.evolution.step_quantities import Recorded, evaluated_quantities
from staffa.io import run_directory
from staffa.io.field_output import FieldWriter
from staffa.io.reservoir_fields import write_reservoir
from staffa.measure.probes import Probes
from staffa.minimize.alternate import Sweep
from staffa.records.manifest import Manifest, Probe
from staffa.records.step import Measures, Moment, Step
from staffa.records.tip_release import Release
from staffa.runs.checkpoints import CheckpointWriter, on_disk


@dataclass(frozen=True, kw_only=True)
class Watcher:
    """Functions of one who follows a run. Called on every rank.

    Attributes
    ----------
    started : called with the manifest before the first step.
    said : called with each sentence that a user should read.
    resumed : called with the kept steps after which a run goes on.
    swept : called after each sweep, with the moment of its step.
    stepped : called after each step.
    stop : returns why this rank is asked to stop the run, None if it is not; called after each
        sweep.
    """

    started: Callable[[Manifest], None] = lambda manifest: None
    said: Callable[[str], None] = lambda sentence: None
    resumed: Callable[[tuple[Step, ...]], None] = lambda steps: None
    swept: Callable[[Moment, Sweep], None] = lambda moment, sweep: None
    stepped: Callable[[Step], None] = lambda step: None
    stop: Callable[[], str | None] = lambda: None


def writer(session: Session) -> FieldWriter:
    """Return the writer of fields on the current mesh. Collective."""
    return FieldWriter(session.comm, session.system.spaces)


def probing(session: Session, probes: tuple[Probe, ...]) -> Probes:
    """Return what looks at these points of the current mesh. Collective."""
    return Probes(session.domain, probes)


def released(session: Session) -> tuple[Release, ...]:
    """Return G at the tips of the session's state. Collective."""
    return session.tool(_releasing)()


def _releasing(session: Session) -> Callable[[], tuple[Release, ...]]:
    grid = session.tool(writer).grid
    return releasing(session, mesh=None if grid is None else (grid.points, grid.cells))


def observers(
    case: Case,
    session: Session,
    manifest: Manifest,
    watcher: Watcher,
    writer: CheckpointWriter,
    steps: tuple[Step, ...],
    quantities: Sequence[Recorded] = (),
) -> Observers:
    """Return what is done at each step of a run.

    Parameters
    ----------
    case : case of the run.
    session : owner of the first mesh; nothing of that is kept here.
    manifest : description of the run.
    watcher : who follows it.
    writer : writes its checkpoints.
    steps : those that stand already.
    quantities : those of a script, which are recorded at each step.
    """
    return Observers(
        measure=_measuring(steps),
        probe=lambda session: session.tool(probing, manifest.probes)(session.state),
        quantities=lambda session: evaluated_quantities(session, quantities, manifest.quantities),
        save=_saving(case, session.problem.schedule, writer.directory, steps),
        release=released,
        watch=watcher.swept,
        keep=writer.keep,
        pause=_pausing(session.comm, watcher),
    )


def _measuring(steps: tuple[Step, ...]) -> Callable[[Session, Moment], Measures]:
    """Return the function that measures a step, and knows the measures of the step before.

    Parameters
    ----------
    steps : those that stand already.
    """
    known = [(step.index, step.measures) for step in steps]

    def measure(session: Session, moment: Moment) -> Measures:
        earlier = [(index, found) for index, found in known if index < moment.index]
        found = measured(session, moment, earlier[-1][1] if earlier else None)
        known[:] = [*earlier, (moment.index, found)]
        return found

    return measure


def _saving(
    case: Case, plan: Schedule, directory: Path, steps: tuple[Step, ...]
) -> Callable[[Session, Moment, bool], str | None]:
    """The function that writes the fields of a step, if they are to be kept, and gives their file.

    steps: those that stand already.
    """
    written = [(step.fields, step.time) for step in steps if step.fields]

    def save(session: Session, moment: Moment, converged: bool) -> str | None:
        time = moment.time
        asked = plan.wants(time) or time == plan.times[-1]
        if not (case.output.steps == "all" or asked or not converged):
            return None
        name = run_directory.fields_name(moment.index)
        of_fluid = ("p",) if session.problem.forces.fluid else ()
        names = dict.fromkeys((*case.output.fields, *of_fluid))
        at_vertices, in_cells = field_values(session, names)
        before = [(n, t) for n, t in written if t < time]
        written[:] = [*before, (name, time)] if converged else before
        with on_disk(directory):
            session.tool(writer).write(directory / name, at_vertices, in_cells)
            _save_reservoir(session, directory, moment.index)
            on_root(session.comm, lambda: run_directory.write_series(directory, written))
        return name

    return save


def _save_reservoir(session: Session, directory: Path, index: int) -> None:
    """Write the fields of the reservoir's cells beside those of a step. Collective."""
    coupling, system = session.circulated, session.system
    if coupling is None:
        return
    grid = coupling.model.grid
    fields = coupling.cell_fields(system.thermal.read(), system.cracks)
    on_root(
        session.comm,
        lambda: write_reservoir(directory, index, grid.edges[: grid.dim], **fields),
    )


def _pausing(comm: MPI.Comm, watcher: Watcher) -> Callable[[], None]:
    """The function that stops the run on all ranks where the watcher of one asks for it."""

    def pause() -> None:
        reason = watcher.stop()
        if any_over_ranks(comm, reason is not None):
            told = best_candidate(comm, None if reason is None else (reason,))
            raise StoppedError(str(told and told[0]))

    return pause


def probes(case: Case) -> tuple[Probe, ...]:
    """The points at which a case reads off fields."""
    found = []
    for keys in case.output.probes:
        if isinstance(keys, Line):
            points = np.linspace(keys.start, keys.end, keys.points, dtype=float)
        else:
            points = np.array([keys.point], dtype=float)
        found.append(Probe(name=keys.name, points=tuple(map(tuple, points.tolist()))))
    return tuple(found)
