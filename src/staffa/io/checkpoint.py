"""Checkpoints on disk: atomic, checked by SHA-256, the last two kept; no finite elements.

A checkpoint is a page of numbers, `000012.json`, and the parts that it names: arrays in HDF5 files,
each named by the SHA-256 of its content. So a file on disk never changes: it is added and, when no
page names it any more, removed. A part that several pages name is written once.
"""

import io
import json
import re
from collections.abc import Iterable, Mapping
from contextlib import suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from staffa.errors import InputError, StaffaError
from staffa.io.own_files import HALF, keep_names, make_folder, write_aside
from staffa.io.run_directory import parsed

FORMAT, READ = 3, (2, 3)  # format 2 has no pressure and no memory of a coupling
FOLDER = "checkpoint"
KEPT = 2
PAGE, PART = re.compile(r"\d{6,}\.json"), re.compile(r"[0-9a-f]{64}\.h5")


class DamagedError(StaffaError):
    """Error of a checkpoint that cannot be used, with the reason."""


def write_part(folder: Path, arrays: Mapping[str, np.ndarray]) -> str:
    """Write arrays, and return the name by which a page refers to them."""
    with h5py.File("part", "w", driver="core", backing_store=False) as file:
        for name, values in arrays.items():
            file.create_dataset(name, data=values, track_times=False)
        file.flush()
        content = file.id.get_file_image()
    name = sha256(content).hexdigest()
    _make(folder)
    write_aside(_part(folder, name), content)
    return name


def read_part(folder: Path, name: str) -> dict[str, np.ndarray]:
    """Read the arrays that `write_part` wrote under a name.

    Raises
    ------
    DamagedError
        The file is missing, or was changed.
    """
    file = _part(folder, name)
    if file.exists() and not file.is_file():  # a pipe would be waited for
        raise DamagedError(f"{name[:8]}.h5 of it is no ordinary file")
    try:
        content = file.read_bytes()
    except OSError as error:
        raise DamagedError(f"{name[:8]}.h5 of it cannot be read ({error.strerror})") from None
    if sha256(content).hexdigest() != name:
        raise DamagedError(f"{name[:8]}.h5 of it is not what was written")
    with h5py.File(io.BytesIO(content), "r") as file:
        return {key: values[()] for key, values in file.items()}


def write_page(folder: Path, number: int, page: Mapping[str, Any], parts: Iterable[str]) -> None:
    """Complete a checkpoint whose parts are written, and remove all but the last two.

    Parameters
    ----------
    folder : folder of the checkpoints.
    number : number of the checkpoint, larger than that of the one before.
    page : numbers of the restart state.
    parts : names of all parts that the page names.
    """
    content = {"parts": list(parts), **page}
    head = {"format": FORMAT, "version": page.get("version"), "sha256": _sum(FORMAT, content)}
    text = json.dumps(head | {"checkpoint": content}, indent=1) + "\n"
    _make(folder)
    write_aside(_page(folder, number), text)
    _tidy(folder)


def checkpoint_numbers(folder: Path) -> list[int]:
    """Return the numbers of the checkpoints in a folder, the latest first."""
    found = folder.iterdir() if folder.is_dir() else ()
    pages = (path for path in found if PAGE.fullmatch(path.name) and path.is_file())
    return sorted((int(path.stem) for path in pages), reverse=True)


def read_page(folder: Path, number: int) -> dict[str, Any]:
    """Read a checkpoint's page.

    Raises
    ------
    DamagedError
        It is not what was written.
    InputError
        It has a format of a later version.
    """
    damaged = DamagedError("its page is not what was written")
    try:
        text = parsed(_page(folder, number).read_text(encoding="utf-8"))
        found, page = text.get("format"), text.get("checkpoint")
    except (OSError, ValueError, AttributeError):
        raise damaged from None
    if page is not None and found in READ and text.get("sha256") == _sum(found, page):
        return dict(page)
    changed = page is not None and text.get("sha256") in {_sum(f, page) for f in READ}
    if changed or found in READ:
        raise damaged
    # The checksum of another format is not known.
    raise InputError(
        f"{folder} has format {found or 1}, this staffa reads {FORMAT}; use the staffa that wrote "
        f"it, {text.get('version') or 'another one'}"
    )


def remove_after(folder: Path, number: int) -> None:
    """Remove the checkpoints after the one from which the run continues, and unfinished files."""
    for later in checkpoint_numbers(folder):
        if later > number:
            _page(folder, later).unlink()
    if folder.is_dir():
        _tidy(folder)


def _tidy(folder: Path) -> None:
    """Keep the last two checkpoints and the parts that they name.

    The parts of a damaged page are unknown; then no part is removed.
    """
    for number in checkpoint_numbers(folder)[KEPT:]:
        _page(folder, number).unlink()
    for half in folder.glob(f".*{HALF}"):
        half.unlink()
    with suppress(StaffaError):
        pages = [read_page(folder, number) for number in checkpoint_numbers(folder)]
        named = {_part(folder, name) for page in pages for name in page["parts"]}
        for part in set(folder.iterdir()) - named:
            if PART.fullmatch(part.name):
                part.unlink()


def _make(folder: Path) -> None:
    if not folder.exists() or folder.is_symlink():
        make_folder(folder)
        keep_names(folder.parent)


def _page(folder: Path, number: int) -> Path:
    return folder / f"{number:06d}.json"


def _part(folder: Path, name: str) -> Path:
    return folder / f"{name}.h5"


def _sum(number: int, content: Mapping[str, Any]) -> str:
    return sha256(f"{number} {json.dumps(content)}".encode()).hexdigest()
