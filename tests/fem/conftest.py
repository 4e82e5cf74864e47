"""Reading of meshes and fields in this process, as these tests trust their files.

Reading of a stranger's file in a separate process is tested in `case/test_fuzz.py` and
`run/test_attack.py`; such a process takes half a second.
"""

from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from staffa.backend import guarded_reading
from staffa.errors import InputError


def read_here[Read](
    kind: type[Read], function: str, file: Path, arguments: Sequence[Any], *, where: str
) -> Read:
    """Call a function that reads a file, and take what it returns apart and together again."""
    module, _, name = function.partition(":")
    try:
        found = getattr(import_module(module), name)(file.absolute(), *arguments)
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"{where}: what reads it failed: the file is damaged") from error
    head, arrays = guarded_reading._told(found)
    return kind(**{key: guarded_reading._made(key, told, arrays) for key, told in head.items()})


@pytest.fixture(autouse=True)
def files_are_read_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Read files without a process for each."""
    for reader in ("staffa.case.reading.inspect_mesh", "staffa.properties.mesh_field"):
        monkeypatch.setattr(f"{reader}.read_apart", read_here)
