"""Compilation of forms, with the vector instructions that the processors of all ranks have."""

import os
import stat
import tempfile
import warnings
from collections.abc import Callable
from contextlib import nullcontext
from functools import cache, singledispatchmethod
from pathlib import Path
from typing import Any

from staffa.backend.stack import MPI

import ufl
from dolfinx import fem
from dolfinx.jit import get_options
from ffcx.options import get_options as form_options
from ufl.corealg.dag_traverser import DAGTraverser

from staffa.backend.isolation import elsewhere
from staffa.backend.lock import Lock
from staffa.backend.parallel import any_over_ranks, on_root
from staffa.errors import StaffaWarning

# Both read their settings once: from the home folder alone, not from the current one.
with elsewhere():
    CACHE = Path(get_options()["cache_dir"]).with_name("staffa")
    form_options()

# Sums may be reordered, which vector instructions need; NaN and infinity keep their meaning.
# Measured on the bricks of the benchmark: the stiffness is assembled 2.2 times faster than by
# DOLFINx's own "-O2", vectors 3 times.
FLAGS = [
    "-O3",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fno-signed-zeros",
    "-fassociative-math",
]
# In place of these, for tests: they compile hundreds of forms and compute little with each.
INSTEAD = "STAFFA_CFLAGS"
VECTOR = {"avx2": "-mavx2", "fma": "-mfma"}
# After so long (s) a form that another process seems to compile is looked after.
PATIENCE = 5
# And on a file system without locks, where nothing can be done about it.
WITHOUT_LOCKS = 300
# Python lists a whole folder for each form that it looks for, so forms are spread over folders by
# the first digits of their signatures. Measured: 54 ms a form where one folder has 9,000 of them.
EXPRESSIONS = "expressions"
FOLDERS = (*(f"{number:02x}" for number in range(256)), EXPRESSIONS)


def _keep_no_traversers(kind: type = DAGTraverser) -> None:
    """Let UFL's traversers go with their meshes, each of which has communicators of MPI.

    In the first releases of Python 3.13 methods of single dispatch keep all objects that they were
    called on (github.com/python/cpython, issue 127750).
    """
    for method in vars(kind).values():
        if isinstance(method, singledispatchmethod) and hasattr(method, "_method_cache"):
            method._method_cache = None
    narrower: type
    for narrower in kind.__subclasses__():
        _keep_no_traversers(narrower)


_keep_no_traversers()


def form(expression: ufl.Form, comm: MPI.Comm) -> fem.Form:
    """Return a form, compiled or from the cache. Collective."""
    part = expression.signature()[:2]
    return _compiled(lambda options: fem.form(expression, jit_options=options), part, comm)


def expression(value: Any, points: Any, comm: MPI.Comm) -> fem.Expression:
    """Compile an expression at points of the reference cell, as `form` does. Collective.

    Parameters
    ----------
    value : the UFL expression.
    points : points of the reference cell, shape (n, dim).
    comm : the ranks that share the compiled code.
    """

    def make(options: dict[str, Any]) -> fem.Expression:
        return fem.Expression(value, points, jit_options=options)

    return _compiled(make, EXPRESSIONS, comm)


@cache
def cache_folder() -> Path:
    """Return the folder of compiled forms: one that this user owns, since what lies there is run.

    That is CACHE or, where it belongs to someone else, may be written to by all or cannot be
    written to, a folder for temporary files, which a warning names.
    """
    if _is_own(CACHE):
        return CACHE
    instead = Path(tempfile.gettempdir()) / f"staffa-{os.getuid()}"
    if not _is_own(instead):
        instead = Path(tempfile.mkdtemp(prefix="staffa-"))
    warnings.warn(
        f"compiled forms cannot be kept in {CACHE}, which is not this user's alone to write to; "
        f"they are kept in {instead} as long as that is there; XDG_CACHE_HOME names another folder",
        StaffaWarning,
        stacklevel=2,
    )
    return instead


def _is_own(folder: Path) -> bool:
    """Make a folder if there is none; whether it is one that this user alone may write to."""
    try:
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        found = folder.lstat() if folder.parent == Path(tempfile.gettempdir()) else folder.stat()
    except OSError:
        return False
    own = stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid()
    return own and not found.st_mode & stat.S_IWOTH and os.access(folder, os.W_OK)


def _compiled[Compiled](
    make: Callable[[dict[str, Any]], Compiled], part: str, comm: MPI.Comm
) -> Compiled:
    """Return what `make` compiles: rank 0 compiles it, then the other ranks load it.

    A process that is killed while it compiles leaves a source in the cache that others would wait
    for in vain. Whoever compiles shares a lock, so that one who has it alone may remove these.

    Parameters
    ----------
    make : compiles with the options that it gets.
    part : one of `FOLDERS`, in which the compiled code lies.
    comm : the ranks that share it.
    """
    folder = on_root(comm, cache_folder)
    compiler, patience = flags(comm), PATIENCE
    if comm.rank == 0:
        _clear_once(folder)
    while True:
        options = {
            "cffi_extra_compile_args": compiler,
            "timeout": patience,
            "cache_dir": folder / part,
        }
        try:
            with Lock(folder).held(shared=True) if comm.rank == 0 else nullcontext():
                return make(options)
        except (TimeoutError, RuntimeError) as problem:
            late = comm.bcast("timed out" in str(problem), root=0)
            if not late or patience > PATIENCE:
                raise
        alone = comm.bcast(comm.rank == 0 and _clear(folder, wait=True), root=0)
        patience = PATIENCE if alone else WITHOUT_LOCKS


def flags(comm: MPI.Comm) -> list[str]:
    """Return the flags of the C compiler, by which compiled code is cached. Collective."""
    here = _features()
    vector = [flag for name, flag in VECTOR.items() if not any_over_ranks(comm, name not in here)]
    return [*chosen_flags(), *vector]


def chosen_flags() -> list[str]:
    """Return the flags of the C compiler without vector ones; they decide the last digits."""
    return os.environ[INSTEAD].split() if INSTEAD in os.environ else FLAGS


@cache
def _clear_once(folder: Path) -> None:
    """Remove these sources as this process begins, if no other one is compiling."""
    _clear(folder, wait=False)


def _clear(folder: Path, *, wait: bool) -> bool:
    """Remove sources that were never compiled, if no process is compiling; return whether none is.

    Parameters
    ----------
    folder : the folder of compiled forms.
    wait : whether to wait until no process is compiling.
    """
    folder.mkdir(parents=True, exist_ok=True)
    with Lock(folder).held(wait=wait) as alone:
        for part in (folder / name for name in FOLDERS) if alone else ():
            names = set(os.listdir(part)) if part.is_dir() else set()
            for name in names:
                if name.endswith(".c") and f"{name}.cached" not in names:
                    (part / name).unlink(missing_ok=True)
    return alone


@cache
def _features() -> set[str]:
    """Return the names of `VECTOR` that this processor has, by Linux's list; none elsewhere."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return set()
    words = next((line.split() for line in lines if line.startswith("flags")), [])
    return set(VECTOR) & set(words)
