"""Numbers of a finished run that is a member of an ensemble or a study."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from staffa.display_units import Unit
from staffa.io.run_directory import Run
from staffa.records.manifest import Manifest
from staffa.results.slab_table import run_arrests
from staffa.results.summary import summary
from staffa.results.tables import Column, Table

MOST_TOLD = 5  # members that a sentence names; others are counted
Numbers = Mapping[Column, float | None]


def arrest_numbers(run: Run) -> Numbers:
    """Return the run's line of the paper's table, and times; nothing without a cooled face."""
    found, m = run_arrests(run), run.manifest
    if found is None:
        return {}
    start, length = found.nucleation, _length(m)
    numbers = {Column(name="p", unit=length): start.spacing if start else None}
    for k, reached in enumerate((start, *found.generations)):
        numbers[Column(name=f"a{k}", unit=length)] = reached.depth if reached else None
        if not m.scaled:
            numbers[Column(name=f"t{k}", unit=m.shown.time)] = reached.time if reached else None
        numbers[Column(name=f"tau{k}")] = reached.tau if reached else None
    return numbers


def _length(manifest: Manifest) -> Unit:
    """Return the unit of lengths: L in a scaled case."""
    return Unit(size=manifest.L) if manifest.scaled else manifest.shown.length


def end_numbers(run: Run) -> Numbers:
    """Return the measures of the last step: cracks at each depth, lengths and areas.

    In a scaled case lengths are over L, areas over L^2.
    """
    measures, manifest = run.steps[-1].measures, run.manifest
    if measures is None:
        return {}
    found: dict[Column, float | None] = {
        Column(name=f"cracks at {manifest.shown.length.text(s.height, 6)}"): s.cracks
        for s in measures.sections
    }
    if manifest.face:
        found[Column(name="front", unit=_length(manifest))] = manifest.deepest(measures)
    name, power = ("length", 1) if manifest.plane else ("area", 2)
    unit = Unit(size=manifest.L**power) if manifest.scaled else manifest.shown.crack
    return found | {Column(name=name, unit=unit): measures.length_surface}


def energy_numbers(run: Run) -> Numbers:
    """Return the energies of the last step."""
    energies, unit = run.steps[-1].energies, run.manifest.shown.energy
    found: dict[Column, float | None] = {
        Column(name="elastic_energy", unit=unit, label="elastic energy"): energies.elastic,
        Column(name="surface_energy", unit=unit, label="surface energy"): energies.surface,
    }
    if energies.loads:
        found[Column(name="load_energy", unit=unit, label="energy of loads")] = energies.loads
    return found | {Column(name="total_energy", unit=unit, label="total energy"): energies.total}


def with_left_out(sheets: Sequence[Table], runs: Mapping[str, Run]) -> tuple[Table, ...]:
    """Return the sheets, the last with a sentence on the unfinished runs, which are in no mean.

    Parameters
    ----------
    sheets : tables of means.
    runs : the runs by their names.
    """
    by_status: dict[str, list[str]] = {}
    for name, run in runs.items():
        if not run.finished:
            by_status.setdefault(status_text(run), []).append(name)
    if not by_status or not sheets:
        return tuple(sheets)
    groups = [f"{bounded(names)} ({status})" for status, names in by_status.items()]
    left_out = f"Not finished, so in no mean: {bounded(groups)}."
    return *sheets[:-1], replace(sheets[-1], notes=(*sheets[-1].notes, left_out))


def bounded(names: Sequence[str], between: str = "; ") -> str:
    """Return the first few names as text, with the number of the others.

    Parameters
    ----------
    names : the names.
    between : text between two of them.
    """
    more = f" and {len(names) - MOST_TOLD} more" if len(names) > MOST_TOLD else ""
    return between.join(names[:MOST_TOLD]) + more


def status_text(run: Run) -> str:
    """Return the status of a run in words."""
    return next(fact.text for fact in summary(run) if fact.name == "status")
