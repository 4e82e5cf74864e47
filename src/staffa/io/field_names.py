"""Names of the files of fields in a run directory, and their indexes as animations."""

import json
from collections.abc import Sequence
from pathlib import Path

from staffa.io.own_files import write_aside

FIELDS = "fields"
SERIES, RESERVOIR_SERIES = "fields.vtkhdf.series", "reservoir.vtkhdf.series"


def fields_name(index: int) -> str:
    """Return the name of a step's file of fields, relative to the run directory."""
    return f"{FIELDS}/step-{index:04d}.vtkhdf"


def reservoir_name(fields: str) -> str:
    """Return the name of the reservoir's fields beside a step's, relative to the run directory."""
    return fields.replace("/step-", "/reservoir-")


def write_series(path: Path, written: Sequence[tuple[str, float]]) -> None:
    """Write the indexes by which ParaView and PyVista show files of fields as one animation.

    Parameters
    ----------
    path : the run directory.
    written : name relative to the run directory, and time (s), of each file of a step; files of the
        reservoir beside them have an index of theirs.
    """
    beside = [(reservoir_name(name), time) for name, time in written]
    there = [(name, time) for name, time in beside if (path / name).exists()]
    write_aside(path / FIELDS / SERIES, _index(written))
    if there:
        write_aside(path / FIELDS / RESERVOIR_SERIES, _index(there))
    else:
        (path / FIELDS / RESERVOIR_SERIES).unlink(missing_ok=True)


def _index(written: Sequence[tuple[str, float]]) -> str:
    files = [{"name": Path(name).name, "time": time} for name, time in written]
    return json.dumps({"file-series-version": "1.0", "files": files}, indent=1) + "\n"
