"""Two folders read as a pair of finished runs."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from staffa.case.reading.read import parse_case
from staffa.case.values.subdomains import averages, subdomains_of
from staffa.compare.pair import Pair, Side
from staffa.display_units import Shown, Unit
from staffa.errors import InputError, StaffaError
from staffa.io.ensemble_directory import is_ensemble, members
from staffa.io.own_files import GENERATOR, PAGE
from staffa.io.production_rows import production
from staffa.io.run_directory import CASE, Run, open_run, require_free
from staffa.io.study_refusal import require_no_study
from staffa.plot.production_curves import water_units
from staffa.results.summary import summary


def read_pair(one: Path, other: Path) -> Pair:
    """Read two finished runs.

    Raises
    ------
    InputError
        A folder is no run, its run is damaged or not finished, or both are the same.
    """
    runs = [_finished(path) for path in (one, other)]
    if one.samefile(other):
        raise InputError(f"{one} and {other} are the same run; name two different ones")
    names = [path.resolve().name for path in (one, other)]
    if names[0] == names[1]:
        names = [str(one), str(other)]
    mixed = runs[0].manifest.scaled != runs[1].manifest.scaled
    units = None if mixed else runs[0].manifest.shown
    water = _water_units(runs)
    first, second = (
        replace(_side(name, run, units), water=water) for name, run in zip(names, runs, strict=True)
    )
    return Pair(first=first, second=second, mixed=mixed)


def _water_units(runs: Sequence[Run]) -> dict[str, Unit]:
    """Return the units of the water of the first run that has any."""
    for run in runs:
        if found := production(run.manifest.reservoir, run.steps):
            return water_units(run.manifest, found)
    return {}


def place_of(pair: Pair, asked: Path | None) -> Path:
    """Return the folder of page and pictures: as asked, or below runs/.

    An earlier page may be there.

    Raises
    ------
    InputError
        A run or an ensemble is there, or the folder cannot be made.
    """
    first, second = (side.run.path.resolve().name for side in pair.sides)
    place = asked or Path("runs") / f"{first}-vs-{second}"
    if is_ensemble(place):
        raise InputError(f"--out {place} holds an ensemble; choose another folder")
    require_free(place, ours=_is_beside_a_page)
    return place


def _is_beside_a_page(inside: Path) -> bool:
    """True if a thing lies beside an earlier comparison's page: nothing else is written over."""
    page = inside.with_name(PAGE)
    return page.is_file() and GENERATOR in page.read_text(encoding="utf-8", errors="replace")


def _finished(path: Path) -> Run:
    require_no_study(path, ensembles=False)
    if is_ensemble(path):
        one = next(iter(members(path).values()))
        raise InputError(f"{path} is an ensemble; name one of its runs, like {one}")
    try:
        run = open_run(path)
    except StaffaError as error:
        raise InputError(f"{error}; name another run, or run the case again") from None
    if not run.finished:
        status = next(fact.text for fact in summary(run) if fact.name == "status")
        raise InputError(
            f"the run in {path} is not finished ({status}); let it end, or run the case again"
        )
    return run


def _side(name: str, run: Run, units: Shown | None) -> Side:
    """Return a run counted in units; without any over L and Gc L (in 3-D Gc L^2)."""
    try:
        case = parse_case(run.case, folder=run.path, of_run=True)
    except InputError as error:
        raise InputError(f"{run.path / CASE} is no case that this staffa reads: {error}") from None
    if units:
        length, energy, time = (unit.size for unit in (units.length, units.energy, units.time))
    else:
        length, time, Gc = run.manifest.L, 1.0, averages(subdomains_of(case)[0]).Gc
        energy = Gc * length ** (1 if run.manifest.plane else 2)
    return Side(name=name, run=run, case=case, length=length, energy=energy, time=time)
