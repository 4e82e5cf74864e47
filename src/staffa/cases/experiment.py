"""Case -> run directory: builds, marches, measures, and writes each step when it is complete."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from staffa.stack import MPI, PETSc

import numpy as np

from staffa.cases.attached import attached
from staffa.cases.build import problem
from staffa.cases.model import Case
from staffa.cases.numbers import numbers
from staffa.cases.probe_keys import Line
from staffa.cases.provenance import commit, now, version
from staffa.cases.rules import is_scaled
from staffa.cases.writing import to_toml
from staffa.domain import cell_count
from staffa.evolution.march import Observers, march
from staffa.evolution.problem import Problem
from staffa.evolution.system import System, build
from staffa.evolution.toughness import discrete_toughness
from staffa.io import run_directory
from staffa.io.fields import FieldWriter
from staffa.loads.closed_form import Load
from staffa.manifest import Manifest, Probe
from staffa.measure.crack import Gauge, measures, planes
from staffa.measure.probes import Probes
from staffa.measure.tip import reach
from staffa.minimize.alternate import Sweep
from staffa.parallel import on_root
from staffa.physics.damage import DamageLaw
from staffa.physics.split import EnergySplit
from staffa.records import Moment, Step, kept


@dataclass(frozen=True, kw_only=True)
class Watcher:
    """Who follows a run: told the manifest, each sweep, each step. Called on every rank."""

    started: Callable[[Manifest], None] = lambda manifest: None
    swept: Callable[[Moment, Sweep], None] = lambda moment, sweep: None
    stepped: Callable[[Step], None] = lambda step: None


def run(
    case: Case,
    directory: Path,
    *,
    comm: MPI.Comm = MPI.COMM_WORLD,
    watcher: Watcher | None = None,
    damage: DamageLaw | None = None,
    split: EnergySplit | None = None,
    temperature: Load | None = None,
) -> tuple[Step, ...]:
    """Run a case to its end, give the steps that stand, and leave a run directory. Collective.

    Parameters
    ----------
    damage, split, temperature : a law, an energy split, a load of your own, in place of the case's.

    Raises
    ------
    InputError
        The directory holds a run already, or cannot be made.
    SolveError
        A step failed; everything finished before it is on disk.
    """
    watcher = watcher or Watcher()
    on_root(comm, lambda: run_directory.require_free(directory))
    setup = problem(case, comm=comm, damage=damage, split=split, temperature=temperature)
    looks = Probes(setup.domain, probes(case))
    factor = on_root(comm, lambda: _toughness(case, setup))
    system = build(setup)
    manifest = on_root(comm, lambda: describe(case, setup, system, factor))
    files = on_root(comm, lambda: attached(case))
    on_root(comm, lambda: run_directory.create(directory, to_toml(case), manifest, files))
    watcher.started(manifest)
    steps: tuple[Step, ...] = ()
    try:
        observers = _observers(case, setup, system, factor, directory, watcher, looks)
        for step in march(setup, system, observers):
            on_root(comm, partial(run_directory.append_step, directory, step))
            watcher.stepped(step)
            steps = kept([*steps, step])
    finally:
        system.destroy()
    return steps


def _toughness(case: Case, setup: Problem) -> float:
    return discrete_toughness(
        setup.material, dim=setup.domain.dim, h=setup.domain.h, cells=str(case.domain.cells)
    )


def _observers(
    case: Case,
    setup: Problem,
    system: System,
    factor: float,
    directory: Path,
    watcher: Watcher,
    looks: Probes,
) -> Observers:
    comm, plan = setup.domain.comm, setup.schedule
    writer = FieldWriter(comm, system.spaces)
    written: list[tuple[str, float]] = []
    gauge = Gauge(
        face=setup.face,
        depths=setup.measuring.depths,
        threshold=setup.measuring.threshold,
        prominence=setup.material.ell,
        h=setup.domain.h,
        toughness_factor=factor,
    )
    below = planes(setup.domain, gauge, setup.material.ell)

    def save(moment: Moment, converged: bool) -> str | None:
        time = moment.time
        asked = plan.wants(time) or time == plan.times[-1]
        if not (case.output.fields == "all" or asked or not converged):
            return None
        name = run_directory.fields_name(moment.index)
        writer.write(directory / name, system.state, system.energy.stress())
        written[:] = [*((n, t) for n, t in written if t < time), (name, time)]
        on_root(comm, lambda: run_directory.write_series(directory, written))
        return name

    return Observers(
        measure=lambda: measures(setup.domain, system.state, system.energy, gauge, below),
        probe=lambda: looks(system.state),
        save=save,
        watch=watcher.swept,
    )


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


def describe(case: Case, setup: Problem, system: System, factor: float) -> Manifest:
    """What this run is, for its manifest."""
    derived, domain, schedule = numbers(case), setup.domain, setup.schedule
    tau_of = setup.tau_of
    spaces = (system.spaces.u, system.spaces.alpha)
    return Manifest(
        version=version(),
        commit=commit(),
        created=now(),
        ranks=domain.comm.size,
        title=case.title,
        law=setup.material.law.name,
        split=setup.material.split.name,
        scaled=is_scaled(case),
        lower=domain.lower,
        size=domain.size,
        face=case.temperature.face if setup.face else None,
        side=case.outline.sides[case.temperature.face] if setup.face else None,
        h=domain.h,
        ell=setup.material.ell,
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
        scales=derived.table(),
        versions=_versions(),
        petsc_options=dict(PETSc.Options().getAll()),
        tip_reach=reach(
            setup.material.law.name,
            threshold=setup.measuring.threshold,
            ell=setup.material.ell,
            h=domain.h,
        ),
    )


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
    }
