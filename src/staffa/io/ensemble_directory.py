"""Layout of an ensemble on disk: a run directory for each seed; no finite elements."""

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from staffa.arguments import path_of
from staffa.errors import InputError
from staffa.io.run_directory import MANIFEST, Run, open_run
from staffa.records.case_about import ABOUT

RESULTS = "ensemble.csv"
PRODUCTION_MEANS = "production_means.csv"
CRATE = "ro-crate-metadata.json"  # what describes a run or an ensemble as a research object
BESIDE = (RESULTS, PRODUCTION_MEANS, "cells.csv", "report.html", "pictures", CRATE)
MEMBER = re.compile(r"seed-(0|[1-9]\d*)")
OWN = ("output", "solver")  # tables that `staffa resume` may change in one member
SEED = re.compile(r"\bseed = \d+")  # of [toughness], and of each random property


@dataclass(frozen=True, kw_only=True)
class Ensemble:
    """Runs of one case that differ in their seeds only.

    Attributes
    ----------
    path : the ensemble's directory.
    runs : the runs by the seed of [toughness].
    """

    path: Path
    runs: dict[int, Run]

    @property
    def first(self) -> Run:
        """Run of the lowest seed."""
        return self.runs[min(self.runs)]

    @property
    def finished(self) -> dict[int, Run]:
        """Runs that reached their end; only these are averaged."""
        return {seed: run for seed, run in self.runs.items() if run.finished}


def member_path(path: Path, seed: int) -> Path:
    """Return the folder of the run of a seed."""
    return path / f"seed-{seed}"


def members(path: Path) -> dict[int, Path]:
    """Return the folders with a member's name by their seeds, in order; they may hold no run."""
    found = {}
    for inside in path.iterdir() if path.is_dir() else ():
        match = MEMBER.fullmatch(inside.name)
        if match:
            found[int(match.group(1))] = inside
    return dict(sorted(found.items()))


def is_ensemble(path: Path) -> bool:
    """Return True for a folder that contains members and is no run itself."""
    started = (inside / MANIFEST for inside in members(path).values())
    return not (path / MANIFEST).exists() and any(manifest.is_file() for manifest in started)


def is_of_ensemble(inside: Path) -> bool:
    """Return True for a member, or a file that was written beside members that have started."""
    if MEMBER.fullmatch(inside.name):
        return True  # each is looked at by itself
    return inside.name in BESIDE and is_ensemble(inside.parent)


def read_ensemble(path: str | Path) -> Ensemble:
    """Read the members that have started, also while others are still to come.

    Raises
    ------
    InputError
        Their cases differ in more than their seeds, [output] and [solver].
    StaffaError
        A file of one is damaged.
    """
    path = path_of(path, "path")
    started = {s: place for s, place in members(path).items() if (place / MANIFEST).is_file()}
    runs = {seed: open_run(place) for seed, place in started.items()}
    found = Ensemble(path=path, runs=runs)
    for run in runs.values():
        if _fixed(run) != _fixed(found.first):
            raise InputError(
                f"{path} is no ensemble: {found.first.path.name} and {run.path.name} in it are "
                f"runs of cases that differ in more than their seeds; move one of them elsewhere"
            )
    return found


def _fixed(run: Run) -> dict[str, Any]:
    return shared_part(run.case)


def shared_part(text: str) -> dict[str, Any]:
    """Return the part of a case that all members of an ensemble share, from its TOML."""
    tables = tomllib.loads(SEED.sub("seed = 0", text))
    return {name: table for name, table in tables.items() if name not in (*OWN, *ABOUT)}
