"""Studies: an ensemble for each point of chosen parameters."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from staffa.case.reading.study_points import LARGEST_STUDY
from staffa.case.rules import require_loaded
from staffa.case.schema.case import Case
from staffa.case.schema.toml_text import to_toml
from staffa.errors import InputError
from staffa.io import run_directory
from staffa.io.ensemble_directory import member_path
from staffa.io.study_directory import (
    Parameter,
    Point,
    StudyPlan,
    is_of_study,
    is_study,
    point_identity,
    point_path,
    read_plan,
)
from staffa.runs.ensemble import member, seed_range, seeds_from, started_members
from staffa.runs.member_runs import Member, require_number
from staffa.runs.provenance import version


def planned_study(
    read: Callable[[Sequence[str]], Case],
    parameters: Sequence[Parameter],
    points: Sequence[Point],
    directory: Path,
    *,
    count: int = 1,
    first: int | None = None,
    only: int | None = None,
) -> tuple[StudyPlan, tuple[Member, ...]]:
    """Check every case of a study, and return its plan and its members; nothing is written.

    A study that is in the directory already is extended: its points keep their numbers. Members
    come point after point with the first seed, then with the next one.

    Parameters
    ----------
    read : function of settings that returns the case with them.
    parameters : the keys that the study varies.
    points : the choices of their values.
    directory : directory of the study.
    count : number of seeds of each point.
    first : first seed; None for that of the case.
    only : number of the one member whose folder is looked at, from 1; None for all.

    Raises
    ------
    InputError
        A case is wrong, the directory cannot be used, it holds a study of another case, or there
        is no such member.
    """
    if count < 1:
        raise InputError(f"--seeds {count}: each point needs at least 1 seed")
    if len(points) * count > LARGEST_STUDY:
        raise InputError(
            f"{len(points)} points of {count} seeds are {len(points) * count:,} runs, and a study "
            f"has at most {LARGEST_STUDY:,}; give fewer values or fewer seeds"
        )
    run_directory.require_free(directory, ours=is_of_study)
    plan = StudyPlan(version=version(), title="", parameters=tuple(parameters), points=())
    cases = [_checked(read, plan.settings(point)) for point in points]
    named = [
        replace(point, case=point_identity(to_toml(case)))
        for point, case in zip(points, cases, strict=True)
    ]
    plan = replace(plan, title=cases[0].title)
    known = read_plan(directory) if is_study(directory) else replace(plan, points=())
    plan, chosen = _extended(known, plan.parameters, named, directory)
    return plan, _members(plan, chosen, cases, directory, count, first, only)


def _checked(read: Callable[[Sequence[str]], Case], settings: Sequence[str]) -> Case:
    case = read(settings)
    require_loaded(case)
    return case


def _extended(
    known: StudyPlan, parameters: tuple[Parameter, ...], points: Sequence[Point], directory: Path
) -> tuple[StudyPlan, list[Point]]:
    """Return the plan with these points too, and the points with the numbers that they have in it.

    Parameters
    ----------
    known : the plan so far.
    parameters : the keys that these points vary.
    points : points of the command.
    directory : directory of the study.
    """
    if known.parameters != parameters:
        keys = ", ".join(one.shown.header(one.key) for one in known.parameters)
        raise InputError(
            f"--out {directory} holds a study over {keys}; choose another folder for other "
            f"parameters or units"
        )
    earlier = {point.texts: point for point in known.points}
    found: list[Point] = []
    for point in points:
        before = earlier.get(point.texts)
        if before is None:
            before = replace(point, number=len(earlier) + 1)
            earlier[point.texts] = before
        elif before.case != point.case and _are_comparable(known, before):
            raise InputError(
                f"--out {directory} holds a study of another case, see its point "
                f"{before.number}; choose another folder"
            )
        found.append(before)
    return replace(known, points=tuple(earlier.values())), found


def _are_comparable(known: StudyPlan, point: Point) -> bool:
    """Return True if today's staffa would have noted the case of a point as it is noted.

    Another version may have other keys with other defaults: the cases of its runs are compared when
    they are looked for.
    """
    return known.version == version() and point.has_identity


def _members(
    plan: StudyPlan,
    points: Sequence[Point],
    cases: Sequence[Case],
    directory: Path,
    count: int,
    first: int | None,
    only: int | None,
) -> tuple[Member, ...]:
    """Return the members of these points: of all points with one seed, then with the next one."""
    found: list[Member] = []
    seeds = [_seeds(case, count, first) for case in cases]
    places = [point_path(directory, point.number) for point in points]
    require_number(only, len(points) * count)
    if only is None:
        started = [_started(*of) for of in zip(cases, seeds, places, strict=True)]
    else:
        turn, k = divmod(only - 1, len(points))
        started = [{} for _ in points]
        started[k] = _started(cases[k], seeds[k], places[k], seeds[k][turn])
    for turn in range(count):
        for point, case, of, place, known in zip(
            points, cases, seeds, places, started, strict=True
        ):
            seed = of[turn]
            found.append(
                Member(
                    number=len(found) + 1,
                    label=f"point {point.number}" + (f", seed {seed}" if count > 1 else ""),
                    case=member(case, seed),
                    place=member_path(place, seed),
                    finished=known.get(seed),
                    warns=turn == 0,
                    said=plan.named(point),
                )
            )
    return tuple(found)


def _started(case: Case, seeds: range, place: Path, only: int | None = None) -> dict[int, bool]:
    """Return the seeds of a point whose runs have started, see `started_members`."""
    if place.is_symlink():
        raise InputError(f"{place} is a symbolic link, which is not followed; remove it")
    return started_members(case, seeds, place, only=only)


def _seeds(case: Case, count: int, first: int | None) -> range:
    """Return the seeds of a point; one seed asks for no chance."""
    seeds = seeds_from if count > 1 else seed_range
    return seeds(case, count=count, first=first)
