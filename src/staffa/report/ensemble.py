"""The numbers of an ensemble: those of each finished member, and their means and errors."""

import csv
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from io import StringIO

from staffa.errors import StaffaError
from staffa.io.ensemble_directory import RESULTS, Ensemble
from staffa.io.run_directory import Run, write_aside
from staffa.measure.averages import Average, average
from staffa.report.comparison import ABSENT, definitions, own_line, run_arrests, tip
from staffa.report.summary import Fact, summary

MEANS = (
    "error: standard error of the mean, s/sqrt(n), s^2 the sum of squared differences from the "
    "mean over n - 1, of the n members that have the number. A member that is not finished has "
    "none, and one without a k-th generation has no ak and tauk."
)
BY_ENERGY = "from the surface energy over Gc and the discrete toughness"
Numbers = Mapping[str, float | None]


@dataclass(frozen=True, kw_only=True)
class Sheet:
    """A table of numbers: a row for each seed, and the average of each column."""

    title: str
    names: tuple[str, ...]
    rows: dict[int, tuple[float | None, ...]]
    averages: tuple[Average, ...]
    notes: tuple[str, ...]

    @property
    def totals(self) -> dict[str, tuple[float | None, ...]]:
        """The rows below those of the members."""
        return {
            "mean": tuple(a.mean for a in self.averages),
            "error": tuple(a.error for a in self.averages),
            "members": tuple(a.members for a in self.averages),
        }

    def member_lines(self) -> list[tuple[str, ...]]:
        """The rows of the members as text: seed, then its numbers."""
        return [(str(seed), *map(number, row)) for seed, row in self.rows.items()]

    def total_lines(self) -> list[tuple[str, ...]]:
        """The rows below them as text: name, then its numbers, an error to two digits."""
        digits = {"error": 2}
        return [
            (name, *(number(value, digits.get(name, 4)) for value in row))
            for name, row in self.totals.items()
        ]


def sheets(ensemble: Ensemble) -> tuple[Sheet, ...]:
    """The paper's numbers where a face is cooled, and the crack network of the last step."""
    arrests = {seed: _arrests(run) for seed, run in ensemble.finished.items()}
    ends = {seed: _end(run) for seed, run in ensemble.finished.items()}
    told = (*definitions(ensemble.first.manifest), tip(ensemble.first.manifest), MEANS)
    found = (
        _sheet(ensemble, "Nucleation and arrests", arrests, told),
        _sheet(ensemble, "The last step", ends, _end_notes(ensemble, ends)),
    )
    return tuple(sheet for sheet in found if sheet.names)


def _sheet(
    ensemble: Ensemble, title: str, found: Mapping[int, Numbers], notes: tuple[str, ...]
) -> Sheet:
    most = max((len(numbers) for numbers in found.values()), default=0)
    # Members differ in how many generations they have: the names of most begin with those of all.
    names = next((tuple(numbers) for numbers in found.values() if len(numbers) == most), ())
    rows = {seed: tuple(found.get(seed, {}).get(name) for name in names) for seed in ensemble.runs}
    averages = tuple(average(column) for column in zip(*rows.values(), strict=True))
    return Sheet(title=title, names=names, rows=rows, averages=averages, notes=notes)


def _arrests(run: Run) -> Numbers:
    """The run's line of the paper's table, by name; nothing without a cooled face."""
    found = run_arrests(run)
    if found is None:
        return {}
    line = own_line(found, run.manifest)
    pairs = enumerate(zip(line.depths, line.taus, strict=True))
    return {"p": line.spacing} | {
        name: value for k, (a, tau) in pairs for name, value in ((f"a{k}", a), (f"tau{k}", tau))
    }


def _end(run: Run) -> Numbers:
    """The measures of the last step: cracks at each depth, then lengths over L, areas over L^2."""
    measures, manifest = run.steps[-1].measures, run.manifest
    if measures is None:
        return {}
    plane = len(manifest.size) == 2
    found: dict[str, float | None] = {
        f"cracks at {manifest.shown.length.text(section.height, 6)}": section.cracks
        for section in measures.sections
    }
    if manifest.face:
        found["front"] = manifest.deepest(measures) / manifest.L
    size = manifest.L if plane else manifest.L**2
    return found | {"length" if plane else "area": measures.length_surface / size}


def _end_notes(ensemble: Ensemble, found: Mapping[int, Numbers]) -> tuple[str, ...]:
    names = {name for numbers in found.values() for name in numbers}
    manifest = ensemble.first.manifest
    L = f"L = {manifest.shown.length.text(manifest.L)}"
    told = (
        ("cracks", f"cracks at d: how many cross the depth d below the {manifest.surface}."),
        ("front", f"front: depth of the deepest crack over {L}."),
        ("length", f"length: of all cracks over {L}, {BY_ENERGY}."),
        ("area", f"area: of all cracks over L^2, {L}, {BY_ENERGY}."),
    )
    return (*(text for name, text in told if any(n.startswith(name) for n in names)), MEANS)


def facts(ensemble: Ensemble) -> Iterator[Fact]:
    """What the members share, how many are finished, and what is wrong with any of them."""
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
    """The case's title, or the name of the directory."""
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
    """All sheets side by side, to six digits; an empty cell where there is no number."""
    text = StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(["seed", "status", *(name for sheet in found for name in sheet.names)])
    for seed, run in ensemble.runs.items():
        status = next(fact.text for fact in summary(run) if fact.name == "status")
        rows.writerow([seed, status, *(_digits(v) for sheet in found for v in sheet.rows[seed])])
    for name in ("mean", "error", "members"):
        rows.writerow([name, "", *(_digits(v) for sheet in found for v in sheet.totals[name])])
    return text.getvalue()


def number(value: float | None, digits: int = 4) -> str:
    """A cell of a table: whole numbers whole."""
    if value is None:
        return ABSENT
    return str(value) if isinstance(value, int) else f"{value:.{digits}g}"


def _digits(value: float | None) -> str:
    return "" if value is None else f"{value:.6g}"
