"""Numbers of an ensemble: those of each finished member, and their means and errors."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path

from staffa.errors import StaffaError
from staffa.io.ensemble_directory import RESULTS, Ensemble
from staffa.io.own_files import write_aside
from staffa.measure.averages import average
from staffa.records.manifest import Manifest
from staffa.results.facts import Fact
from staffa.results.member_numbers import (
    Numbers,
    arrest_numbers,
    end_numbers,
    status_text,
    with_left_out,
)
from staffa.results.members_production import MEMBERS, members_production
from staffa.results.slab_table import GENERATIONS, definitions, tip
from staffa.results.summary import summary
from staffa.results.tables import Column, Table, columns_of

MEANS = (
    "error: standard error of the mean, s/sqrt(n), s^2 the sum of squared differences from the "
    "mean over n - 1, of the n members that have the number. A member that is not finished has "
    "none, and one without a k-th generation has no ak and tauk."
)
PRODUCTION = "Production"  # title of its sheet
BY_ENERGY = "from the surface energy over Gc and the effective Gc"


def sheets(ensemble: Ensemble) -> tuple[Table, ...]:
    """Return the paper's numbers where a face is cooled, the last step's cracks, and production.

    A row for each seed; below them the mean, its error, and the number of members.
    """
    arrests = {seed: arrest_numbers(run) for seed, run in ensemble.finished.items()}
    ends = {seed: end_numbers(run) for seed, run in ensemble.finished.items()}
    manifest = ensemble.first.manifest
    told = (*arrest_definitions(manifest), tip(manifest), MEANS)
    found = (
        _sheet(ensemble, "Nucleation and arrests", arrests, told),
        _sheet(ensemble, "The last step", ends, _end_notes(ensemble, ends)),
        _sheet(ensemble, PRODUCTION, members_production(ensemble), (*MEMBERS, MEANS)),
    )
    known = tuple(sheet for sheet in found if len(sheet.columns) > 1)
    return with_left_out(known, {f"seed {seed}": run for seed, run in ensemble.runs.items()})


def _sheet(
    ensemble: Ensemble, title: str, found: Mapping[int, Numbers], notes: tuple[str, ...]
) -> Table:
    # Members differ in how many generations they have: the names of most begin with those of all.
    columns = max((tuple(numbers) for numbers in found.values()), key=len, default=())
    rows = [tuple(found.get(seed, {}).get(name) for name in columns) for seed in ensemble.runs]
    averages = [average(column) for column in zip(*rows, strict=True)]
    return Table(
        title=title,
        columns=(Column(name="seed"), *columns),
        rows=tuple((seed, *row) for seed, row in zip(ensemble.runs, rows, strict=True)),
        totals=tuple(
            (name, *(getattr(a, name) for a in averages)) for name in ("mean", "error", "members")
        ),
        notes=notes,
    )


def arrest_definitions(manifest: Manifest) -> tuple[str, ...]:
    """Return sentences on the numbers of nucleation and arrests."""
    if manifest.scaled:
        return definitions(manifest)
    L = manifest.shown.length.text(manifest.L)
    return (f"tau = 2 sqrt(kappa t)/L, L = {L}; tk: the time of tauk.", *GENERATIONS)


def _end_notes(ensemble: Ensemble, found: Mapping[int, Numbers]) -> tuple[str, ...]:
    names = {column.name for numbers in found.values() for column in numbers}
    return (*end_definitions(ensemble.first.manifest, names), MEANS)


def end_definitions(manifest: Manifest, names: Collection[str]) -> tuple[str, ...]:
    """Return sentences on the numbers of the last step.

    Parameters
    ----------
    manifest : description of a member.
    names : names of the columns.
    """
    L = f"L = {manifest.shown.length.text(manifest.L)}"
    over, square = (f" over {L}", f" over L^2, {L}") if manifest.scaled else ("", "")
    told = (
        ("cracks", f"cracks at d: how many cross the depth d below the {manifest.surface}."),
        ("front", f"front: depth of the deepest crack{over}."),
        ("length", f"length: of all cracks{over}, {BY_ENERGY}."),
        ("area", f"area: of all cracks{square}, {BY_ENERGY}."),
    )
    return tuple(text for name, text in told if any(n.startswith(name) for n in names))


def facts(ensemble: Ensemble) -> Iterator[Fact]:
    """Yield the common facts of the members, the number finished, and all alarms."""
    runs = ensemble.runs
    yield from (f for f in summary(ensemble.first) if f.name in ("body", "damage"))
    seeds = ", ".join(str(seed) for seed in runs)
    yield Fact(
        name="members", text=f"{len(ensemble.finished)} of {len(runs)} finished; seeds {seeds}"
    )
    for seed, run in runs.items():
        for fact in summary(run):
            if fact.alarm or (fact.name == "status" and not run.finished):
                yield Fact(name=f"seed {seed}", text=fact.text, alarm=fact.alarm)


def ensemble_title(ensemble: Ensemble) -> str:
    """Return the case's title, or the name of the directory."""
    return ensemble.first.manifest.title or ensemble.path.resolve().name


def write_results(ensemble: Ensemble) -> Path:
    """Write `ensemble.csv`: a row for each seed, then mean, error, and number of members.

    Raises
    ------
    StaffaError
        The directory cannot be written to.
    """
    path = ensemble.path / RESULTS
    try:
        write_aside(path, _joined(ensemble, sheets(ensemble)).csv(digits=6))
    except OSError as error:
        raise StaffaError(
            f"{path} cannot be written: {error.strerror}; copy the ensemble to a folder that you "
            f"may write to"
        ) from None
    return path


def _joined(ensemble: Ensemble, found: Sequence[Table]) -> Table:
    """Return all sheets side by side, with the status of each member."""
    status = [status_text(run) for run in ensemble.runs.values()]
    rows = zip(ensemble.runs, status, *(sheet.rows for sheet in found), strict=True)
    totals = zip(("mean", "error", "members"), *(sheet.totals for sheet in found), strict=True)
    return Table(
        columns=(
            *columns_of("seed", "status"),
            *(column for sheet in found for column in sheet.columns[1:]),
        ),
        rows=tuple(
            (seed, said, *(cell for numbers in cells for cell in numbers[1:]))
            for seed, said, *cells in rows
        ),
        totals=tuple(
            (name, None, *(cell for numbers in cells for cell in numbers[1:]))
            for name, *cells in totals
        ),
    )
