"""Files of HDF5 that may be a stranger's: what they show is in themselves."""

from pathlib import Path
from typing import Any

from staffa.errors import InputError


def require_alone(path: Path, where: str) -> None:
    """Refuse a file of HDF5 that shows what is in another file: a run reads and keeps one.

    Parameters
    ----------
    path : the file.
    where : the key and its value, or the file, with which every sentence begins.

    Raises
    ------
    InputError
        It names another file, or is none of HDF5.
    """
    import h5py  # takes a while to load, and few cases need it

    def look(group: Any) -> None:
        for name in group:
            link = group.get(name, getlink=True)
            if isinstance(link, h5py.ExternalLink):
                raise InputError(
                    f"{where} shows what is in another file, {link.filename}, and a run keeps one; "
                    f"save it as one file"
                )
            found = group[name]
            if isinstance(found, h5py.Group):
                look(found)
            elif isinstance(found, h5py.Dataset) and (found.external or found.is_virtual):
                raise InputError(f"{where} keeps numbers in another file; save it as one file")

    try:
        with h5py.File(path, "r") as file:
            look(file)
    except (OSError, RecursionError, KeyError) as error:
        raise InputError(f"{where}: it cannot be read as HDF5 ({error}); save it again") from None
