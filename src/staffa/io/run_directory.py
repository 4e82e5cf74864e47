"""The layout of a run on disk, and how its records are written and read; no finite elements."""

import json
import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from errno import ENAMETOOLONG
from hashlib import sha256
from itertools import count
from math import inf, isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

from staffa.arguments import path_of
from staffa.backend.lock import LOCK
from staffa.errors import InputError, StaffaError, printable
from staffa.io.own_files import make_folder, to_append, write_aside
from staffa.io.step_columns import frame_of
from staffa.records.json_form import json_form
from staffa.records.manifest import Manifest
from staffa.records.status import Status
from staffa.records.step import Step, kept, made

if TYPE_CHECKING:
    from pandas import DataFrame

FORMAT = 1
CASE, MANIFEST, STEPS, FIELDS, LOG = (
    "case.toml",
    "manifest.json",
    "steps.jsonl",
    "fields",
    "run.log",
)
SERIES = "fields.vtkhdf.series"
LONGEST_LOCK = 400  # bytes
FIELDS_OF_A_STEP = re.compile(r"step-\d{4,}\.vtkhdf")


@dataclass(frozen=True, kw_only=True)
class Run:
    """A run as read back: its case file's text, its manifest, and the steps finished so far.

    steps: those that stand; superseded: those that backtracking has gone back behind, and rejected:
    those that were taken again, as recorded.
    """

    path: Path
    case: str
    manifest: Manifest
    steps: tuple[Step, ...]
    superseded: tuple[Step, ...] = ()
    rejected: tuple[Step, ...] = ()

    @property
    def finished(self) -> bool:
        """True if the last step is there and converged."""
        if not self.steps:
            return False
        last = self.steps[-1]
        return last.time == self.manifest.times[-1] and last.status == Status.CONVERGED

    def to_frame(self) -> "DataFrame":
        """Return the steps as a pandas frame, see `frame_of`."""
        return frame_of(self.manifest, self.steps)

    def wants(self, step: Step) -> bool:
        """Whether the time of a step was asked for as an output."""
        planned = zip(self.manifest.times, self.manifest.requested, strict=True)
        return any(time == step.time and asked for time, asked in planned)


def require_free(
    path: Path,
    way_out: str = "choose another folder or remove it",
    ours: Callable[[Path], bool] = lambda inside: False,
) -> None:
    """Refuse a place that holds a run already, or a person's files, or cannot hold a run.

    way_out: from a run that is there. ours: which of the things that are there staffa itself wrote,
    so that it may write over them.

    Raises
    ------
    InputError
        With the way out.
    """
    another = "name a folder that is new or empty"
    try:
        path.lstat()
    except OSError as error:
        if error.errno == ENAMETOOLONG:
            raise InputError(f"--out {path} is too long a name; choose a shorter one") from None
    if path.is_symlink():
        raise InputError(f"--out {path} is a symbolic link, which is not followed; {another}")
    if path.exists() and not path.is_dir():
        raise InputError(f"--out {path} is a file; {another}")
    if (path / STEPS).exists() or (path / CASE).exists():
        raise InputError(f"--out {path} holds a run already; {way_out}")
    above = path
    while not above.exists():
        above = above.parent
    if not above.is_dir() or not os.access(above, os.W_OK):
        raise InputError(f"--out {path} cannot be made: {above} is no folder that you may write to")
    held = sorted(inside.name for inside in path.iterdir()) if path.is_dir() else []
    others = [name for name in held if not (_is_lock(path / name) or ours(path / name))]
    if others:
        raise InputError(f"--out {path} holds {others[0]}, which is of no run; {another}")


def _is_lock(path: Path) -> bool:
    """True if a file is the lock of a run that was not started."""
    return path.name == LOCK and path.is_file() and path.stat().st_size <= LONGEST_LOCK


def write_case(path: Path, case: str, manifest: Manifest) -> None:
    """Write what a run is, in place of what may be there."""
    write_aside(path / CASE, case)
    write_aside(path / MANIFEST, json.dumps(json_form(manifest), indent=2) + "\n")


def create(path: Path, case: str, manifest: Manifest, files: Sequence[Path] = ()) -> None:
    """Make a run directory with its case, copies of the files that it names, its manifest, and no
    step yet. If the disk does not take all of it, there is no run."""
    make_folder(path / FIELDS)
    copies = [file for file in files if not _is_there(file, path)]
    try:
        for file in copies:
            write_aside(path / file.name, file.read_bytes())
        (path / STEPS).touch()
        write_case(path, case, manifest)  # last: it also brings the others' names to the disk
    except OSError:
        for name in (CASE, MANIFEST, STEPS, *(file.name for file in copies)):
            (path / name).unlink(missing_ok=True)
        (path / FIELDS).rmdir()
        raise


def _is_there(file: Path, folder: Path) -> bool:
    """True if a file is that of this name in a folder."""
    return (folder / file.name).exists() and file.samefile(folder / file.name)


class Journal:
    """The file of steps as it grows: how many lines it has, and the SHA-256 of all of them.

    A checkpoint names both, so that what is before it is known to be what was written.
    """

    def __init__(self, path: Path, lines: Sequence[str] = ()) -> None:
        """lines: those that are there, without their ends."""
        self.path, self.lines = path, len(lines)
        self._sum = sha256("".join(f"{line}\n" for line in lines).encode())

    @property
    def sum(self) -> str:
        """SHA-256 of all lines, in hexadecimal digits."""
        return self._sum.hexdigest()

    def append(self, step: Step) -> None:
        """Add a step's record as one line, on disk before this returns."""
        line = json.dumps(step.to_record()) + "\n"
        with to_append(self.path / STEPS) as file:
            file.write(line)
            file.flush()
            os.fsync(file.fileno())
        self.lines += 1
        self._sum.update(line.encode())


def append_step(path: Path, step: Step) -> None:
    """Add one step's record, see `Journal`."""
    Journal(path).append(step)


def journal_lines(path: Path) -> list[str]:
    """The whole lines of the file of steps, whatever they hold."""
    file = path / STEPS
    text = _text(file, "replace") if file.is_file() else ""
    return text.split("\n")[:-1]


def put_aside(path: Path) -> Path:
    """Rename the file of steps, since a run begins again; its new name."""
    taken = (path / f"{STEPS}.{number}" for number in count(1))
    aside = next(name for name in taken if not name.exists())
    (path / STEPS).rename(aside)
    return aside


def cut_back(path: Path, lines: Sequence[str], steps: Sequence[Step]) -> None:
    """Let the file of steps hold these lines alone, and the fields be those of these steps."""
    write_aside(path / STEPS, "".join(f"{line}\n" for line in lines))
    make_folder(path / FIELDS)
    written = [(step.fields, step.time) for step in steps if step.fields]
    known = {Path(name).name for name, _ in written}
    for file in (path / FIELDS).iterdir():  # people may keep their own beside these
        if FIELDS_OF_A_STEP.fullmatch(file.name) and file.name not in known:
            file.unlink()
    write_series(path, written)


def append_log(path: Path, line: str) -> None:
    """Add one line to the log."""
    with to_append(path / LOG) as file:
        file.write(printable(line) + "\n")


def fields_name(index: int) -> str:
    """Name of the fields of a step, below the run directory."""
    return f"{FIELDS}/step-{index:04d}.vtkhdf"


def write_series(path: Path, written: Sequence[tuple[str, float]]) -> None:
    """Write the index by which ParaView and PyVista see the files of fields as one animation.

    Parameters
    ----------
    written : name below the run directory, and time (s), of each file.
    """
    files = [{"name": Path(name).name, "time": time} for name, time in written]
    index = {"file-series-version": "1.0", "files": files}
    write_aside(path / FIELDS / SERIES, json.dumps(index, indent=1) + "\n")


def open_run(path: str | Path) -> Run:
    """Read a run directory, also one that is still being written or was killed.

    Raises
    ------
    InputError
        The folder is no run directory, or a later format than this version reads.
    StaffaError
        A file in it is damaged.
    """
    path = path_of(path, "path")
    if not (path / MANIFEST).is_file():
        raise InputError(
            f"{path} is no run directory: it has no {MANIFEST}; name a folder that `staffa run` "
            f"made"
        )
    manifest = read_manifest(path)
    steps = _read_steps(path)
    standing = kept(steps)
    rejected = tuple(step for step in steps if step.status == Status.REJECTED)
    known = {id(step) for step in (*standing, *rejected)}
    return Run(
        path=path,
        case=read_case_text(path),
        manifest=manifest,
        steps=standing,
        superseded=tuple(step for step in steps if id(step) not in known),
        rejected=rejected,
    )


def read_manifest(path: Path) -> Manifest:
    """What a run is; errors as of `open_run`."""
    file = path / MANIFEST
    try:
        record = parsed(_text(file))
    except ValueError as error:
        raise StaffaError(f"{file} is damaged: {error}") from None
    if not isinstance(record, dict):
        raise StaffaError(f"{file} is damaged: it holds no names with values")
    if record.get("format") != FORMAT:
        raise InputError(
            f"{path} has format {record.get('format')}, this staffa reads {FORMAT}; use the "
            f"staffa that wrote it, {record.get('version')}"
        )
    try:
        found = made(Manifest, record)
        _is_whole(found)
    except ValueError as error:
        raise StaffaError(
            f"{file} is damaged: it lacks an entry, or has a wrong one ({error})"
        ) from None
    return found


def parsed(text: str) -> Any:
    """Read a text of JSON.

    Raises
    ------
    ValueError
        It is none, or its brackets are nested too deeply.
    """
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError("its brackets are nested too deeply") from None


def _is_whole(manifest: Manifest) -> None:
    """Raise a ValueError where numbers of a manifest can be those of no run."""
    m, dim = manifest, len(manifest.size)
    positive = (m.h, m.ell, m.L, m.toughness_factor, m.cells, m.unknowns, m.ranks, *m.size)
    if dim not in (2, 3) or len(m.corner) != dim:
        raise ValueError("size and lower: two or three numbers each")
    if not all(0 < number < inf for number in positive):
        raise ValueError("h, ell, L, toughness_factor, cells, unknowns, ranks, size: positive")
    if not m.times or not len(m.times) == len(m.taus) == len(m.requested):
        raise ValueError("times, taus, requested: lists of one length, not empty")
    if not all(map(isfinite, m.times)) or list(m.times) != sorted(m.times):
        raise ValueError("times: finite, in increasing order")


def read_case_text(path: Path) -> str:
    """The case of a run, as TOML; errors as of `open_run`."""
    file = path / CASE
    try:
        return _text(file)
    except UnicodeDecodeError:
        raise StaffaError(f"{file} is damaged") from None


def _text(file: Path, errors: str = "strict") -> str:
    if file.exists() and not file.is_file():  # a pipe would be waited for, a device may never end
        raise InputError(f"{file} cannot be read (it is no ordinary file)")
    try:
        return file.read_text(encoding="utf-8", errors=errors)
    except OSError as error:
        raise InputError(f"{file} cannot be read ({error.strerror})") from None


def _read_steps(path: Path) -> tuple[Step, ...]:
    """The steps up to a last line that a kill cut short; a bad line before it is an error."""
    return steps_in(journal_lines(path), path / STEPS)


def steps_in(lines: Sequence[str], file: Path) -> tuple[Step, ...]:
    """The steps that lines of a file hold.

    Raises
    ------
    StaffaError
        A line is damaged.
    """
    steps = []
    for number, line in enumerate(lines, start=1):
        try:
            steps.append(Step.from_record(parsed(line)))
        except (ValueError, TypeError, AttributeError) as error:
            raise StaffaError(
                f"{file}, line {number} is damaged ({error}); `staffa resume {file.parent}` goes "
                f"on from the last good checkpoint before it"
            ) from None
    return tuple(steps)
