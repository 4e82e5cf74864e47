"""Numbers of a study: those of each run, and means and errors of each point."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

from staffa.display_units import NONE
from staffa.io.run_directory import Run
from staffa.io.study_directory import Parameter, Point, Study
from staffa.measure.averages import Average, average
from staffa.results.ensemble_means import arrest_definitions, end_definitions
from staffa.results.facts import Fact
from staffa.results.member_numbers import (
    Numbers,
    arrest_numbers,
    end_numbers,
    energy_numbers,
    status_text,
    with_left_out,
)
from staffa.results.members_production import MEMBERS, water_numbers
from staffa.results.slab_table import tip
from staffa.results.summary import summary
from staffa.results.tables import Cell, Column, Table, columns_of, number

# Title of each sheet, and the numbers of a run on it.
GROUPS: dict[str, Callable[[Run], Numbers]] = {
    "Nucleation and arrests": arrest_numbers,
    "The last step": end_numbers,
    "Energies at the end": energy_numbers,
    "Production": water_numbers,
}
NOTE = (
    "Mean ± standard error of the mean, s/sqrt(n), over the finished runs of a point that have the "
    "number; without ± there is one. study.csv has each run."
)


@dataclass(frozen=True, kw_only=True)
class Group:
    """Numbers of one kind, of all finished runs.

    Attributes
    ----------
    title : title of their sheet.
    columns : their names and units.
    rows : numbers of each finished run, by point and seed.
    """

    title: str
    columns: tuple[Column, ...]
    rows: dict[tuple[int, int], tuple[float | None, ...]]

    def of_point(self, point: Point) -> list[list[float]]:
        """Return the values that the runs of a point have, by column."""
        rows = [row for (of, _), row in self.rows.items() if of == point.number]
        return [
            [value for row in rows if (value := row[k]) is not None]
            for k in range(len(self.columns))
        ]

    def averages(self, point: Point) -> list[Average]:
        """Return mean and error of each column, of a point."""
        return [average(values) for values in self.of_point(point)]


@lru_cache(maxsize=1)
def groups(study: Study) -> tuple[Group, ...]:
    """Return the numbers of the finished runs, by kind; no kind that no run has.

    Tables, pictures and the page of a study need them: they are computed once.
    """
    found = (_group(study, title, of) for title, of in GROUPS.items())
    return tuple(group for group in found if group.columns)


def _group(study: Study, title: str, of: Callable[[Run], Numbers]) -> Group:
    known = {
        (point.number, seed): {column.name: (column, value) for column, value in of(run).items()}
        for point, ensemble in study.started
        for seed, run in ensemble.finished.items()
    }
    # Points differ in how many generations they have: the names of most begin with those of all.
    columns: dict[str, Column] = {}
    for numbers in sorted(known.values(), key=len, reverse=True):
        for name, (column, _) in numbers.items():
            unit = column.unit if column.unit.name else NONE
            columns.setdefault(name, Column(name=name, unit=unit, label=column.label))
    rows = {
        key: tuple(_cell(*numbers.get(name, (column, None))) for name, column in columns.items())
        for key, numbers in known.items()
    }
    return Group(title=title, columns=tuple(columns.values()), rows=rows)


def _cell(column: Column, value: float | None) -> float | None:
    """Return a number in SI units; of a scaled case as it is shown, over the L of its run."""
    if value is None or column.unit.name or isinstance(value, int):
        return value
    return column.unit.of(value)


def study_table(study: Study) -> Table:
    """Return study.csv: a row for each run, its parameters in their units, then its numbers."""
    found = groups(study)
    empty = {group.title: (None,) * len(group.columns) for group in found}
    rows: list[tuple[Cell, ...]] = []
    for point, ensemble in study.started:
        for seed, run in ensemble.runs.items():
            cells: list[Cell] = [point.number, seed, status_text(run), *point.values]
            for group in found:
                cells += group.rows.get((point.number, seed), empty[group.title])
            rows.append(tuple(cells))
    return Table(
        columns=(
            *columns_of("point", "seed", "status"),
            *_parameter_columns(study),
            *(column for group in found for column in group.columns),
        ),
        rows=tuple(rows),
    )


def study_means(study: Study) -> Table:
    """Return study_means.csv: a row for each point, its parameters, then means and errors."""
    found = groups(study)
    rows: list[tuple[Cell, ...]] = []
    for point, ensemble in study.started:
        cells: list[Cell] = [point.number, len(ensemble.finished), *point.values]
        for group in found:
            cells += [cell for a in group.averages(point) for cell in (a.mean, a.error)]
        rows.append(tuple(cells))
    return Table(
        columns=(
            *columns_of("point", "members"),
            *_parameter_columns(study),
            *(
                Column(name=f"{column.name}{ending}", unit=column.unit)
                for group in found
                for column in group.columns
                for ending in ("", "_error")
            ),
        ),
        rows=tuple(rows),
    )


def _parameter_columns(study: Study) -> tuple[Column, ...]:
    return tuple(Column(name=one.key, unit=one.shown) for one in study.plan.parameters)


def study_sheets(study: Study) -> tuple[Table, ...]:
    """Return the tables for people, a row for each point: means with errors."""
    runs = {f"point {point}, seed {seed}": run for (point, seed), run in study.runs.items()}
    found = tuple(
        Table(
            title=group.title,
            columns=(
                Column(name="point"),
                *(
                    Column(name=short, unit=one.shown)
                    for short, one in zip(study.plan.short, study.plan.parameters, strict=True)
                ),
                Column(name="runs"),
                *(Column(name=column.heading) for column in group.columns),
            ),
            rows=tuple(_row(group, point, len(of.finished)) for point, of in study.started),
            notes=(*_notes(study, group), NOTE),
        )
        for group in map(_known, groups(study))
        if group.columns
    )
    return with_left_out(found, runs)


def _known(group: Group) -> Group:
    """Return a group without the columns of which no run has a number."""
    kept = [
        k
        for k in range(len(group.columns))
        if any(row[k] is not None for row in group.rows.values())
    ]
    return replace(
        group,
        columns=tuple(group.columns[k] for k in kept),
        rows={key: tuple(row[k] for k in kept) for key, row in group.rows.items()},
    )


def _row(group: Group, point: Point, count: int) -> tuple[Cell, ...]:
    pairs = zip(group.columns, group.averages(point), strict=True)
    return (point.number, *point.values, count, *(_text(column, found) for column, found in pairs))


def _text(column: Column, found: Average) -> Cell:
    """Return mean and error in words: "0.157 ± 0.004"."""
    if found.mean is None:
        return None
    mean = number(column.unit.of(found.mean))
    return mean if found.error is None else f"{mean} ± {number(found.error / column.unit.size, 2)}"


def _notes(study: Study, group: Group) -> tuple[str, ...]:
    manifest = study.first.manifest
    if group.title == "Nucleation and arrests":
        return (*arrest_definitions(manifest), tip(manifest))
    if group.title == "The last step":
        return end_definitions(manifest, [column.name for column in group.columns])
    return MEMBERS[1:] if any("change" in column.name for column in group.columns) else ()


def study_facts(study: Study) -> Iterator[Fact]:
    """Yield the parameters of a study, how many of its runs are finished, and all alarms."""
    for k, parameter in enumerate(study.plan.parameters):
        yield Fact(name=parameter.key, text=_range(parameter, study.plan.points, k))
    runs = sum(len(ensemble.runs) for _, ensemble in study.started)
    started, points = len(study.ensembles), len(study.plan.points)
    text = (
        f"{started} of {points} points have started; {len(study.finished)} of {runs} runs finished"
    )
    yield Fact(name="points", text=text)
    for point in study.of_another_case:
        text = "its runs are of another case than the study's"
        yield Fact(name=f"point {point.number}", text=text, alarm=True)
    for point, ensemble in study.started:
        for seed, run in ensemble.runs.items():
            for fact in summary(run):
                if fact.alarm or (fact.name == "status" and not run.finished):
                    name = f"point {point.number}, seed {seed}"
                    yield Fact(name=name, text=fact.text, alarm=fact.alarm)


def _range(parameter: Parameter, points: Sequence[Point], k: int) -> str:
    """Return the values of a parameter in words: "40 to 100 J/m², 7 values"."""
    values = dict.fromkeys(point.values[k] for point in points)
    numbers = [value for value in values if not isinstance(value, str)]
    if len(numbers) < max(len(values), 5):
        told = ", ".join(number(value) for value in values)
        return f"{told}{parameter.shown.behind}"
    low, high = number(min(numbers)), number(max(numbers))
    return f"{low} to {high}{parameter.shown.behind}, {len(numbers)} values"


def study_title(study: Study) -> str:
    """Return the case's title, or the name of the directory."""
    return f"Study: {study.plan.title or study.path.resolve().name}"
