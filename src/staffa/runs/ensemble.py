"""Ensembles: one run a seed."""

from pathlib import Path
from typing import Any

from staffa.backend.lock import Lock
from staffa.case.reading.read import read_case
from staffa.case.schema.case import Case
from staffa.case.schema.material_keys import RockKeys
from staffa.case.schema.property_keys import RandomField
from staffa.case.schema.reservoir_keys import ReservoirKeys
from staffa.case.schema.toml_text import to_toml
from staffa.errors import InputError, StaffaError
from staffa.io import run_directory
from staffa.io.ensemble_directory import OWN, is_of_ensemble, member_path, members
from staffa.records.case_about import ABOUT
from staffa.runs.member_runs import Member, require_number

LARGEST_SEED = 2**32 - 1  # as in the case file: NumPy's largest


def seeds_from(case: Case, *, count: int, first: int | None = None) -> range:
    """Return the seeds of an ensemble.

    Parameters
    ----------
    case : the case.
    count : number of seeds.
    first : first seed; None for the case's own.

    Raises
    ------
    InputError
        The case is not random, or the seeds are out of range.
    """
    if not _is_random(case):
        raise InputError(
            "toughness.amplitude = 0: every seed would give the same rock; give an amplitude, "
            "like --set toughness.amplitude=0.05, or run the case once with `staffa run`"
        )
    if count < 2:
        raise InputError(
            f"--seeds {count}: an error of the mean needs at least 2 members; take more seeds, or "
            f"run the case once with `staffa run`"
        )
    return seed_range(case, count=count, first=first)


def seed_range(case: Case, *, count: int, first: int | None) -> range:
    """Return consecutive seeds, of a case that need not be random.

    Parameters
    ----------
    case : the case.
    count : number of seeds.
    first : first seed; None for the case's own.

    Raises
    ------
    InputError
        A seed is out of range.
    """
    begin = case.toughness.seed if first is None else first
    if begin < 0:
        raise InputError(f"--first {begin}: a seed must be at least 0; begin at 0 or later")
    if begin + count - 1 > LARGEST_SEED:
        raise InputError(
            f"--seeds {count} from seed {begin} ends at seed {begin + count - 1}, and the largest "
            f"is {LARGEST_SEED}; begin lower with --first, or take fewer"
        )
    return range(begin, begin + count)


def member(case: Case, seed: int) -> Case:
    """Return the case with another seed of [toughness].

    The seeds of its random properties, of the reservoir too, increase by the same amount.
    """
    shift = seed - case.toughness.seed
    return case.model_copy(
        update={
            "toughness": case.toughness.model_copy(update={"seed": seed}),
            "material": _reseeded(case.material, shift),
            "regions": {name: _reseeded(keys, shift) for name, keys in case.regions.items()},
            "reservoir": _reseeded(case.reservoir, shift),
        }
    )


def _is_random(case: Case) -> bool:
    rocks = (case.material, *case.regions.values(), case.reservoir)
    return case.toughness.amplitude > 0 or any(_reseeded(keys, 1) != keys for keys in rocks)


def _reseeded(value: Any, shift: int) -> Any:
    """Return a value with other seeds in all of its random fields."""
    if isinstance(value, RandomField):
        return value.model_copy(update={"seed": (value.seed + shift) % (LARGEST_SEED + 1)})
    if isinstance(value, tuple):
        return tuple(_reseeded(item, shift) for item in value)
    if isinstance(value, RockKeys | ReservoirKeys):
        keys = {name: _reseeded(getattr(value, name), shift) for name in value.model_fields_set}
        return value.model_copy(update=keys)
    return value


def started_members(
    case: Case, seeds: range, directory: Path, *, only: int | None = None
) -> dict[int, bool]:
    """Return the seeds whose runs are in the directory, and True for each that is finished.

    A run that another process is just beginning has started.

    Parameters
    ----------
    case : the case of the ensemble.
    seeds : seeds of its members.
    directory : directory of the ensemble.
    only : the one seed whose folder is looked at; None for all.

    Raises
    ------
    InputError
        A folder with a member's name cannot be one of this ensemble.
    """
    run_directory.require_free(directory, ours=is_of_ensemble)
    started = {}
    for seed, place in members(directory).items():
        if only not in (None, seed):
            continue
        if place.is_symlink():
            raise InputError(
                f"{place} is a symbolic link, which is not followed; remove it, or put there what "
                f"it leads to"
            )
        if not (place / run_directory.MANIFEST).is_file() and Lock(place).is_held():
            started[seed] = False
            continue
        if not (place / run_directory.CASE).is_file():
            if seed in seeds:
                run_directory.require_free(place)
            continue
        if not _is_of(member(case, seed), place):
            raise InputError(
                f"--out {directory} holds a run of another case, {place.name}; choose another "
                f"folder, or move that run elsewhere"
            )
        if seed in seeds:
            started[seed] = _is_finished(place)
    return started


def _is_of(case: Case, place: Path) -> bool:
    """Return True if a run is of this case.

    Changes that `staffa resume` may make in one member do not count, nor what tells of the case
    only, nor keys that were left out and have today's default.
    """
    try:
        if run_directory.read_case_text(place) == to_toml(case):
            return True
        found = read_case(place / run_directory.CASE)
    except StaffaError:
        return False
    own = {name: getattr(case, name) for name in (*OWN, *ABOUT)}
    return to_toml(found.model_copy(update=own)) == to_toml(case)


def _is_finished(place: Path) -> bool:
    if not (place / run_directory.MANIFEST).is_file():
        raise InputError(
            f"{place} holds a run that was cut before it began; if no process writes to it, remove "
            f"it, and it is run again, or choose seeds without it with --first"
        )
    return run_directory.open_run(place).finished


def ensemble_members(
    case: Case, seeds: range, directory: Path, *, only: int | None = None
) -> tuple[Member, ...]:
    """Return the members of an ensemble, one a seed.

    Parameters
    ----------
    case : the case of the ensemble.
    seeds : seeds of its members.
    directory : directory of the ensemble.
    only : number of the one member whose folder is looked at, from 1; None for all.

    Raises
    ------
    InputError
        The directory cannot be used, see `started_members`, or there is no such member.
    """
    require_number(only, len(seeds))
    seed = None if only is None else seeds[only - 1]
    started = started_members(case, seeds, directory, only=seed)
    return tuple(
        Member(
            number=number,
            label=f"seed {seed}",
            case=member(case, seed),
            place=member_path(directory, seed),
            finished=started.get(seed),
            warns=number == 1,
        )
        for number, seed in enumerate(seeds, start=1)
    )
