"""Run of a case: it builds, marches, measures, and writes each completed step."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from staffa.backend.stack import MPI, OWN, PETSc

import numpy as np

from staffa.arguments import path_of, require
from staffa.backend.jit import chosen_flags
from staffa.backend.lock import Lock
from staffa.backend.parallel import any_over_ranks, best_candidate, on_root, require_together
from staffa.backend.petsc_options import petsc_errors
from staffa.case.check.preview import split_facts
from staffa.case.rules import is_scaled
from staffa.case.scales.case_scales import Numbers, derived_numbers
from staffa.case.scales.shown_units import reference, units
from staffa.case.schema.case import Case
from staffa.case.schema.probe_keys import Line
from staffa.case.schema.toml_text import to_toml
from staffa.case.values.attached_files import attached, case_identity
from staffa.case.values.default_split import for_any_load
from staffa.errors import StaffaError, StoppedError
from staffa.evolution.effective_toughness import effective_gc_ratio
from staffa.evolution.march import Observers, march
from staffa.evolution.measures import measuring, releasing
from staffa.evolution.problem import Problem
from staffa.evolution.restart_state import RestartState
from staffa.evolution.system import System, build
from staffa.io import run_directory
from staffa.io.field_output import FieldWriter
from staffa.loads.closed_form import Load
from staffa.measure.probes import Probes
from staffa.measure.tip import reach
from staffa.minimize.alternate import Sweep
from staffa.model.domain import cell_count
from staffa.physics.damage import DamageLaw
from staffa.physics.split import EnergySplit
from staffa.records.manifest import Manifest, Own, Probe
from staffa.records.step import Moment, Step, kept
from staffa.runs.checkpoints import FLAGS, CheckpointWriter, on_disk
from staffa.runs.provenance import commit, now, version
from staffa.setup.build import CASE, COMM, problem
from staffa.setup.user_objects import Given, recorded


@dataclass(frozen=True, kw_only=True)
class Watcher:
    """Functions that follow a run, called on every rank.

    Attributes
    ----------
    started : called with the manifest.
    said : called with each message.
    resumed : called with the steps after which a run continues.
    swept : called after each sweep.
    stepped : called after each step.
    stop : returns a reason to stop the run, or None; called after each sweep.
    """

    started: Callable[[Manifest], None] = lambda manifest: None
    said: Callable[[str], None] = lambda sentence: None
    resumed: Callable[[tuple[Step, ...]], None] = lambda steps: None
    swept: Callable[[Moment, Sweep], None] = lambda moment, sweep: None
    stepped: Callable[[Step], None] = lambda step: None
    stop: Callable[[], str | None] = lambda: None


def run(
    case: Case,
    directory: str | Path,
    *,
    comm: MPI.Comm = MPI.COMM_WORLD,
    watcher: Watcher | None = None,
    damage: DamageLaw | None = None,
    split: EnergySplit | None = None,
    temperature: Load | None = None,
) -> tuple[Step, ...]:
    """Run a case to its end, and write a run directory. Collective.

    Parameters
    ----------
    case : the case.
    directory : the run directory, which is made.
    comm : communicator of all ranks.
    watcher : follows the run; None for nobody.
    damage : your own damage law, in place of the case's; `resume` asks for it again.
    split : your own energy split, likewise.
    temperature : your own load, likewise.

    Returns
    -------
    steps : the kept steps.

    Raises
    ------
    InputError
        The directory contains a run already, or cannot be made; or see `problem`.
    SolveError
        A step failed; everything finished before it is on disk.
    StoppedError The watcher asked to stop, or the directory cannot be written to any more; `resume`
        continues.
    """
    require(case, Case, "case", CASE)
    require(comm, MPI.Comm, "comm", COMM)
    directory, watcher = path_of(directory, "directory"), watching(watcher)
    on_root(comm, lambda: _require_free(directory))
    if temperature is not None:
        case = for_any_load(case)  # as it is written into the directory
    given = Given(damage=damage, split=split, temperature=temperature)
    setup = problem(case, comm=comm, **vars(given))
    own, factor = recorded(given, setup), effective_gc_ratio(setup)
    with built(setup) as system:
        manifest = on_root(comm, lambda: describe(case, setup, system, factor, own))
        files = on_root(comm, lambda: attached(case))
        looks = Probes(setup.domain, manifest.probes)
        with hold_run_lock(comm, directory, new=True) as said_by_lock:
            text = to_toml(case)
            with on_disk(directory, begun=False):
                on_root(comm, lambda: run_directory.create(directory, text, manifest, files))
            watcher.started(manifest)
            if said_by_lock:
                watcher.said(said_by_lock)
            journal = run_directory.Journal(directory)
            keeper = CheckpointWriter(
                comm, directory, system, manifest.h, case.output.checkpoint, journal
            )
            return march_on(case, setup, system, manifest, watcher, keeper, looks)


def watching(watcher: Watcher | None) -> Watcher:
    """Return the watcher, or one that does nothing."""
    if watcher is not None:
        require(watcher, Watcher, "watcher", "give a staffa.runs.run.Watcher")
    return watcher or Watcher()


@contextmanager
def built(setup: Problem) -> Iterator[System]:
    """Build the system of a problem, and destroy it in the end. Collective.

    Its destruction is collective, so it is left out after an error that one rank may have alone.
    """
    asked = "the solvers could not be made; see what PETSC_OPTIONS asks for"
    with petsc_errors(asked, PETSc.Comm(setup.domain.comm)):
        system = build(setup)
    alone = False
    try:
        yield system
    except Exception as error:
        alone = setup.domain.comm.size > 1
        if isinstance(error, StaffaError):
            require_together(setup.domain.comm, error)
            alone = False
        raise
    finally:
        if not alone:
            system.destroy()


def _require_free(directory: Path) -> None:
    way_out = f"go on with `staffa resume {directory}` if it is not finished, or choose another one"
    run_directory.require_free(directory, way_out)


@contextmanager
def hold_run_lock(comm: MPI.Comm, directory: Path, *, new: bool = False) -> Iterator[str | None]:
    """Hold the lock of a run directory, and yield its message if it has one. Collective.

    Parameters
    ----------
    comm : communicator of all ranks.
    directory : the run directory.
    new : True if it must not contain a run, and is made.

    Raises
    ------
    InputError
        Another process writes to it, or it cannot be written to.
    """
    lock = Lock(directory)

    def take() -> str | None:
        if new:
            directory.mkdir(parents=True, exist_ok=True)
        said = lock.take()
        if new:
            _require_free(directory)
        return said

    with on_disk(directory, begun=False):
        said = on_root(comm, take)
    try:
        yield said
    finally:
        if comm.rank == 0:  # one rank alone may have an error: no rank waits here
            lock.release()


def march_on(
    case: Case,
    setup: Problem,
    system: System,
    manifest: Manifest,
    watcher: Watcher,
    keeper: CheckpointWriter,
    looks: Probes,
    standing: RestartState | None = None,
    steps: tuple[Step, ...] = (),
) -> tuple[Step, ...]:
    """March from a restart state to the end of the run, and return the kept steps. Collective.

    Parameters
    ----------
    case : the case.
    setup : its problem.
    system : its system.
    manifest : description of the run.
    watcher : follows the run.
    keeper : writes steps and checkpoints.
    looks : the probes.
    standing : the restart state; None for the start of the run.
    steps : kept steps before it.
    """
    observers = _observers(case, setup, system, manifest, watcher, keeper, looks, steps)
    begun_with = len(steps)
    try:
        for step in march(setup, system, observers, standing):
            keeper.note(step)
            watcher.stepped(step)
            steps = kept([*steps, step])
    except StoppedError as stopped:
        raise StoppedError(
            _how_to_go_on(str(stopped), keeper.directory, steps, begun_with)
        ) from None
    return steps


def _how_to_go_on(why: str, directory: Path, steps: tuple[Step, ...], before: int) -> str:
    if not steps:
        done = "before its first step was finished"
    elif len(steps) == before:
        done = f"no step after step {steps[-1].index} was finished"
    else:
        done = f"step {steps[-1].index} is finished"
    return f"stopped, since {why}: {done}; `staffa resume {directory}` goes on"


def _observers(
    case: Case,
    setup: Problem,
    system: System,
    manifest: Manifest,
    watcher: Watcher,
    keeper: CheckpointWriter,
    looks: Probes,
    steps: tuple[Step, ...],
) -> Observers:
    comm, plan, directory = setup.domain.comm, setup.schedule, keeper.directory
    writer = FieldWriter(comm, system.spaces)
    written = [(step.fields, step.time) for step in steps if step.fields]

    def save(moment: Moment, converged: bool) -> str | None:
        time = moment.time
        asked = plan.wants(time) or time == plan.times[-1]
        if not (case.output.fields == "all" or asked or not converged):
            return None
        name = run_directory.fields_name(moment.index)
        stress = system.energy.stress().reshape(-1, 9)
        in_cells = {"stress": stress, **system.energy.openings.strains()}
        written[:] = [*((n, t) for n, t in written if t < time), (name, time)]
        with on_disk(directory):
            writer.write(directory / name, system.state, in_cells)
            on_root(comm, lambda: run_directory.write_series(directory, written))
        return name

    def pause() -> None:
        reason = watcher.stop()
        if any_over_ranks(comm, reason is not None):
            told = best_candidate(comm, None if reason is None else (reason,))
            raise StoppedError(str(told and told[0]))

    return Observers(
        measure=measuring(setup, system, manifest.toughness_factor),
        probe=lambda: looks(system.state),
        save=save,
        release=releasing(
            setup,
            system,
            factor=manifest.toughness_factor,
            mesh=None if writer.grid is None else (writer.grid.points, writer.grid.cells),
        ),
        watch=watcher.swept,
        keep=keeper.keep,
        pause=pause,
    )


def probes(case: Case) -> tuple[Probe, ...]:
    """Return the points at which a case records fields."""
    found = []
    for keys in case.output.probes:
        if isinstance(keys, Line):
            points = np.linspace(keys.start, keys.end, keys.points, dtype=float)
        else:
            points = np.array([keys.point], dtype=float)
        found.append(Probe(name=keys.name, points=tuple(map(tuple, points.tolist()))))
    return tuple(found)


def describe(
    case: Case, setup: Problem, system: System, factor: float, own: dict[str, Own]
) -> Manifest:
    """Return the manifest of this run.

    Parameters
    ----------
    case : the case.
    setup : its problem.
    system : its system.
    factor : effective Gc over Gc.
    own : identities of objects that a script gave in place of the case's.
    """
    own_load, domain, schedule = "temperature" in own, setup.domain, setup.schedule
    material = setup.material
    derived = derived_numbers(case, law=material.law, split=material.split, own_load=own_load)
    tau_of = setup.tau_of
    spaces = (system.spaces.u, system.spaces.alpha)
    return Manifest(
        version=version(),
        commit=commit(),
        created=now(),
        ranks=domain.comm.size,
        title=case.title,
        law=material.law.name,
        split=material.split.name,
        split_reason="" if own.keys() & {"split", "temperature"} else _why_split(case, derived),
        scaled=is_scaled(case),
        lower=domain.lower,
        size=domain.size,
        face=case.temperature.face if setup.face else None,
        side=case.outline.sides[case.temperature.face] if setup.face else None,
        h=domain.h,
        ell=material.ell,
        L=derived.L,
        cells=cell_count(domain),
        unknowns=sum(s.dofmap.index_map.size_global * s.dofmap.index_map_bs for s in spaces),
        mesh=domain.identity,
        toughness_factor=factor,
        times=schedule.times,
        taus=tuple(None if tau_of is None else tau_of(t) for t in schedule.times),
        requested=schedule.requested,
        adaptive=schedule.pace is not None,
        probes=probes(case),
        threshold=setup.measuring.threshold,
        scales={} if own_load else derived.table(),
        versions=_versions(),
        petsc_options=_petsc_options(),
        identity=case_identity(to_toml(case), attached(case)),
        own=own,
        tip_reach=reach(
            material.law.name,
            threshold=setup.measuring.threshold,
            ell=material.ell,
            h=domain.h,
        ),
        profile="" if own_load else case.temperature.profile,
        units=units(case, derived),
        axial=domain.axial,
        reference=None if own_load else reference(case),
        elements=setup.elements,
    )


def _why_split(case: Case, derived: Numbers) -> str:
    ((_, _, why),) = split_facts(case, derived)
    return why


def _petsc_options() -> dict[str, str]:
    """Return the options given to PETSc or set by staffa; one without a value is empty."""
    given = PETSc.Options().getAll()
    return {name: value or "" for name, value in given.items() if name not in OWN}


def _versions() -> dict[str, str]:
    import platform

    import dolfinx
    import numpy

    return {
        "python": platform.python_version(),
        "dolfinx": dolfinx.__version__,
        "petsc": ".".join(str(n) for n in PETSc.Sys.getVersion()),
        "mpi": MPI.Get_library_version().split("\n")[0].strip(),
        "numpy": numpy.__version__,
        FLAGS: " ".join(chosen_flags()),
    }
