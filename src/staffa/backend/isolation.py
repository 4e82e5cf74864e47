"""Libraries without what lies in the current folder: it may be a stranger's.

PETSc, FFCx, DOLFINx and Matplotlib read settings from files there, and Python modules; some of
these settings are code. Settings come from the environment and from the home folder alone.
"""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

NOWHERE = "/"  # a folder of the system's


@contextmanager
def elsewhere() -> Iterator[None]:
    """Be in a folder in which no stranger can have put anything, to load a library or its settings.

    Not for threads: the current folder is that of the process.
    """
    here = os.open(".", os.O_RDONLY)
    os.chdir(NOWHERE)
    try:
        yield
    finally:
        os.fchdir(here)
        os.close(here)


def isolated_python(*arguments: str, module: str | None = None) -> list[str]:
    """Return the command of a Python like this one that imports nothing from the current folder.

    Parameters
    ----------
    arguments : of the program, after a module, or its code first of all.
    module : the module that it runs; None for code.
    """
    if module is None:
        code, *rest = arguments
    else:
        code = f"from runpy import run_module; run_module({module!r}, {{}}, '__main__')"
        rest = list(arguments)
    return [sys.executable, "-I", "-c", f"import sys; sys.path[:] = {_paths()}; {code}", *rest]


def _paths() -> list[str]:
    """Return folders of modules, without the current one, unless staffa itself is there."""
    own = str(Path(__file__).resolve().parents[2])
    here = os.path.realpath(".")
    return [
        p for p in sys.path if p and (os.path.realpath(p) != here or os.path.realpath(p) == own)
    ]
