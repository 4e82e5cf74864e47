"""The runs that are kept in verification/, and the cases of their commands."""

import json
import shlex
from collections.abc import Iterator
from typing import Any

from staffa.case.reading.read import parse_case
from staffa.case.schema.case import Case
from support.paths import ROOT

OPTIONS = {"--set", "--seeds", "--first"}


def kept_records() -> Iterator[dict[str, Any]]:
    """All records of runs by `staffa run` and `staffa ensemble`, of the files they are kept in."""
    for file in sorted((ROOT / "verification").rglob("*.json")):
        yield from _records(json.loads(file.read_text()))


def as_run(command: str) -> tuple[Case, int]:
    """The case of a command, and on how many ranks it ran."""
    words = shlex.split(command)
    ranks = 1
    if words[0] == "mpiexec":
        ranks, words = int(words[2]), words[3:]
    _, _, file, *rest = words
    options = list(zip(rest[::2], rest[1::2], strict=True))
    assert {name for name, _ in options} <= OPTIONS, command
    settings = [value for name, value in options if name == "--set"]
    return parse_case((ROOT / file).read_text(encoding="utf-8"), settings), ranks


def _records(kept: object) -> Iterator[dict[str, Any]]:
    """The tables with a command that runs a case, at any depth."""
    if isinstance(kept, dict):
        command = str(kept.get("command"))
        if any(f"staffa {verb} " in command for verb in ("run", "ensemble")):
            yield kept
        kept = list(kept.values())
    if isinstance(kept, list):
        for part in kept:
            yield from _records(part)
