"""Numbers of an ensemble: those of each finished member, and their means and errors."""

import csv
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import StringIO

from staffa.display_units import NONE, Unit
from staffa.errors import StaffaError
from staffa.io.ensemble_directory import RESULTS, Ensemble
from staffa.io.own_files import write_aside
from staffa.io.run_directory import Run
from staffa.measure.averages import Average, average
from staffa.records.manifest import Manifest
from staffa.results.slab_table import ABSENT, GENERATIONS, definitions, run_arrests, tip
from staffa.results.summary import Fact, summary

MEANS = (
    "error: standard error of the mean, s/sqrt(n), s^2 the sum of squared differences from the "
    "mean over n - 1, of the n members that have the number. A member that is not finished has "
    "none, and one without a k-th generation has no ak and tauk."
)
BY_ENERGY = "from the surface energy over the effective Gc"
Column = tuple[str, Unit]  # its name, and the unit that its numbers are counted in
Numbers = Mapping[Column, float | None]


@dataclass(frozen=True, kw_only=True)
class Sheet:
    """Table of an ensemble's numbers.

    Attributes
    ----------
    title : its title.
    columns : name and unit of each column.
    rows : numbers of each member by its seed; None for one that it does not have.
    averages : average of each column.
    notes : definitions of the columns.
    """

    title: str
    columns: tuple[Column, ...]
    rows: dict[int, tuple[float | None, ...]]
    averages: tuple[Average, ...]
    notes: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Headings of the columns with units."""
        return tuple(unit.header(name) for name, unit in self.columns)

    @property
    def totals(self) -> dict[str, tuple[float | None, ...]]:
        """Rows below those of the members."""
        return {
            "mean": tuple(a.mean for a in self.averages),
            "error": tuple(a.error for a in self.averages),
            "members": tuple(a.members for a in self.averages),
        }

    def member_lines(self) -> list[tuple[str, ...]]:
        """Return the rows of the members as text: seed, then its numbers."""
        return [(str(seed), *map(number, row)) for seed, row in self.rows.items()]

    def total_lines(self) -> list[tuple[str, ...]]:
        """Return the rows below them as text: name, then its numbers, an error to two digits."""
        digits = {"error": 2}
        return [
            (name, *(number(value, digits.get(name, 4)) for value in row))
            for name, row in self.totals.items()
        ]


def sheets(ensemble: Ensemble) -> tuple[Sheet, ...]:
    """Return the paper's numbers, if a face is cooled, and the measures of the last step."""
    arrests = {seed: _arrests(run) for seed, run in ensemble.finished.items()}
    ends = {seed: _end(run) for seed, run in ensemble.finished.items()}
    manifest = ensemble.first.manifest
    told = (*_definitions(manifest), tip(manifest), MEANS)
    found = (
        _sheet(ensemble, "Nucleation and arrests", arrests, told),
        _sheet(ensemble, "The last step", ends, _end_notes(ensemble, ends)),
    )
    return tuple(sheet for sheet in found if sheet.names)


def _sheet(
    ensemble: Ensemble, title: str, found: Mapping[int, Numbers], notes: tuple[str, ...]
) -> Sheet:
    most = max((len(numbers) for numbers in found.values()), default=0)
    # Members differ in their number of generations: the longest list begins with all others.
    names = next((tuple(numbers) for numbers in found.values() if len(numbers) == most), ())
    rows = {seed: tuple(found.get(seed, {}).get(name) for name in names) for seed in ensemble.runs}
    averages = tuple(average(column) for column in zip(*rows.values(), strict=True))
    return Sheet(title=title, columns=names, rows=rows, averages=averages, notes=notes)


def _arrests(run: Run) -> Numbers:
    """Return a run's line of the paper's table, and times; empty without a cooled face."""
    found, m = run_arrests(run), run.manifest
    if found is None:
        return {}
    start, clock = found.nucleation, m.shown.time
    numbers = _length(m, "p", start.spacing if start else None)
    for k, reached in enumerate((start, *found.generations)):
        numbers |= _length(m, f"a{k}", reached.depth if reached else None)
        if not m.scaled:
            numbers[f"t{k}", clock] = clock.of(reached.time) if reached else None
        numbers[f"tau{k}", NONE] = reached.tau if reached else None
    return numbers


def _length(manifest: Manifest, name: str, value: float | None) -> dict[Column, float | None]:
    """Return a column of a length (m): over L in a scaled case."""
    unit = Unit(size=manifest.L) if manifest.scaled else manifest.shown.length
    return {(name, unit): None if value is None else unit.of(value)}


def _definitions(manifest: Manifest) -> tuple[str, ...]:
    if manifest.scaled:
        return definitions(manifest)
    L = manifest.shown.length.text(manifest.L)
    return (f"tau = 2 sqrt(kappa t)/L, L = {L}; tk: the time of tauk.", *GENERATIONS)


def _end(run: Run) -> Numbers:
    """Return the measures of the last step: cracks at each depth, then lengths and areas.

    They are in the units of the case; in a scaled case over L and L^2.
    """
    measures, manifest = run.steps[-1].measures, run.manifest
    if measures is None:
        return {}
    found: dict[Column, float | None] = {
        (f"cracks at {manifest.shown.length.text(section.height, 6)}", NONE): section.cracks
        for section in measures.sections
    }
    if manifest.face:
        found |= _length(manifest, "front", manifest.deepest(measures))
    name, power = ("length", 1) if manifest.plane else ("area", 2)
    unit = Unit(size=manifest.L**power) if manifest.scaled else manifest.shown.crack
    return found | {(name, unit): unit.of(measures.length_surface)}


def _end_notes(ensemble: Ensemble, found: Mapping[int, Numbers]) -> tuple[str, ...]:
    names = {name for numbers in found.values() for name, _ in numbers}
    manifest = ensemble.first.manifest
    L = f"L = {manifest.shown.length.text(manifest.L)}"
    over, square = (f" over {L}", f" over L^2, {L}") if manifest.scaled else ("", "")
    told = (
        ("cracks", f"cracks at d: how many cross the depth d below the {manifest.surface}."),
        ("front", f"front: depth of the deepest crack{over}."),
        ("length", f"length: of all cracks{over}, {BY_ENERGY}."),
        ("area", f"area: of all cracks{square}, {BY_ENERGY}."),
    )
    return (*(text for name, text in told if any(n.startswith(name) for n in names)), MEANS)


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


def write_results(ensemble: Ensemble) -> None:
    """Write `ensemble.csv`: a row for each seed, then mean, error, and number of members.

    Raises
    ------
    StaffaError
        The directory cannot be written to.
    """
    try:
        write_aside(ensemble.path / RESULTS, as_csv(ensemble, sheets(ensemble)))
    except OSError as error:
        raise StaffaError(
            f"{ensemble.path / RESULTS} cannot be written: {error.strerror}; copy the ensemble to "
            f"a folder that you may write to"
        ) from None


def as_csv(ensemble: Ensemble, found: Sequence[Sheet]) -> str:
    """Return all sheets side by side as CSV, to six digits; a missing number is empty."""
    text = StringIO()
    rows = csv.writer(text, lineterminator="\n")
    names = (unit.column(name) for sheet in found for name, unit in sheet.columns)
    rows.writerow(["seed", "status", *names])
    for seed, run in ensemble.runs.items():
        status = next(fact.text for fact in summary(run) if fact.name == "status")
        rows.writerow([seed, status, *(_digits(v) for sheet in found for v in sheet.rows[seed])])
    for name in ("mean", "error", "members"):
        rows.writerow([name, "", *(_digits(v) for sheet in found for v in sheet.totals[name])])
    return text.getvalue()


def number(value: float | None, digits: int = 4) -> str:
    """Return a cell of a table as text: integers as they are, others to some digits."""
    if value is None:
        return ABSENT
    return str(value) if isinstance(value, int) else f"{value:.{digits}g}"


def _digits(value: float | None) -> str:
    return "" if value is None else f"{value:.6g}"
