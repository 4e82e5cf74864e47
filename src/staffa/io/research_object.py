"""Description of a run or an ensemble as a research object (RO-Crate 1.1): inputs, software, files.

What changes a run renews its description and removes that of its ensemble, whose hashes
are wrong then.
It is a file of JSON-LD. The rocrate library, which reads it in tests, would bring clients of the
network to each installation, and could not write the file atomically.
"""

import json
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from datetime import UTC, datetime
from hashlib import file_digest
from pathlib import Path
from typing import Any
from urllib.parse import quote

from staffa.backend.lock import LOCK, Lock
from staffa.io.checkpoint import FOLDER as CHECKPOINTS
from staffa.io.ensemble_directory import CRATE, MEMBER, is_ensemble, read_ensemble
from staffa.io.own_files import HALF, write_aside
from staffa.io.run_directory import CASE, STEPS, Run, open_run
from staffa.records.authorship import license_of, people_of
from staffa.records.manifest import Manifest

CONTEXT = ["https://w3id.org/ro/crate/1.1/context", {"sha256": "https://schema.org/sha256"}]
PROFILE = "https://w3id.org/ro/crate/1.1"
FORMATS = {
    ".csv": "text/csv",
    ".gif": "image/gif",
    ".html": "text/html",
    ".json": "application/json",
    ".geojson": "application/geo+json",
    ".jsonl": "application/jsonl",
    ".log": "text/plain",
    ".png": "image/png",
    ".toml": "application/toml",
    ".vtkhdf": "application/x-hdf5",
}
STOPPED_BYTES = 1 << 29  # read in about a second; of a stopped run the time may be over
DONE, STOPPED = "http://schema.org/CompletedActionStatus", "http://schema.org/FailedActionStatus"
Entity = dict[str, Any]


def write_crate(path: Path) -> Path | None:
    """Write the description of a run or an ensemble into its directory, over an earlier one.

    Parameters
    ----------
    path : its directory.

    Returns
    -------
    Path or None
        The file; None while another process writes to the run, which leaves one at its end.

    Raises
    ------
    OSError
        A file cannot be read, or the directory not be written to.
    """
    if is_being_written(path):
        return None
    write_own_crate(path)
    return path / CRATE


def write_own_crate(path: Path) -> None:
    """Do the same for the process that holds the lock of the run."""
    forget_crate_above(path)
    write_aside(path / CRATE, crate_text(path, crate_files(path)))


def forget_crate_above(path: Path) -> None:
    """Remove the description of the ensemble above a run whose files change, if there is one.

    Parameters
    ----------
    path : directory of the run.
    """
    place = path.absolute()
    if MEMBER.fullmatch(place.name) and is_ensemble(place.parent):
        with suppress(OSError):
            (place.parent / CRATE).unlink(missing_ok=True)


def describe_stopped(path: Path) -> None:
    """Describe a run or an ensemble that stopped or failed, if that can be done at once.

    Of files of more than `STOPPED_BYTES` there is no description then: `staffa export` writes one.

    Parameters
    ----------
    path : its directory, to which no other process writes.
    """
    with suppress(Exception):  # of any kind: what stopped it is to be told, not this
        if not is_ensemble(path):
            open_run(path)
        if sum(file.stat().st_size for file in crate_files(path)) > STOPPED_BYTES:
            (path / CRATE).unlink(missing_ok=True)
            forget_crate_above(path)
        else:
            write_own_crate(path)


def crate_text(path: Path, files: Sequence[Path]) -> str:
    """Return the description of the run or the ensemble in a directory, as JSON-LD.

    Parameters
    ----------
    path : its directory.
    files : the files that it lists, see `crate_files`.
    """
    runs = (
        {f"{run.path.name}/": run for run in read_ensemble(path).runs.values()}
        if is_ensemble(path)
        else {"": open_run(path)}
    )
    return json.dumps({"@context": CONTEXT, "@graph": _graph(path, runs, files)}, indent=1) + "\n"


def is_being_written(path: Path) -> bool:
    """Return True if another process writes to the run in a directory, or to one of an ensemble."""
    return any(_is_held(lock.parent) for lock in (path / LOCK, *path.glob(f"*/{LOCK}")))


def _is_held(folder: Path) -> bool:
    lock = folder / LOCK
    if not lock.is_file() or not lock.stat().st_size:  # it says who holds it
        return False
    return Lock(folder).is_held()


def crate_files(path: Path) -> list[Path]:
    """Return the files of a run or an ensemble that its description lists, in order.

    Left out are checkpoints, with which `staffa resume` alone can do something, locks, unfinished
    files, the description itself, all that is no ordinary file, and `unspelled_files`.
    """
    files = (file for file in _ordinary(path) if file != path / CRATE)
    return sorted(file for file in files if _is_spelled(file, path))


def unspelled_files(path: Path) -> list[Path]:
    """Return the files that no description can list: their names are not UTF-8."""
    return sorted(file for file in _ordinary(path) if not _is_spelled(file, path))


def _is_spelled(file: Path, path: Path) -> bool:
    try:
        file.relative_to(path).as_posix().encode()
    except UnicodeEncodeError:
        return False
    return True


def _ordinary(folder: Path) -> Iterator[Path]:
    for inside in folder.iterdir():
        if inside.is_symlink() or inside.name.endswith(HALF):
            continue
        if inside.is_dir() and inside.name != CHECKPOINTS:
            yield from _ordinary(inside)
        elif inside.is_file() and inside.name != LOCK:
            yield inside


def crate_name(file: Path, path: Path) -> str:
    """Return the identifier of a file in the description of a directory: a relative URI."""
    return quote(file.relative_to(path).as_posix())


def _graph(path: Path, runs: Mapping[str, Run], listed: Sequence[Path]) -> list[Entity]:
    """Return all entities: the description, the directory, its files, runs, software, people."""
    files = [_file(file, path) for file in listed]
    first = next(iter(runs.values()))
    tables = tomllib.loads(first.case)
    people = people_of(tables.get("authors", ()))
    terms = license_of(tables.get("license", ""))
    before = _earlier(path)
    actions = [_action(run, start, files, before) for start, run in runs.items()]
    software = _software(first.manifest)
    root = {
        "@id": "./",
        "@type": "Dataset",
        "name": _name(path, first),
        "description": _description(runs),
        "datePublished": max(action["endTime"] for action in actions)[:10],
        "license": {"@id": terms["@id"]} if isinstance(terms, dict) else terms,
        **({"author": _links(people)} if people else {}),
        "hasPart": _links(files),
        "mentions": _links(actions),
    }
    about = {
        "@id": CRATE,
        "@type": "CreativeWork",
        "conformsTo": {"@id": PROFILE},
        "about": {"@id": "./"},
    }
    more = [terms] if isinstance(terms, dict) else []
    return [about, root, *files, *actions, *software, *people, *more]


def _links(entities: list[Entity]) -> list[Entity]:
    return [{"@id": entity["@id"]} for entity in entities]


def _file(file: Path, path: Path) -> Entity:
    with file.open("rb") as content:
        digest = file_digest(content, "sha256").hexdigest()
        size = content.tell()
    known = FORMATS.get(file.suffix)
    return {
        "@id": crate_name(file, path),
        "@type": "File",
        "name": file.name,
        "contentSize": str(size),
        "sha256": digest,
    } | ({"encodingFormat": known} if known else {})


def _name(path: Path, run: Run) -> str:
    return run.manifest.title or f"Run of staffa in {path.resolve().name}"


def _description(runs: Mapping[str, Run]) -> str:
    first = next(iter(runs.values())).manifest
    law = f"damage law {first.law}, energy split {first.split}, {first.cells} cells"
    by = f"cracks in cooling rock, computed by staffa {first.version} ({law})"
    if list(runs) == [""]:
        return f"A run: {by}; {_how_far(runs[''])}."
    done = sum(run.finished for run in runs.values())
    return f"{len(runs)} runs that differ in their seeds, {done} of them finished: {by}."


def _how_far(run: Run) -> str:
    if run.finished:
        return f"finished, {len(run.steps)} steps"
    return f"not finished, {len(run.steps)} steps"


def _action(run: Run, start: str, files: list[Entity], before: Mapping[str, str]) -> Entity:
    """Return the run as an action: with its software, from its inputs to its results."""
    own = {file["@id"]: file for file in files if file["@id"].startswith(start)}
    inputs = {f"{start}{quote(name)}" for name in _inputs(run)} & set(own)
    steps = own.get(f"{start}{STEPS}", {})
    ended = before.get(steps.get("sha256", "")) or _time_of(run.path / STEPS)
    return {
        "@id": f"#run-{start.strip('/')}" if start else "#run",
        "@type": "CreateAction",
        "name": f"staffa run {CASE}",
        "description": _how_far(run),
        "instrument": {"@id": "#staffa"},
        "object": [{"@id": name} for name in own if name in inputs],
        "result": [{"@id": name} for name in own if name not in inputs],
        "startTime": run.manifest.created,
        "endTime": max(ended, run.manifest.created),
        "actionStatus": {"@id": DONE if run.finished else STOPPED},
    }


def _inputs(run: Run) -> set[str]:
    """Return the names of the case and, among its texts, of files beside it."""
    names = {CASE, *_texts(tomllib.loads(run.case))}
    for series in (run.path / name for name in names if name.endswith(".series")):
        with suppress(OSError, ValueError):
            names |= set(_texts(json.loads(series.read_text(encoding="utf-8"))))
    return names


def _texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    for one in inner:
        yield from _texts(one)


def _time_of(file: Path) -> str:
    """Return date and time of the last change of a file, in UTC."""
    return datetime.fromtimestamp(file.stat().st_mtime, UTC).isoformat(timespec="seconds")


def _earlier(path: Path) -> dict[str, str]:
    """Return when runs ended, by the SHA-256 of their steps, as an earlier description says.

    A copy has other times than the original.
    """
    with suppress(OSError, ValueError, KeyError, TypeError, AttributeError):
        graph = json.loads((path / CRATE).read_text(encoding="utf-8"))["@graph"]
        known = {entity["@id"]: entity for entity in graph}
        return {
            str(known[made["@id"]]["sha256"]): str(action["endTime"])
            for action in graph
            if action["@type"] == "CreateAction"
            for made in action["result"]
            if Path(made["@id"]).name == STEPS
        }
    return {}


def _software(manifest: Manifest) -> list[Entity]:
    """Return staffa and the libraries that it used, with their versions."""
    libraries = [
        {"@id": f"#{quote(name)}", "@type": "SoftwareApplication", "name": name, "version": version}
        for name, version in manifest.versions.items()
        if " " not in name  # the flags of the compiler are no library
    ]
    own: Entity = {
        "@id": "#staffa",
        "@type": "SoftwareApplication",
        "name": "staffa",
        "version": manifest.version,
        "softwareRequirements": _links(libraries),
    }
    return [own | ({"identifier": manifest.commit} if manifest.commit else {}), *libraries]
