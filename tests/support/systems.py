"""Systems that a test builds and leaves behind are destroyed when the test is over.

PETSc objects hold Python functions that hold them in turn, a circle that the garbage collector
does not see: what is not destroyed stays, with the communicators of its mesh. MPICH has 2048.
A system that something still holds (a cached function, a fixture of a module) is left alone.
"""

import copy
import gc
import weakref
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from staffa.evolution.system import System

# Systems that are not collected yet, by their vector u, each with a copy that shares its parts; and
# copies of those that were collected and not destroyed. Variants that `replace` makes of a system
# share its u and its parts, and count once with it.
_built: dict[int, weakref.finalize] = {}
_left: list[System] = []

_init = System.__init__


def _noted(system: System, *args: Any, **kwargs: Any) -> None:
    _init(system, *args, **kwargs)
    handle = system.alternation.u.handle
    if handle not in _built:
        _built[handle] = weakref.finalize(system, _leave, handle, copy.copy(system))


def _leave(key: int, parts: System) -> None:
    del _built[key]
    if parts.alternation.u:  # not destroyed yet
        _left.append(parts)


System.__init__ = _noted  # type: ignore[method-assign]


@contextmanager
def destroyed_when_left() -> Iterator[None]:
    """Destroy, at the end, all systems that nothing holds any more."""
    before = set(_built.values())
    yield
    if set(_built.values()) - before:
        gc.collect()  # a circle in Python may hold a system that nobody needs
    while _left:
        _left.pop().destroy()
