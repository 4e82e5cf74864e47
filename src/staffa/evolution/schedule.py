"""The times that a run visits: those given, or steps that follow the cracks and the cold."""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

# Times that differ by less than this part of themselves are one.
SAME = 1e-9
# A step is made to bring this much of the advance it may bring: the next one brings a little more.
SAFETY = 0.8
# A step is longer than the one before by this factor at most, and cut by it where it went too far.
FACTOR = 2.0


def time_itself(time: float) -> float:
    """The clock of a run that counts in time itself."""
    return time


# Cracks run by whole cells, often just as far as they may: round-off decides nothing.
TIE = 1 + 1e-9


# An onset: cooling that begins at t = 0, and is felt at once.
FROM_THE_START = (0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class Pace:
    """How long steps are, on the clock that the run counts in.

    shortest, longest: bounds; but a step that ends at a time of the schedule, or at a knot, may be
    shorter. advance: how far cracks may run in a step (m); one in which they ran farther is taken
    again, FACTOR shorter, unless it is the shortest, or the first, or one that backtracking came
    back to. growth: by which fraction sqrt(kappa t) may grow in a step, t since the last onset,
    None where nothing diffuses. knots: times (s), increasing, at which a step ends: jumps, extremes
    and kinks of what is prescribed. onsets: (time, length) (s), increasing: when heat begins to
    enter or leave in another way, and in which time that is felt, during which steps may be as long
    as it. clock: time (s) -> clock, which grows with it; time_at: back.
    """

    shortest: float
    longest: float
    advance: float
    growth: float | None = None
    knots: tuple[float, ...] = ()
    onsets: tuple[tuple[float, float], ...] = (FROM_THE_START,)
    clock: Callable[[float], float] = time_itself
    time_at: Callable[[float], float] = time_itself

    def ceiling(self, time: float) -> float:
        """The longest step from this time (s)."""
        if self.growth is None:
            return self.longest
        ends = self._layers_end(time, self.growth)
        grown = self.clock(ends) - self.clock(time)
        return max(self.shortest, min(self.longest, grown))

    def _layers_end(self, time: float, growth: float) -> float:
        """The time (s) at which the first of the layers of cold has grown by a fraction."""
        begun = (onset for onset in self.onsets if onset[0] <= time)
        return min(
            max(start + (1 + growth) ** 2 * (time - start), time + felt) for start, felt in begun
        )


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


def schedule(
    times: Sequence[float], requested: Sequence[float] = (), pace: Pace | None = None
) -> Schedule:
    """All times and all requested ones, each once; the requested ones are hit exactly.

    A time closer to a requested one than SAME of it is replaced by it; so are knots of the pace,
    which end with the last time.
    """
    outputs = set(requested)
    visited = sorted([*_apart(times, requested), *requested])
    asked = tuple(t in outputs for t in visited)
    if pace is not None:
        within = [t for t in pace.knots if t < visited[-1]]
        pace = replace(pace, knots=tuple(_apart(within, visited)))
    return Schedule(times=tuple(visited), requested=asked, pace=pace)


def _apart(times: Sequence[float], others: Sequence[float]) -> list[float]:
    """The times that none of the others is the same as."""
    around = np.array([-np.inf, *sorted(others), np.inf])
    t = np.array(times, dtype=float)
    after = np.searchsorted(around, t)
    far = np.minimum(t - around[after - 1], around[after] - t) > SAME * t
    return [time for time, kept in zip(times, far, strict=True) if kept]


class AdaptiveSteps:
    """A schedule as it is walked: the time of the next step, and how long steps are now.

    start: the time (s) that the next step begins at, None before the first step; length: of steps
    now, on the clock. Both together are all that a walk must know to go on.
    """

    def __init__(
        self, plan: Schedule, start: float | None = None, length: float | None = None
    ) -> None:
        self._plan = plan
        self.start = start
        longest = plan.pace.longest if plan.pace else 0.0
        self.length = min(length, longest) if length else longest  # none, or of a plan without pace
        self._step = 0.0  # on the clock, as it was chosen: of a difference, round-off could decide

    def next(self) -> float | None:
        """The time (s) that the next step leads to; None at the end.

        The last two steps before a time of the schedule, or a knot, are equal, if long enough.
        """
        start, pace = self.start, self._plan.pace
        if start is None:
            return self._target(-np.inf)
        target = self._target(start)
        if target is None or pace is None:
            return target
        left = pace.clock(target) - pace.clock(start)
        self._step = min(self.length, pace.ceiling(start))
        if self._step < left < 2 * self._step and left / 2 >= pace.shortest:
            self._step = left / 2
        if self._step * TIE >= left:
            self._step = left
            return target
        return pace.time_at(pace.clock(start) + self._step)

    def _target(self, start: float) -> float | None:
        """The first time (s) after another at which a step ends whatever cracks do."""
        plan = self._plan
        ends = (plan.times, plan.pace.knots if plan.pace else ())
        after = [times[bisect_right(times, start) :][:1] for times in ends]
        return min((t for times in after for t in times), default=None)

    def goes_too_far(self, ran: float) -> bool:
        """Whether a step in which cracks ran so far (m) is to be taken again, then shorter."""
        pace = self._plan.pace
        if pace is None or self.start is None or ran <= pace.advance * TIE:
            return False
        if self._step <= pace.shortest * TIE:
            return False
        self.length = max(self._step / FACTOR, pace.shortest)
        return True

    def onward(self, time: float, ran: float) -> None:
        """Go on from this time (s), after a step in which cracks ran so far (m).

        The first step begins from nothing: what it cracked says nothing of the next.
        """
        pace = self._plan.pace
        if pace and self.start is not None:
            most = FACTOR * self.length
            fitting = SAFETY * pace.advance * self._step / ran if ran > 0 else most
            self.length = min(max(min(fitting, most), pace.shortest), pace.longest)
        self.start = time

    def back(self, time: float) -> None:
        """Go on from this earlier time (s), where there are cracks now, with short steps."""
        if self._plan.pace:
            self.length = self._plan.pace.shortest
        self.start = time
