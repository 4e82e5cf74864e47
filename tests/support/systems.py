"""Systems that a test builds and leaves behind are destroyed when the test is over.

PETSc objects hold Python functions that hold them in turn, a circle that the garbage collector
does not see: what is not destroyed stays, with the communicators of its mesh. MPICH has 2048.
A system that something still holds (a cached function, a fixture of a module) is left alone.
"""

import copy
import gc
import weakref
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from staffa.evolution.system import System

# Number of systems that are not collected yet, by their vector u: variants that `replace` makes of
# a system share its u and its parts. And a copy of the last one of each u that was collected and
# not destroyed.
_built: Counter[int] = Counter()
_left: list[System] = []

_init = System.__init__


def _noted(system: System, *args: Any, **kwargs: Any) -> None:
    _init(system, *args, **kwargs)
    u = id(system.alternation.u)
    _built[u] += 1
    weakref.finalize(system, _leave, u, copy.copy(system))


def _leave(u: int, parts: System) -> None:
    _built[u] -= 1
    if not _built[u]:
        del _built[u]
        if parts.alternation.u:  # not destroyed yet
            _left.append(parts)


System.__init__ = _noted  # type: ignore[method-assign]


@contextmanager
def destroyed_when_left() -> Iterator[None]:
    """Destroy, at the end, all systems that nothing holds any more."""
    before = _built.total()
    yield
    if _built.total() > before:
        gc.collect()  # a circle in Python may hold a system that nobody needs
    while _left:
        _left.pop().destroy()
