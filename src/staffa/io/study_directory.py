"""Layout of a study on disk: an ensemble for each point of its parameters; no finite elements."""

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from staffa.arguments import path_of
from staffa.backend.lock import LOCK, Lock
from staffa.display_units import Unit
from staffa.errors import InputError, StaffaError
from staffa.io.ensemble_directory import Ensemble, is_ensemble, read_ensemble
from staffa.io.own_files import make_folder, write_aside
from staffa.io.run_directory import Run, parsed
from staffa.records.json_form import json_form, made

PLAN, STUDY_RESULTS, STUDY_MEANS = "study.json", "study.csv", "study_means.csv"
STUDY_FORMAT = 1
STUDY_BESIDE = (PLAN, STUDY_RESULTS, STUDY_MEANS, "report.html", "pictures", LOCK)
POINT = re.compile(r"point-([1-9]\d*)")


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """Key of a case that a study varies.

    Attributes
    ----------
    key : its name, as `--set` takes it.
    unit : name of the unit of its values; empty without one.
    """

    key: str
    unit: str = ""

    @property
    def shown(self) -> Unit:
        """Unit in which its values are written and shown."""
        return Unit(name=self.unit)


@dataclass(frozen=True, kw_only=True)
class Point:
    """One choice of all parameters.

    Attributes
    ----------
    number : its number, from 1; its folder is `point-NUMBER`.
    texts : value of each parameter as TOML, in their order.
    values : the same for people: a number in the unit of the parameter, or a text.
    case : SHA-256 of its case, apart from the tables that may change in one run.
    """

    number: int
    texts: tuple[str, ...]
    values: tuple[float | str, ...]
    case: str = ""


@dataclass(frozen=True, kw_only=True)
class StudyPlan:
    """Parameters and points of a study, as `study.json` keeps them.

    Attributes
    ----------
    format : of the study directory.
    version : of the staffa that planned it.
    title : of the case.
    parameters : the keys that it varies.
    points : the choices of their values.
    """

    format: int = STUDY_FORMAT
    version: str
    title: str
    parameters: tuple[Parameter, ...]
    points: tuple[Point, ...]

    def settings(self, point: Point) -> tuple[str, ...]:
        """Return the `section.key=value` settings that make the case of a point."""
        pairs = zip(self.parameters, point.texts, strict=True)
        return tuple(f"{parameter.key}={text}" for parameter, text in pairs)

    @property
    def short(self) -> tuple[str, ...]:
        """Names of the parameters: the ends of their keys, long enough to differ."""
        keys = [parameter.key.split(".") for parameter in self.parameters]
        longest = max((len(key) for key in keys), default=0)
        for length in range(1, longest + 1):
            ends = [".".join(key[-length:]) for key in keys]
            if len(set(ends)) == len(keys):
                break
        return tuple(ends)

    def named(self, point: Point) -> str:
        """Return the parameters of a point in words: "material.Gc 40 J/m²"."""
        pairs = zip(self.parameters, point.values, strict=True)
        return ", ".join(f"{p.key} {_text(value)}{p.shown.behind}" for p, value in pairs)


def _text(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.6g}"


@dataclass(frozen=True, kw_only=True)
class Study:
    """Runs of one case that differ in chosen parameters, and in their seeds.

    Attributes
    ----------
    path : the study's directory.
    plan : its parameters and points.
    ensembles : runs of each point that has started, by its number.
    """

    path: Path
    plan: StudyPlan
    ensembles: dict[int, Ensemble]

    @property
    def first(self) -> Run:
        """First run of the first point that has started."""
        return self.ensembles[min(self.ensembles)].first

    @property
    def started(self) -> Iterator[tuple[Point, Ensemble]]:
        """Points that have started, with their runs."""
        for point in self.plan.points:
            if point.number in self.ensembles:
                yield point, self.ensembles[point.number]

    @property
    def finished(self) -> list[Run]:
        """Finished runs of all points."""
        return [run for _, ensemble in self.started for run in ensemble.finished.values()]


def point_path(path: Path, number: int) -> Path:
    """Return the folder of the runs of a point."""
    return path / f"point-{number}"


def is_study(path: Path) -> bool:
    """Return True for a folder with the plan of a study."""
    return (path / PLAN).is_file()


def has_started(path: Path) -> bool:
    """Return True for the directory of a study of which a run has started."""
    return is_study(path) and bool(_started(path))


def _started(path: Path) -> dict[int, Path]:
    """Return the folders of the points whose runs have started, by their numbers."""
    numbers = [point.number for point in read_plan(path).points]
    places = {number: point_path(path, number) for number in numbers}
    return {number: place for number, place in places.items() if is_ensemble(place)}


def is_of_study(inside: Path) -> bool:
    """Return True for the folder of a point, or a file that a study writes beside them."""
    if not is_study(inside.parent):
        return False
    return inside.name in STUDY_BESIDE or POINT.fullmatch(inside.name) is not None


def read_plan(path: Path) -> StudyPlan:
    """Read the plan of a study.

    Raises
    ------
    InputError
        A later version wrote it.
    StaffaError
        It is damaged.
    """
    file = path / PLAN
    try:
        record = parsed(file.read_text(encoding="utf-8"))
        if isinstance(record, dict) and record.get("format") != STUDY_FORMAT:
            raise InputError(
                f"{file} has format {record.get('format')}, this staffa reads {STUDY_FORMAT}; use "
                f"the staffa that wrote it, {record.get('version')}"
            )
        return made(StudyPlan, record)
    except (OSError, ValueError) as error:
        raise StaffaError(
            f"{file} is damaged ({error}); move the folders of its points to a new study, and give "
            f"its command again"
        ) from None


def write_plan(path: Path, plan: StudyPlan) -> None:
    """Write the plan of a study into its directory, which is made; jobs of an array may do so too.

    Raises
    ------
    StaffaError
        The directory cannot be written to.
    """
    try:
        make_folder(path)
        with Lock(path).held():
            if not (is_study(path) and read_plan(path) == plan):
                write_aside(path / PLAN, json.dumps(json_form(plan), indent=2) + "\n")
    except OSError as error:
        raise StaffaError(
            f"{path} cannot be written to: {error.strerror}; choose another folder with --out"
        ) from None


def read_study(path: str | Path) -> Study:
    """Read the runs of a study that have started, also while others are still to come.

    Raises
    ------
    InputError, StaffaError
        See `read_plan` and `read_ensemble`.
    """
    path = path_of(path, "path")
    plan, started = read_plan(path), _started(path)
    if not started:
        raise InputError(f"no run of the study {path} has started; give its command again")
    return Study(
        path=path,
        plan=plan,
        ensembles={number: read_ensemble(place) for number, place in started.items()},
    )
