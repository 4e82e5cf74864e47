"""Versions of the programs that made a run, and the command that repeats it."""

from collections.abc import Collection, Mapping
from math import prod
from pathlib import Path
from shlex import quote

from staffa.compare.pair import Pair
from staffa.io.ensemble_directory import Ensemble
from staffa.io.run_directory import CASE, Run
from staffa.io.study_directory import Study
from staffa.results.tables import Table, columns_of

Repeated = tuple[tuple[str, str], ...]  # sentences, each with a command below, or none
HERE = "In the folder of this page:"
AGAIN = "../again"


def versions_table(runs: Mapping[str, Run]) -> Table:
    """Return the versions of the programs of runs, a column for each.

    Parameters
    ----------
    runs : the runs by the heading of their column.
    """
    known = [_programs(run) for run in runs.values()]
    names = dict.fromkeys(name for programs in known for name in programs)
    return Table(
        title="Versions",
        columns=columns_of("program", *runs),
        rows=tuple((name, *(programs.get(name) for programs in known)) for name in names),
    )


def run_again(run: Run) -> Repeated:
    """Return how to repeat a run."""
    return _again(run, f"run {CASE}")


def _again(run: Run, command: str) -> Repeated:
    """Return how to repeat a command of staffa, as on the ranks of a run."""
    if run.manifest.own:
        given = ", ".join(run.manifest.own)
        return ((f"A script gave what no case file has ({given}): start this script again.", ""),)
    ranks = run.manifest.ranks
    launcher = f"mpiexec -n {ranks} " if ranks > 1 else ""
    return ((HERE, f"{launcher}staffa {command} --out {AGAIN}"),)


def ensemble_again(ensemble: Ensemble) -> Repeated:
    """Return how to repeat an ensemble."""
    first, count = min(ensemble.runs), len(ensemble.runs)
    if count == 1:
        return _again(ensemble.first, f"run {quote(ensemble.first.path.name)}/{CASE}")
    if not _is_one_range(ensemble.runs):
        return ((_not_one_range(ensemble.runs), ""),)
    case = f"{quote(ensemble.first.path.name)}/{CASE}"
    return _again(ensemble.first, f"ensemble {case} --seeds {count} --first {first}")


def study_again(study: Study) -> Repeated:
    """Return how to repeat a study whose points are a grid; else where its points are."""
    keys = [parameter.key for parameter in study.plan.parameters]
    columns = zip(*(point.texts for point in study.plan.points), strict=True)
    values = [list(dict.fromkeys(column)) for column in columns]
    if prod(map(len, values)) != len(study.plan.points):
        return (("Its points are no grid: study.json has them.", ""),)
    seeds = {seed for one in study.ensembles.values() for seed in one.runs}
    if not _is_one_range(seeds):
        return ((_not_one_range(seeds), ""),)
    case = study.first.path.relative_to(study.path) / CASE
    over = [f"--over {quote(f'{k}=[{", ".join(v)}]')}" for k, v in zip(keys, values, strict=True)]
    chosen = f"--seeds {len(seeds)} --first {min(seeds)}"
    return _again(study.first, f"study {quote(str(case))} {' '.join(over)} {chosen}")


def _is_one_range(seeds: Collection[int]) -> bool:
    return max(seeds) - min(seeds) + 1 == len(seeds)


def _not_one_range(seeds: Collection[int]) -> str:
    told = ", ".join(map(str, sorted(seeds)))
    return f"Its seeds, {told}, are not one range: repeat each range with --seeds and --first."


def pair_again(pair: Pair, folder: Path) -> Repeated:
    """Return how to compare two runs again.

    Parameters
    ----------
    pair : the two runs.
    folder : folder of their page, as it was named.
    """
    named = [quote(str(path)) for path in (*(side.run.path for side in pair.sides), folder)]
    command = "staffa compare {} {} --out {}".format(*named)
    return (("In the folder from which they were compared:", command),)


def _programs(run: Run) -> dict[str, str]:
    m = run.manifest
    commit = f", commit {m.commit}" if m.commit else ""
    return {"staffa": f"{m.version}{commit}", **m.versions}
