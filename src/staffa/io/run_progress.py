"""Progress of a run that another process writes, read from its directory."""

from pathlib import Path
from typing import NamedTuple

from staffa.errors import StaffaError
from staffa.io.run_directory import MANIFEST, journal_lines, parsed, read_manifest
from staffa.records.status import Status


class RunProgress(NamedTuple):
    """Part of a run that is done.

    Attributes
    ----------
    steps : number of the last step that was reached, from 1; 0 before any.
    planned : number of its steps; 0 where that is not known.
    part : part of it that is done, from 0 to 1.
    """

    steps: int
    planned: int
    part: float


def run_progress(path: Path) -> RunProgress | None:
    """Return the progress of a run; None before it begins, or where it cannot be read.

    Parameters
    ----------
    path : the run directory.
    """
    try:
        if not (path / MANIFEST).is_file():
            return None
        manifest = read_manifest(path)
        planned = 0 if manifest.adaptive else len(manifest.times)
        steps = map(parsed, reversed(journal_lines(path)))
        last = next((step for step in steps if step["status"] == Status.CONVERGED), None)
        if last is None:
            return RunProgress(0, planned, 0.0)
        number, time = int(last["index"]) + 1, float(last["time"])
    except (StaffaError, OSError, ValueError, KeyError, TypeError):
        return None
    return RunProgress(number, planned, number / planned if planned else time / manifest.times[-1])
