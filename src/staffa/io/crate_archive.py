"""Description of a run or an ensemble on request: in its directory, or with it in an archive."""

import os
from pathlib import Path
from typing import IO
from warnings import warn
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from staffa.arguments import path_of
from staffa.errors import InputError, StaffaError, StaffaWarning
from staffa.io.ensemble_directory import CRATE, is_ensemble
from staffa.io.own_files import opened_aside
from staffa.io.research_object import (
    crate_files,
    crate_text,
    is_being_written,
    unspelled_files,
    write_crate,
)
from staffa.io.run_directory import open_run
from staffa.io.study_refusal import require_no_study

# Date of each file in the archive, the earliest possible: the same run gives the same bytes.
DATE = (1980, 1, 1, 0, 0, 0)
PIECE = 1 << 20  # bytes that are copied at once


def export_zip(directory: str | Path, file: str | Path | None = None) -> Path:
    """Pack the description of a run or an ensemble, and the files that it lists, into an archive.

    Parameters
    ----------
    directory : directory of the run or the ensemble, which stays as it is.
    file : the archive; None for the name of the directory with .zip, beside it.

    Returns
    -------
    Path
        The archive.

    Raises
    ------
    InputError
        The folder holds no run, or another process writes to it; the archive exists, or cannot be
        there.
    StaffaError
        A file cannot be read, or the archive not be written.
    """
    directory = path_of(directory, "directory")
    _require_run(directory)
    whole = directory.resolve()
    archive = whole.with_name(f"{whole.name}.zip") if file is None else path_of(file, "file")
    _require_place(archive, whole)
    try:
        with opened_aside(archive) as content:
            _pack(directory, content)
    except OSError as error:
        raise StaffaError(
            f"{archive} cannot be made ({error.strerror or error}); name a place for it with --out"
        ) from None
    return archive


def described(directory: Path) -> Path:
    """Write the description of a run or an ensemble into its directory, and return the file.

    Raises
    ------
    InputError
        The folder holds no run, or another process writes to it.
    StaffaError
        A file cannot be read, or the directory not be written to.
    """
    _require_run(directory)
    try:
        write_crate(directory)
    except OSError as error:
        raise StaffaError(
            f"{directory / CRATE} cannot be written ({error.strerror}); see to that first, or "
            f"pack the run elsewhere with --zip and --out"
        ) from None
    return directory / CRATE


def _require_run(directory: Path) -> None:
    require_no_study(directory, ensembles=True)
    if not is_ensemble(directory):
        open_run(directory)  # or it is refused
    if is_being_written(directory):
        raise InputError(
            f"{directory} is being written to; wait for the end of the run, or stop it"
        )
    for file in unspelled_files(directory):
        warn(StaffaWarning(f"{file} is left out: rename it, its name is not UTF-8"), stacklevel=3)


def _require_place(archive: Path, directory: Path) -> None:
    if archive.exists() or archive.is_symlink():
        raise InputError(f"{archive} exists; remove it, or name another one with --out")
    if directory in archive.resolve().parents:
        raise InputError(f"--out {archive} lies inside the run; name a place outside of it")
    if not archive.parent.is_dir() or not os.access(archive.parent, os.W_OK):
        raise InputError(
            f"--out {archive} cannot be made: {archive.parent} is no folder that you may write to"
        )


def _pack(directory: Path, archive: IO[bytes]) -> None:
    files = crate_files(directory)
    with ZipFile(archive, "w", ZIP_DEFLATED) as packed:
        packed.writestr(_entry(CRATE), crate_text(directory, files))
        for file in files:
            entry = _entry(file.relative_to(directory).as_posix())
            entry.file_size = file.stat().st_size  # or a large one would be refused
            with file.open("rb") as content, packed.open(entry, "w") as copy:
                while piece := content.read(PIECE):
                    copy.write(piece)


def _entry(name: str) -> ZipInfo:
    entry = ZipInfo(name, DATE)
    entry.compress_type = ZIP_DEFLATED
    entry.external_attr = 0o644 << 16
    return entry
