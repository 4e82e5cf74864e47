"""The layout of a run on disk, and how its records are written and read; no finite elements."""

import json
import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from hashlib import sha256
from itertools import count
from pathlib import Path

from staffa.display_units import Unit
from staffa.errors import InputError, StaffaError
from staffa.manifest import Manifest, Probe
from staffa.records import REJECTED, Step, kept, made

FORMAT = 1
CASE, MANIFEST, STEPS, FIELDS, LOG = (
    "case.toml",
    "manifest.json",
    "steps.jsonl",
    "fields",
    "run.log",
)
SERIES = "fields.vtkhdf.series"


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
        return last.time == self.manifest.times[-1] and last.status == "converged"

    def wants(self, step: Step) -> bool:
        """Whether the time of a step was asked for as an output."""
        planned = zip(self.manifest.times, self.manifest.requested, strict=True)
        return any(time == step.time and asked for time, asked in planned)


def require_free(path: Path, way_out: str = "choose another folder or remove it") -> None:
    """Refuse a place that holds a run already, or cannot hold one.

    way_out: from a run that is there.

    Raises
    ------
    InputError
        With the way out.
    """
    if path.exists() and not path.is_dir():
        raise InputError(f"--out {path} is a file; name a folder that is new or empty")
    if (path / STEPS).exists() or (path / CASE).exists():
        raise InputError(f"--out {path} holds a run already; {way_out}")
    above = path
    while not above.exists():
        above = above.parent
    if not above.is_dir() or not os.access(above, os.W_OK):
        raise InputError(f"--out {path} cannot be made: {above} is no folder that you may write to")


def write_case(path: Path, case: str, manifest: Manifest) -> None:
    """Write what a run is, in place of what may be there."""
    write_aside(path / CASE, case)
    write_aside(path / MANIFEST, json.dumps(asdict(manifest), indent=2) + "\n")


def create(path: Path, case: str, manifest: Manifest, files: Sequence[Path] = ()) -> None:
    """Make a run directory with its case, copies of the files that it names, its manifest, and no
    step yet. If the disk does not take all of it, there is no run."""
    (path / FIELDS).mkdir(parents=True, exist_ok=True)
    for file in files:
        if not (path / file.name).exists() or not file.samefile(path / file.name):
            write_aside(path / file.name, file.read_bytes())
    try:
        (path / STEPS).touch()
        write_case(path, case, manifest)  # last: it also brings the others' names to the disk
    except OSError:
        for name in (CASE, MANIFEST, STEPS):
            (path / name).unlink(missing_ok=True)
        raise


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
        with (self.path / STEPS).open("a", encoding="utf-8") as file:
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
    (path / FIELDS).mkdir(exist_ok=True)
    written = [(step.fields, step.time) for step in steps if step.fields]
    known = {Path(name).name for name, _ in written}
    for file in (path / FIELDS).glob("step-*"):  # people may keep their own beside these
        if file.name not in known:
            file.unlink()
    write_series(path, written)


def remove_halves(path: Path) -> None:
    """Remove what a kill left half written, in the run's own folders."""
    for folder in (path, *(inside for inside in path.iterdir() if inside.is_dir())):
        for half in folder.glob("*.part"):
            half.unlink()


def append_log(path: Path, line: str) -> None:
    """Add one line to the log."""
    with (path / LOG).open("a", encoding="utf-8") as file:
        file.write(line + "\n")


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


def write_aside(path: Path, content: str | bytes) -> None:
    """Write a file so that it is there whole or not at all, also after a power cut."""
    aside = path.with_name(path.name + ".part")
    try:
        with aside.open("wb") as file:
            file.write(content.encode() if isinstance(content, str) else content)
            file.flush()
            os.fsync(file.fileno())
    except OSError:
        aside.unlink(missing_ok=True)  # on a full disk it takes the room of what is needed
        raise
    aside.replace(path)
    keep_names(path.parent)


def keep_names(path: Path) -> None:
    """Bring to the disk which files a folder has: that a file has its name is kept there."""
    folder = os.open(path, os.O_RDONLY)
    try:
        os.fsync(folder)
    finally:
        os.close(folder)


def read_run(path: Path) -> Run:
    """Read a run directory, also one that is still being written or was killed.

    Raises
    ------
    InputError
        The folder is no run directory, or a later format than this version reads.
    StaffaError
        A file in it is damaged.
    """
    if not (path / MANIFEST).is_file():
        raise InputError(f"{path} is no run directory: it has no {MANIFEST}")
    manifest = read_manifest(path)
    steps = _read_steps(path)
    standing = kept(steps)
    rejected = tuple(step for step in steps if step.status == REJECTED)
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
    """What a run is; errors as of `read_run`."""
    file = path / MANIFEST
    try:
        record = json.loads(_text(file))
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
        for name in ("times", "taus", "requested", "size"):
            record[name] = tuple(record[name])
        if record.get("lower") is not None:  # a run of version 0.1.0 has none
            record["lower"] = tuple(record["lower"])
        record["probes"] = tuple(
            Probe(name=probe["name"], points=tuple(map(tuple, probe["points"])))
            for probe in record.get("probes", ())
        )
        record["units"] = {name: made(Unit, unit) for name, unit in record.get("units", {}).items()}
        return made(Manifest, record)
    except (KeyError, TypeError):
        raise StaffaError(f"{file} is damaged: it lacks an entry, or has a wrong one") from None


def read_case_text(path: Path) -> str:
    """The case of a run, as TOML; errors as of `read_run`."""
    file = path / CASE
    try:
        return _text(file)
    except UnicodeDecodeError:
        raise StaffaError(f"{file} is damaged") from None


def _text(file: Path, errors: str = "strict") -> str:
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
            steps.append(Step.from_record(json.loads(line)))
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise StaffaError(
                f"{file}, line {number} is damaged ({error}); `staffa resume {file.parent}` goes "
                f"on from the last good checkpoint before it"
            ) from None
    return tuple(steps)
