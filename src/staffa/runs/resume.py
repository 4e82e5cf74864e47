"""Resumption of an unfinished run, and the changes of its case that are allowed."""

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from staffa.backend.stack import MPI

from staffa.arguments import path_of, require, settings_of
from staffa.backend.parallel import on_root
from staffa.case.reading.read import parse_case, setting_names
from staffa.case.schema.case import Case
from staffa.case.schema.toml_text import to_toml
from staffa.case.values.attached_files import CHANGEABLE, attached, case_identity
from staffa.case.values.pressing_loads import pressing
from staffa.errors import InputError, StaffaError
from staffa.evolution.problem import Problem
from staffa.evolution.session import Session
from staffa.evolution.step_quantities import (
    Recorded,
    known_quantities,
    require_same_quantities,
    tried_quantities,
)
from staffa.io import checkpoint, own_files, run_directory
from staffa.io.ensemble_directory import CRATE
from staffa.io.research_object import forget_crate_above
from staffa.io.run_directory import Run
from staffa.loads.closed_form import CoupledLoad, Load
from staffa.physics.damage import DamageLaw
from staffa.physics.split import EnergySplit
from staffa.records.manifest import Manifest
from staffa.records.step import Step, kept
from staffa.runs.checkpoints import CheckpointWriter, listed_versions, on_disk, versions
from staffa.runs.follower import followed
from staffa.runs.run import march_on, open_session
from staffa.runs.run_lock import hold_run_lock, require_run
from staffa.runs.run_observers import Watcher, probes, probing
from staffa.runs.times_ahead import schedule_ahead, with_times
from staffa.setup.build import COMM, problem
from staffa.setup.user_objects import Given, require_given, require_same, unrecorded


@dataclass(frozen=True, kw_only=True)
class Taken:
    """Usable part of an interrupted run.

    Attributes
    ----------
    page : page of its last good checkpoint; None if the run begins again.
    lines : lines of the file of steps up to the checkpoint.
    steps : kept steps in these lines.
    said : messages on the parts that cannot be used.
    """

    page: dict[str, Any] | None
    lines: tuple[str, ...]
    steps: tuple[Step, ...]
    said: tuple[str, ...]


def resume(
    directory: str | Path,
    *,
    settings: Sequence[str] = (),
    comm: MPI.Comm = MPI.COMM_WORLD,
    watcher: Watcher | None = None,
    damage: DamageLaw | None = None,
    split: EnergySplit | None = None,
    temperature: Load | CoupledLoad | None = None,
    quantities: Sequence[Recorded] = (),
) -> tuple[Step, ...]:
    """Go on with a run from its last good checkpoint to its end, on any number of ranks; give the
    steps that stand. Collective.

    Parameters
    ----------
    directory : the run directory.
    comm : communicator of the ranks that go on with it.
    watcher : follows the run; None for a log, and progress in a notebook or on a terminal.
    settings : "section.key=value" put over the run's case: of [time], [output] and [solver].
    damage, split, temperature : those that `run` was given: by what they are and give, see
        `setup.object_identity`.
    quantities : those that `run` was given: by their names and units.

    Raises
    ------
    InputError
        The directory holds no run, another process writes to it, or a setting, a law, a split or a
        load changes what has been computed.
    SolveError, StoppedError
        See `run`.
    """
    directory, settings = path_of(directory, "directory"), settings_of(settings)
    require(comm, MPI.Comm, "comm", COMM)
    quantities = known_quantities(quantities)
    on_root(comm, lambda: require_run(directory))
    given = Given(damage=damage, split=split, temperature=temperature)
    with followed(watcher, comm, directory) as looking:
        return _resumed(directory, settings, comm, looking, given, quantities)


def _resumed(
    directory: Path,
    settings: tuple[str, ...],
    comm: MPI.Comm,
    watcher: Watcher,
    given: Given,
    quantities: Sequence[Recorded],
) -> tuple[Step, ...]:
    """Take up a run and march to its end. Collective.

    Parameters
    ----------
    directory : the run directory.
    settings : changes of the case.
    comm : communicator of all ranks.
    watcher : follows the run.
    given : objects of a script in place of the case's.
    quantities : quantities of a script.
    """
    with hold_run_lock(comm, directory) as said_by_lock:
        old, case = on_root(comm, lambda: cases_of(directory, settings))
        manifest = on_root(comm, lambda: run_directory.read_manifest(directory))
        steps = on_root(comm, lambda: _steps(directory))
        finished = _is_finished(steps, manifest)
        if finished and not settings and on_root(comm, lambda: _stands(directory, case)):
            with on_disk(directory):
                on_root(comm, lambda: own_files.remove_halves(directory))
            return steps
        require_given(given, manifest.own, str(directory))
        require_same_quantities(quantities, manifest.quantities, str(directory))
        taken = on_root(comm, lambda: take(directory))
        if finished and settings:
            _require_checkpoint(directory, taken, settings)
        _may_change(case, manifest, taken)
        on_root(comm, lambda: _is_unchanged(old, manifest, directory))
        setup = problem(case, comm=comm, **vars(given))
        _is_the_same(setup, manifest, directory)
        require_same(given, manifest.own, setup, str(directory))
        setup = replace(setup, schedule=schedule_ahead(case, setup, manifest, taken.steps))
        manifest = replace(with_times(manifest, setup), ranks=comm.size, probes=probes(case))
        opening = open_session(setup, manifest.toughness_factor)
        del setup  # the session alone owns what belongs to a mesh
        with opening as session:
            journal = run_directory.Journal(directory, taken.lines)
            writer = CheckpointWriter(directory, session, case.output.checkpoint, journal)
            session.tool(probing, manifest.probes)
            tried_quantities(session, quantities, manifest.quantities)
            _tell_of_simulator(session, manifest, watcher)
            restart = writer.take_up(taken.page) if taken.page else None
            if restart and settings:
                restart = restart.for_new_solvers()
            with on_disk(directory):
                on_root(comm, lambda: _cut_back(directory, case, manifest, taken))
            watcher.started(manifest)
            said = (said_by_lock, *taken.said, unrecorded(manifest.own, given), _pressed(old, case))
            for sentence in filter(None, said):
                watcher.said(sentence)
            watcher.resumed(taken.steps)
            return march_on(
                case, session, manifest, watcher, writer, restart, taken.steps, quantities
            )


def _pressed(old: Case, case: Case) -> str | None:
    """Return a message if loads come to compress rock in a longer run without a split."""
    more = [load for load in pressing(case) if load not in pressing(old)]
    if case.damage.split != "none" or not more:
        return None
    return (
        f'the run began with damage.split = "none", and now {" and ".join(more)} may press its '
        f"rock, which then breaks as if pulled; begin a new run of the whole time, whose default "
        f"is safe"
    )


def _tell_of_simulator(session: Session, manifest: Manifest, watcher: Watcher) -> None:
    """Say that the reservoir simulator has another version than before, if it has."""
    coupling, before = session.circulated, manifest.reservoir
    if before and coupling and coupling.simulator != before.simulator:
        now = coupling.simulator
        watcher.said(f"numbers may differ a little: before {before.simulator} and now {now}")


def cases_of(directory: Path, settings: Sequence[str]) -> tuple[Case, Case]:
    """Return the case of a run as it is, and with these settings.

    Raises
    ------
    InputError
        A setting is invalid, or of a table that must not change.
    """
    text = run_directory.read_case_text(directory)
    name = str(directory / run_directory.CASE)
    for setting in settings:
        table = setting_names(setting)[0]
        if table not in CHANGEABLE:
            raise InputError(
                f"--set {setting}: a run goes on with the body, the rock and the loads it has, and "
                f"only [time], [output] and [solver] may change; `staffa run {name} --set "
                f"{setting} --out ANOTHER` begins a new one"
            )
    return (
        parse_case(text, name=name, folder=directory, of_run=True),
        parse_case(text, settings, name=name, folder=directory, of_run=True),
    )


def take(directory: Path) -> Taken:
    """Find the last good checkpoint whose steps are on disk unchanged.

    Raises
    ------
    InputError
        The latest has a format of a later version.
    """
    folder = directory / checkpoint.FOLDER
    lines, said = run_directory.journal_lines(directory), []
    for number in checkpoint.checkpoint_numbers(folder):
        try:
            page = checkpoint.read_page(folder, number)
            if run_directory.Journal(directory, lines[: page["lines"]]).sum != page["steps"]:
                raise checkpoint.DamagedError(
                    f"{run_directory.STEPS} is not what it was when it was written"
                )
            for name in page["parts"]:
                checkpoint.read_part(folder, name)
        except checkpoint.DamagedError as error:
            said.append(f"the checkpoint after {number} lines of steps cannot be used: {error}")
            continue
        known = tuple(lines[: page["lines"]])
        steps = kept(run_directory.steps_in(known, directory / run_directory.STEPS))
        other = {
            f"{name} {page['versions'][name]} and now {now}"
            for name, now in versions().items()
            if page["versions"].get(name, now) != now
        }
        if other:
            said.append(f"numbers may differ a little: before {', '.join(sorted(other))}")
        return Taken(page=page, lines=known, steps=steps, said=tuple(said))
    if lines:
        said.append(
            f"no checkpoint can be used: the run begins again with its first step; "
            f"{run_directory.STEPS} as it was is put beside it, with a number"
        )
    return Taken(page=None, lines=(), steps=(), said=tuple(said))


def _steps(directory: Path) -> tuple[Step, ...]:
    """Return the steps of a run, even without a checkpoint: a finished run needs none."""
    with suppress(StaffaError):
        return run_directory.open_run(directory).steps
    return ()


def _stands(directory: Path, case: Case) -> bool:
    """Return True if a run at its last time is complete with its backtracking.

    Without a checkpoint that is not known, and the run is left unchanged.
    """
    taken = take(directory) if case.solver.backtracking else None
    if taken is None or taken.page is None:
        return True
    restart, lines = taken.page["standing"], run_directory.journal_lines(directory)
    ended = restart["better"] is None and not restart.get("due")
    return bool(taken.page["lines"] == len(lines) and ended)


def _require_checkpoint(directory: Path, taken: Taken, settings: Sequence[str]) -> None:
    """Refuse to extend a finished run that would have to begin again."""
    if taken.page is None:
        asked = " ".join(f"--set {setting}" for setting in settings)
        raise InputError(
            f"{directory} is finished, and has no checkpoint to go on from; `staffa run "
            f"{directory / run_directory.CASE} {asked} --out ANOTHER` begins a new one"
        )


def _is_finished(steps: Sequence[Step], manifest: Manifest) -> bool:
    return bool(steps) and Run(path=Path(), case="", manifest=manifest, steps=tuple(steps)).finished


def _cut_back(directory: Path, case: Case, manifest: Manifest, taken: Taken) -> None:
    """Reduce the directory to the state of the checkpoint, with the case as it is now."""
    own_files.remove_halves(directory)
    (directory / CRATE).unlink(missing_ok=True)  # it is written again at the end
    forget_crate_above(directory)
    text = to_toml(case)
    manifest = replace(manifest, identity=case_identity(text, attached(case)))
    run_directory.write_case(directory, text, manifest)
    if taken.page is None and run_directory.journal_lines(directory):
        run_directory.put_aside(directory)
    number = taken.page["lines"] if taken.page else -1
    checkpoint.remove_after(directory / checkpoint.FOLDER, number)
    run_directory.cut_back(directory, taken.lines, taken.steps)
    (directory / own_files.NETWORK).unlink(missing_ok=True)  # of steps that may be no more


def _may_change(case: Case, manifest: Manifest, taken: Taken) -> None:
    """Refuse a change of the case that contradicts the steps that are already computed."""
    if taken.steps and probes(case) != manifest.probes:
        raise InputError(
            "output.probes: they are read off at every step, and steps are finished; leave them as "
            "they are, or begin a new run"
        )
    if taken.page and taken.steps and case.solver.backtracking and not taken.page["past"]:
        raise InputError(
            "solver.backtracking = true: the run has kept no earlier state to go back to; begin a "
            "new run with it"
        )


def _is_unchanged(case: Case, manifest: Manifest, directory: Path) -> None:
    """Refuse a case that was changed after the run began."""
    now = case_identity(run_directory.read_case_text(directory), attached(case))
    if manifest.identity not in (None, now):
        raise InputError(
            f"{directory / run_directory.CASE}, or a file that it names, was changed after the run "
            f"began; take that back, or run it as another one with `staffa run "
            f"{directory / run_directory.CASE} --out ANOTHER`"
        )


def _is_the_same(setup: Problem, manifest: Manifest, directory: Path) -> None:
    """Refuse a run of another mesh or other laws."""
    law, split = setup.material.law.name, setup.material.split.name
    if (law, split) != (manifest.law, manifest.split):
        raise InputError(
            f"{directory} was run with the law {manifest.law} and the split {manifest.split}, not "
            f"{law} and {split}; go on with the same ones"
        )
    if setup.elements != manifest.elements:
        raise InputError(
            f"{directory} was run with {manifest.elements} elements, where this staffa takes "
            f"{setup.elements} ones; go on with the staffa that began it, "
            f"{manifest.version}, or run the case again"
        )
    if setup.domain.identity != manifest.mesh:
        raise InputError(
            f"{directory}: the mesh that is made now is not that of the run; use the versions that "
            f"made it, {listed_versions(manifest.versions)}"
        )
