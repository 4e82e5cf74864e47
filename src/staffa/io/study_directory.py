"""Layout of a study on disk: an ensemble for each point of its parameters; no finite elements."""

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

from staffa.arguments import path_of
from staffa.backend.lock import LOCK, Lock
from staffa.display_units import Unit
from staffa.errors import InputError, StaffaError
from staffa.io.ensemble_directory import Ensemble, is_ensemble, read_ensemble, shared_part
from staffa.io.own_files import make_folder, write_aside
from staffa.io.run_directory import Run, parsed
from staffa.records.json_form import json_form, made

PLAN, STUDY_RESULTS, STUDY_MEANS = "study.json", "study.csv", "study_means.csv"
STUDY_FORMAT = 1
STUDY_BESIDE = (PLAN, STUDY_RESULTS, STUDY_MEANS, "report.html", "pictures", LOCK)
IDENTITY = "sha256:"  # before the digits
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
    case : see `point_identity`.
    """

    number: int
    texts: tuple[str, ...]
    values: tuple[float | str, ...]
    case: str = ""

    @property
    def has_identity(self) -> bool:
        """True if its case is noted in today's form."""
        return self.case.startswith(IDENTITY)


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


@dataclass(frozen=True, kw_only=True, eq=False)
class Study:
    """Runs of one case that differ in chosen parameters, and in their seeds.

    It is equal to itself alone: one that is read again may have more steps.

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
    def runs(self) -> dict[tuple[int, int], Run]:
        """All runs that have started, by point and seed."""
        of = self.ensembles.items()
        return {(k, seed): run for k, ensemble in of for seed, run in ensemble.runs.items()}

    @property
    def started(self) -> Iterator[tuple[Point, Ensemble]]:
        """Points that have started, with their runs."""
        for point in self.plan.points:
            if point.number in self.ensembles:
                yield point, self.ensembles[point.number]

    @property
    def of_another_case(self) -> list[Point]:
        """Points whose runs are not of the case that the plan has of them.

        Runs of another version are not compared: it may write other defaults.
        """
        return [
            point
            for point, ensemble in self.started
            if point.has_identity
            and ensemble.first.manifest.version == self.plan.version
            and point_identity(ensemble.first.case) != point.case
        ]

    @property
    def finished(self) -> list[Run]:
        """Finished runs of all points."""
        return [run for _, ensemble in self.started for run in ensemble.finished.values()]


def point_identity(text: str) -> str:
    """Return the SHA-256 of the part of a case that all runs of a point share, from its TOML."""
    shared = json.dumps(shared_part(text), sort_keys=True, default=str)
    return IDENTITY + sha256(shared.encode()).hexdigest()


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


def write_plan(path: Path, plan: StudyPlan) -> str | None:
    """Write the plan of a study, which keeps every point that another command has added meanwhile.

    The directory is made. Nothing is written if the plan there has all of these points: jobs of an
    array only read it.

    Returns
    -------
    str or None
        A sentence if it was written without a lock.

    Raises
    ------
    InputError
        Another command has added other points.
    StaffaError
        The directory cannot be written to.
    """
    if _has_all(path, plan):
        return None
    try:
        make_folder(path)
        with Lock(path).held() as alone:
            if _has_all(path, plan):
                return None
            if is_study(path) and not _begins_with(plan, read_plan(path)):
                raise InputError(
                    f"another command has added points to {path} meanwhile; give this one again"
                )
            write_aside(path / PLAN, json.dumps(json_form(plan), indent=2) + "\n")
        return None if alone else f"{path} has no lock: add points with one command at a time"
    except OSError as error:
        raise StaffaError(
            f"{path} cannot be written to: {error.strerror}; choose another folder with --out"
        ) from None


def _has_all(path: Path, plan: StudyPlan) -> bool:
    """Return True if there is a plan with the points of this one, and perhaps more."""
    return is_study(path) and _begins_with(read_plan(path), plan)


def _begins_with(plan: StudyPlan, other: StudyPlan) -> bool:
    """Return True if a plan has the points of another one, with their numbers."""
    seen = {(point.number, point.texts) for point in plan.points}
    return plan.parameters == other.parameters and seen.issuperset(
        (point.number, point.texts) for point in other.points
    )


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
