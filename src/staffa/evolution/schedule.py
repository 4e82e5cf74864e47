"""The times that a run visits: those given, or steps that follow the cracks and the cold."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

# A step is made to bring this much of the advance it may bring: the next one brings a little more.
SAFETY = 0.8
# A step is longer than the one before by this factor at most, and cut by it where it went too far.
FACTOR = 2.0


def seconds(time: float) -> float:
    """The clock of a run that counts in time itself."""
    return time


@dataclass(frozen=True, kw_only=True)
class Pace:
    """How long steps are, on the clock that the run counts in.

    shortest, longest: bounds; but a step that ends at a time of the schedule may be shorter.
    advance: how far cracks may run in a step (m); one in which they ran farther is taken again,
    FACTOR shorter, unless it is the shortest. growth: by which fraction sqrt(kappa t) may grow in a
    step, None where nothing diffuses. clock: time (s) -> clock, which grows with it; time_at: back.
    """

    shortest: float
    longest: float
    advance: float
    growth: float | None = None
    clock: Callable[[float], float] = seconds
    time_at: Callable[[float], float] = seconds

    def ceiling(self, time: float) -> float:
        """The longest step from this time (s)."""
        if self.growth is None:
            return self.longest
        grown = self.clock((1 + self.growth) ** 2 * time) - self.clock(time)
        return max(self.shortest, min(self.longest, grown))

    def length_after(self, length: float, step: float, ran: float) -> float:
        """The length to go on with after a step in which cracks ran so far (m)."""
        fitting = SAFETY * self.advance * step / ran if ran > 0 else FACTOR * length
        return min(max(min(fitting, FACTOR * length), self.shortest), self.longest)


@dataclass(frozen=True, kw_only=True)
class Schedule:
    """Times (s) in increasing order, and whether each was asked for as an output.

    pace: how steps between them are chosen; None for none but these times.
    """

    times: tuple[float, ...]
    requested: tuple[bool, ...]
    pace: Pace | None = None

    def wants(self, time: float) -> bool:
        """Whether this time (s) was asked for as an output."""
        return any(t == time and asked for t, asked in zip(self.times, self.requested, strict=True))

    def after(self, time: float, length: float) -> float | None:
        """The next time (s) with steps of this length; None at the end.

        The last two steps before a time of the schedule are equal.
        """
        target = next((t for t in self.times if t > time), None)
        if target is None or self.pace is None:
            return target
        now, end = self.pace.clock(time), self.pace.clock(target)
        step = min(length, self.pace.ceiling(time))
        if step >= (end - now) * (1 - 1e-9):
            return target
        return self.pace.time_at(now + min(step, (end - now) / 2))


def schedule(
    times: Sequence[float], requested: Sequence[float] = (), pace: Pace | None = None
) -> Schedule:
    """All times and all requested ones, each once; the requested ones are hit exactly.

    A time closer to a requested one than 1e-9 of the whole is replaced by it.
    """
    near = 1e-9 * max((*times, *requested))
    kept = [t for t in times if all(abs(t - r) > near for r in requested)]
    visited = sorted([*kept, *requested])
    asked = tuple(t in set(requested) for t in visited)
    return Schedule(times=tuple(visited), requested=asked, pace=pace)


class Walk:
    """A schedule as it is walked: the time of the next step, and how long steps are now."""

    def __init__(self, plan: Schedule) -> None:
        self._plan = plan
        self._length = plan.pace.longest if plan.pace else 0.0

    def first(self) -> float:
        """Where it begins (s)."""
        return self._plan.times[0]

    def onward(self, start: float, end: float, ran: float) -> float | None:
        """The time (s) after a step from start to end in which cracks ran so far; None at the end.

        The first step begins from nothing: its length and what it cracked say nothing of the next.
        """
        pace = self._plan.pace
        if pace and start > 0:
            step = pace.clock(end) - pace.clock(start)
            self._length = pace.length_after(self._length, step, ran)
        return self.resume(end)

    def resume(self, time: float) -> float | None:
        """The time (s) after one that was gone back to, with steps as long as they were."""
        return self._plan.after(time, self._length)

    def again(self, start: float, end: float, ran: float) -> float | None:
        """The nearer time (s) to try if cracks ran too far in a step; None if it may stand."""
        pace = self._plan.pace
        if pace is None or start <= 0 or ran <= pace.advance:
            return None
        now = pace.clock(start)
        step = pace.clock(end) - now
        if step <= pace.shortest * (1 + 1e-9):
            return None
        self._length = max(step / FACTOR, pace.shortest)
        return pace.time_at(now + self._length)
