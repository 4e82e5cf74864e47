"""The times that a run visits."""

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Schedule:
    """Times (s) in increasing order, and whether each was asked for as an output."""

    times: tuple[float, ...]
    requested: tuple[bool, ...]


def schedule(times: Sequence[float], requested: Sequence[float] = ()) -> Schedule:
    """All times and all requested ones, each once; the requested ones are hit exactly.

    A time closer to a requested one than 1e-9 of the whole is replaced by it.
    """
    near = 1e-9 * max((*times, *requested))
    kept = [t for t in times if all(abs(t - r) > near for r in requested)]
    visited = sorted([*kept, *requested])
    return Schedule(times=tuple(visited), requested=tuple(t in set(requested) for t in visited))
