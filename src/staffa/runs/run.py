"""Run of a case: it builds, marches, measures, and writes each completed step."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from staffa.backend.stack import MPI, OWN, PETSc

import numpy as np

from staffa.arguments import path_of, require
from staffa.backend.jit import chosen_flags
from staffa.backend.parallel import after_error, on_root, require_together
from staffa.backend.petsc_options import petsc_errors
from staffa.case.check.preview import preview, split_facts
from staffa.case.rules import is_scaled
from staffa.case.scales.case_scales import Numbers, derived_numbers
from staffa.case.scales.shown_units import reference, units
from staffa.case.schema.case import Case
from staffa.case.schema.toml_text import to_toml
from staffa.case.values.attached_files import attached, case_identity
from staffa.case.values.default_split import for_any_load
from staffa.errors import StaffaError, StoppedError
from staffa.evolution.effective_toughness import effective_gc_ratio
from staffa.evolution.march import march_session
from staffa.evolution.problem import Problem
from staffa.evolution.restart_state import RestartState
from staffa.evolution.session import Session
from staffa.evolution.step_quantities import Recorded, known_quantities, tried_quantities
from staffa.evolution.system import build
from staffa.io import run_directory
from staffa.io.research_object import describe_stopped, write_own_crate
from staffa.loads.closed_form import CoupledLoad, Load
from staffa.measure.tip import reach
from staffa.model.domain import cell_count
from staffa.physics.damage import DamageLaw
from staffa.physics.split import EnergySplit
from staffa.records.manifest import Manifest, Own, QuantityRecord
from staffa.records.reservoir_facts import ReservoirFacts
from staffa.records.step import Step, kept
from staffa.reservoir.describe_model import reservoir_facts
from staffa.runs.checkpoints import FLAGS, CheckpointWriter, on_disk
from staffa.runs.follower import followed
from staffa.runs.provenance import commit, now, version
from staffa.runs.run_lock import hold_run_lock, require_new
from staffa.runs.run_observers import Watcher as Watcher
from staffa.runs.run_observers import observers, probes, probing
from staffa.setup.build import CASE, COMM, problem
from staffa.setup.user_objects import Given, recorded


def run(
    case: Case,
    directory: str | Path,
    *,
    comm: MPI.Comm = MPI.COMM_WORLD,
    watcher: Watcher | None = None,
    damage: DamageLaw | None = None,
    split: EnergySplit | None = None,
    temperature: Load | CoupledLoad | None = None,
    quantities: Sequence[Recorded] = (),
) -> tuple[Step, ...]:
    """Run a case to its end, give the steps that stand, and leave a run directory. Collective.

    Parameters
    ----------
    case : the case.
    directory : the run directory, which must be new or empty.
    comm : communicator of the ranks that run it.
    watcher : follows the run; None for a log, and progress in a notebook or on a terminal.
    damage, split, temperature : a law, an energy split, a load of your own, in place of the case's;
        the manifest keeps their identity, and `resume` asks for them.
    quantities : quantities of your own, see `staffa.StepQuantity`, which are recorded at each step;
        `resume` asks for them.

    Raises
    ------
    InputError
        The directory holds a run already, or cannot be made; or see `problem`.
    SolveError
        A step failed; everything finished before it is on disk.
    StoppedError
        The watcher asked to stop, or the directory cannot be written to any more; `resume` goes on.
    """
    require(case, Case, "case", CASE)
    require(comm, MPI.Comm, "comm", COMM)
    directory, quantities = path_of(directory, "directory"), known_quantities(quantities)
    on_root(comm, lambda: require_new(directory))
    if temperature is not None:
        case = for_any_load(case)  # as it is written into the directory
    given = Given(damage=damage, split=split, temperature=temperature)
    with followed(watcher, comm, directory, lambda: _warnings(case, given)) as follower:
        return _new_run(case, directory, comm, follower, given, quantities)


def _warnings(case: Case, given: Given) -> tuple[str, ...]:
    """Return the warnings of `staffa check`; none on a case whose objects a script replaces."""
    return () if given.names else preview(case).warnings


def _new_run(
    case: Case,
    directory: Path,
    comm: MPI.Comm,
    watcher: Watcher,
    given: Given,
    quantities: Sequence[Recorded],
) -> tuple[Step, ...]:
    """Build a case, write its directory and march to its end, as `run`. Collective.

    Parameters
    ----------
    case : the case.
    directory : the run directory.
    comm : communicator of all ranks.
    watcher : follows the run.
    given : objects of a script in place of the case's.
    quantities : quantities of a script.
    """
    setup = problem(case, comm=comm, **vars(given))
    own, opening = recorded(given, setup), open_session(setup, effective_gc_ratio(setup))
    del setup  # the session alone owns what belongs to a mesh
    with opening as session:
        tried = tried_quantities(session, quantities)
        manifest = on_root(comm, lambda: describe(case, session, own, tried))
        files = on_root(comm, lambda: attached(case))
        session.tool(probing, manifest.probes)  # refuses a point outside before all is written
        with hold_run_lock(comm, directory, new=True) as said_by_lock:
            text = to_toml(case)
            with on_disk(directory, started=False):
                on_root(comm, lambda: run_directory.create(directory, text, manifest, files))
            watcher.started(manifest)
            if said_by_lock:
                watcher.said(said_by_lock)
            journal = run_directory.Journal(directory)
            writer = CheckpointWriter(directory, session, case.output.checkpoint, journal)
            return march_on(case, session, manifest, watcher, writer, quantities=quantities)


@contextmanager
def open_session(setup: Problem, toughness_factor: float) -> Iterator[Session]:
    """The session of a problem, destroyed in the end. Collective.

    To destroy it ranks wait for one another: not after an error that one of them may meet alone.

    Parameters
    ----------
    setup : problem on the first mesh.
    toughness_factor : effective Gc over Gc on its cells.
    """
    asked = "the solvers could not be made; see what PETSC_OPTIONS asks for"
    with petsc_errors(asked, PETSc.Comm(setup.domain.comm)):
        session = Session(setup, build(setup), toughness_factor=toughness_factor)
    comm = session.comm
    del setup  # the session alone owns what belongs to a mesh
    alone = False
    try:
        yield session
    except Exception as error:
        alone = comm.size > 1
        if isinstance(error, StaffaError):
            require_together(comm, error)
            alone = False
        raise
    finally:
        if not alone:
            session.destroy()


def march_on(
    case: Case,
    session: Session,
    manifest: Manifest,
    watcher: Watcher,
    writer: CheckpointWriter,
    restart: RestartState | None = None,
    steps: tuple[Step, ...] = (),
    quantities: Sequence[Recorded] = (),
) -> tuple[Step, ...]:
    """March from a restart state to the end of the run, and return the kept steps. Collective.

    Parameters
    ----------
    case : the case.
    session : owner of its first mesh.
    manifest : description of the run.
    watcher : follows the run.
    writer : writes steps and checkpoints.
    restart : the restart state; None for the start of the run.
    steps : kept steps before it.
    quantities : quantities of a script, recorded at each step.
    """
    looking_on = observers(case, session, manifest, watcher, writer, steps, quantities)
    started_with = len(steps)
    directory = writer.directory
    with after_error(session.comm, lambda: describe_stopped(directory)):
        try:
            for step in march_session(session, looking_on, restart):
                writer.note(step)
                watcher.stepped(step)
                steps = kept([*steps, step])
        except StoppedError as stopped:
            raise StoppedError(
                _how_to_go_on(str(stopped), directory, steps, started_with)
            ) from None
    on_root(session.comm, lambda: _leave_description(directory))
    return steps


def _leave_description(directory: Path) -> None:
    """Describe a run that is finished, if its files and the disk let that be."""
    with suppress(Exception):  # of any library: the run is finished all the same
        write_own_crate(directory)


def _how_to_go_on(why: str, directory: Path, steps: tuple[Step, ...], before: int) -> str:
    if not steps:
        done = "before its first step was finished"
    elif len(steps) == before:
        done = f"no step after step {steps[-1].index} was finished"
    else:
        done = f"step {steps[-1].index} is finished"
    return f"stopped, since {why}: {done}; `staffa resume {directory}` goes on"


def describe(
    case: Case,
    session: Session,
    own: dict[str, Own],
    quantities: tuple[QuantityRecord, ...] = (),
) -> Manifest:
    """Describe this run for its manifest.

    Parameters
    ----------
    case : case of the run.
    session : owner of its first mesh.
    own : laws, splits and loads that a script gives in place of the case's.
    quantities : quantities of a script, recorded at each step.
    """
    setup, system = session.problem, session.system
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
        cooled=tuple(filter(None, map(case.outline.sides.get, setup.measuring.cooled))),
        face_cools=setup.measuring.cools,
        h=domain.h,
        ell=material.ell,
        L=derived.L,
        cells=cell_count(domain),
        unknowns=sum(s.dofmap.index_map.size_global * s.dofmap.index_map_bs for s in spaces),
        mesh=domain.identity,
        toughness_factor=session.toughness_factor,
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
            material.law,
            threshold=setup.measuring.threshold,
            ell=material.ell,
            h=domain.h,
        ),
        profile="" if own_load else case.temperature.profile,
        units=units(case, derived),
        axial=domain.axial,
        refined=domain.source is not None,
        reference=None if own_load else reference(case),
        elements=setup.elements,
        quantities=quantities,
        reservoir=_reservoir(session),
    )


def _reservoir(session: Session) -> ReservoirFacts | None:
    coupling, domain = session.circulated, session.domain
    if coupling is None:
        return None
    upper = tuple(np.add(domain.lower, domain.size).tolist())
    rule = coupling.feedback.rule if coupling.feedback else None
    return reservoir_facts(coupling.model, coupling.simulator, domain.lower, upper, rule)


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
