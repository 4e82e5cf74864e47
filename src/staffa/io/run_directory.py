"""Layout of a run on disk, and its records, written and read; no finite elements."""

import json
import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from errno import ENAMETOOLONG
from hashlib import sha256
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING, Any

from staffa.arguments import path_of
from staffa.backend.lock import LOCK
from staffa.errors import InputError, StaffaError, printable
from staffa.io.field_names import FIELDS as FIELDS
from staffa.io.field_names import SERIES as SERIES
from staffa.io.field_names import fields_name as fields_name
from staffa.io.field_names import reservoir_name as reservoir_name
from staffa.io.field_names import write_series as write_series
from staffa.io.own_files import make_folder, to_append, write_aside
from staffa.io.step_columns import frame_of, pandas_frame
from staffa.io.well_rows import WellRow, well_rows
from staffa.records.json_form import json_form
from staffa.records.manifest import Manifest, check_numbers
from staffa.records.status import Status
from staffa.records.step import Step, kept, made

if TYPE_CHECKING:
    from pandas import DataFrame

    import staffa

FORMAT = 1
CASE, MANIFEST, STEPS = "case.toml", "manifest.json", "steps.jsonl"
LOG = "run.log"
LONGEST_LOCK = 400  # bytes
FIELDS_OF_A_STEP = re.compile(r"(step|reservoir)-\d{4,}\.vtkhdf")


@dataclass(frozen=True, kw_only=True)
class Run:
    """Run as read from its directory.

    Attributes
    ----------
    path : the run directory.
    case : text of its case file.
    manifest : description of the run.
    steps : steps that were reached and kept, in order.
    superseded : steps that a later return replaced.
    rejected : steps that were computed again, shorter.
    unreached : the step that ended the run, since it did not converge or failed; else None.
    """

    path: Path
    case: str
    manifest: Manifest
    steps: tuple[Step, ...]
    superseded: tuple[Step, ...] = ()
    rejected: tuple[Step, ...] = ()
    unreached: Step | None = None

    @property
    def finished(self) -> bool:
        """True if the last step was reached."""
        ended = bool(self.steps) and self.steps[-1].time == self.manifest.times[-1]
        return ended and self.unreached is None

    @property
    def audited(self) -> tuple[Step, ...]:
        """Steps whose audit is told: those that were reached, and the one that was not."""
        return (*self.steps, self.unreached) if self.unreached else self.steps

    @property
    def computed(self) -> tuple[Step, ...]:
        """All steps on record, in no order: what the run spent is spent on these."""
        return (*self.audited, *self.superseded, *self.rejected)

    def to_frame(self) -> "DataFrame":
        """Return the steps as a pandas frame, see `frame_of`."""
        return frame_of(self.manifest, self.steps)

    def production_frame(self) -> "DataFrame":
        """Return production.csv as a pandas frame: a row for each step and well, in SI units."""
        return pandas_frame(well_rows(self.manifest.reservoir, self.steps), WellRow._fields)

    def plot(self, *names: str) -> "staffa.Pictures":
        """Draw the standard pictures, see `staffa.pictures_of`; a notebook shows them.

        Parameters
        ----------
        names : names of pictures, like "cracks"; without any, all that the run has numbers for.
        """
        import staffa  # only then Matplotlib is loaded

        return staffa.pictures_of(self, *names)

    def wants(self, step: Step) -> bool:
        """Return True if the time of a step was requested as an output."""
        planned = zip(self.manifest.times, self.manifest.requested, strict=True)
        return any(time == step.time and asked for time, asked in planned)


def require_free(
    path: Path,
    way_out: str = "choose another folder or remove it",
    ours: Callable[[Path], bool] = lambda inside: False,
) -> None:
    """Refuse a folder that contains a run or a user's files, or in which no run can be made.

    Parameters
    ----------
    path : the folder.
    way_out : advice if it contains a run.
    ours : returns True for a file or folder that staffa wrote, so that it may be overwritten.

    Raises
    ------
    InputError
        The folder cannot be used; the message has the way out.
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
    """Return True if a file is the lock of a run that was not started."""
    return path.name == LOCK and path.is_file() and path.stat().st_size <= LONGEST_LOCK


def write_case(path: Path, case: str, manifest: Manifest) -> None:
    """Write the text `case` and the `manifest` of a run into `path`, in place of existing ones."""
    write_aside(path / CASE, case)
    write_aside(path / MANIFEST, json.dumps(json_form(manifest), indent=2) + "\n")


def create(path: Path, case: str, manifest: Manifest, files: Sequence[Path] = ()) -> None:
    """Make a run directory `path` with `case`, `manifest` and copies of `files`, without a step.

    If the disk does not take all of it, there is no run.
    """
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
    """Return True if a file is the one of this name in a folder."""
    return (folder / file.name).exists() and file.samefile(folder / file.name)


class Journal:
    """File of steps as it grows: its number of lines, and the SHA-256 of all of them.

    A checkpoint stores both, so that a change of the lines before it is detected.
    """

    def __init__(self, path: Path, lines: Sequence[str] = ()) -> None:
        """Start from the existing lines, given without their ends."""
        self.path, self.lines = path, len(lines)
        self._sum = sha256("".join(f"{line}\n" for line in lines).encode())

    @property
    def sum(self) -> str:
        """SHA-256 of all lines, in hexadecimal digits."""
        return self._sum.hexdigest()

    def append(self, step: Step) -> None:
        """Write a step's record as one line; it is on disk when this returns."""
        line = json.dumps(step.to_record()) + "\n"
        with to_append(self.path / STEPS) as file:
            file.write(line)
            file.flush()
            os.fsync(file.fileno())
        self.lines += 1
        self._sum.update(line.encode())


def journal_lines(path: Path) -> list[str]:
    """Return the complete lines of the file of steps, whatever their content."""
    file = path / STEPS
    text = _text(file, "replace") if file.is_file() else ""
    return text.split("\n")[:-1]


def put_aside(path: Path) -> Path:
    """Rename the file of steps, since a run begins again, and return its new name."""
    taken = (path / f"{STEPS}.{number}" for number in count(1))
    aside = next(name for name in taken if not name.exists())
    (path / STEPS).rename(aside)
    return aside


def cut_back(path: Path, lines: Sequence[str], steps: Sequence[Step]) -> None:
    """Reduce the steps in `path` to these `lines`, and the fields to those of these `steps`."""
    write_aside(path / STEPS, "".join(f"{line}\n" for line in lines))
    make_folder(path / FIELDS)
    written = [(step.fields, step.time) for step in steps if step.fields]
    known = {Path(found).name for name, _ in written for found in (name, reservoir_name(name))}
    for file in (path / FIELDS).iterdir():  # users may keep their own files there
        if FIELDS_OF_A_STEP.fullmatch(file.name) and file.name not in known:
            file.unlink()
    write_series(path, written)


def append_log(path: Path, line: str) -> None:
    """Append one line to the log."""
    with to_append(path / LOG) as file:
        file.write(printable(line) + "\n")


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
    steps = steps_in(journal_lines(path), path / STEPS)  # without a last line that was cut short
    accepted = kept(steps)
    rejected = tuple(step for step in steps if step.status == Status.REJECTED)
    known = {id(step) for step in (*accepted, *rejected)}
    return Run(
        path=path,
        case=read_case_text(path),
        manifest=manifest,
        steps=tuple(step for step in accepted if step.reached),
        superseded=tuple(step for step in steps if id(step) not in known),
        rejected=rejected,
        unreached=next((step for step in accepted if not step.reached), None),
    )


def read_manifest(path: Path) -> Manifest:
    """Read the manifest of a run; errors as in `open_run`."""
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
        check_numbers(found)
    except ValueError as error:
        raise StaffaError(
            f"{file} is damaged: it lacks an entry, or has a wrong one ({error})"
        ) from None
    return found


def parsed(text: str) -> Any:
    """Parse a JSON text.

    Raises
    ------
    ValueError
        It is no JSON, or its brackets are nested too deeply.
    """
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError("its brackets are nested too deeply") from None


def read_case_text(path: Path) -> str:
    """Return the case of a run as TOML; errors as in `open_run`."""
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


def steps_in(lines: Sequence[str], file: Path) -> tuple[Step, ...]:
    """Return the steps in the lines of a file.

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
