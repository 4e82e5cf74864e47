"""Times of a run: given ones, or adaptive steps that follow the cracks and the heat."""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

# Times that differ by less than this part of themselves are the same.
SAME = 1e-9
# A step is chosen for this part of the allowed crack advance: the next one advances a little more.
SAFETY = 0.8
# Largest factor between a step and the one before, and factor by which a rejected step is cut.
FACTOR = 2.0


def time_itself(time: float) -> float:
    """Return the time itself, the clock of a run that counts in time."""
    return time


# Cracks advance by whole cells, often by just the allowed length: round-off must decide nothing.
TIE = 1 + 1e-9


# Onset of cooling that starts at t = 0 and acts at once.
FROM_THE_START = (0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class Pace:
    """Rule for the length of adaptive steps, on the clock of the run (time or tau).

    Attributes
    ----------
    shortest, longest : bounds of a step; a step that ends at a time of the schedule, or at a
        breakpoint, may be shorter.
    advance : largest crack advance in a step (m). A step with more is taken again, FACTOR shorter,
        unless it is the shortest, or the first, or a return of backtracking.
    growth : largest relative growth of sqrt(kappa t) in a step, t since the last onset; None
        without diffusion.
    knots : breakpoints in time (s), increasing, at which a step ends: jumps, extremes and kinks of
        prescribed values.
    onsets : (time, length) (s), increasing: a change of the heat exchange, and the time until it
        acts, during which steps may be as long as that.
    clock : time (s) -> clock, increasing.
    time_at : clock -> time (s).
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
        """Return the longest step from this time (s)."""
        if self.growth is None:
            return self.longest
        ends = self._layers_end(time, self.growth)
        grown = self.clock(ends) - self.clock(time)
        return max(self.shortest, min(self.longest, grown))

    def _layers_end(self, time: float, growth: float) -> float:
        """Return the time (s) at which the first thermal boundary layer has grown by a fraction."""
        started = (onset for onset in self.onsets if onset[0] <= time)
        return min(
            max(start + (1 + growth) ** 2 * (time - start), time + felt) for start, felt in started
        )


@dataclass(frozen=True, kw_only=True)
class Schedule:
    """Times of a run.

    Attributes
    ----------
    times : times (s), increasing.
    requested : True for each that was requested as an output.
    pace : rule for adaptive steps between them; None for these times only.
    """

    times: tuple[float, ...]
    requested: tuple[bool, ...]
    pace: Pace | None = None

    def wants(self, time: float) -> bool:
        """Return True if this time (s) was requested as an output."""
        return any(t == time and asked for t, asked in zip(self.times, self.requested, strict=True))


def schedule(
    times: Sequence[float], requested: Sequence[float] = (), pace: Pace | None = None
) -> Schedule:
    """Return the schedule of all times and all requested ones, each once; requested ones are exact.

    A time closer to a requested one than SAME of it is replaced by it; so are breakpoints of the
    pace, which end with the last time.

    Parameters
    ----------
    times : times (s).
    requested : times of outputs (s).
    pace : rule for adaptive steps; None for none.
    """
    outputs = set(requested)
    visited = sorted([*_apart(times, requested), *requested])
    asked = tuple(t in outputs for t in visited)
    if pace is not None:
        within = [t for t in pace.knots if t < visited[-1]]
        pace = replace(pace, knots=tuple(_apart(within, visited)))
    return Schedule(times=tuple(visited), requested=asked, pace=pace)


def _apart(times: Sequence[float], others: Sequence[float]) -> list[float]:
    """Return the times that differ from all of the others."""
    around = np.array([-np.inf, *sorted(others), np.inf])
    t = np.array(times, dtype=float)
    after = np.searchsorted(around, t)
    far = np.minimum(t - around[after - 1], around[after] - t) > SAME * t
    return [time for time, kept in zip(times, far, strict=True) if kept]


class AdaptiveSteps:
    """Position in a schedule: the next time, and the current length of steps.

    Attributes
    ----------
    start : start of the next step (s); None before the first step.
    length : current length of steps, on the clock.
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
        """Return the end of the next step (s); None at the end.

        The last two steps before a time of the schedule, or a breakpoint, are equal, if long
        enough.
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
        """Return the first time (s) after another at which a step must end."""
        plan = self._plan
        ends = (plan.times, plan.pace.knots if plan.pace else ())
        after = [times[bisect_right(times, start) :][:1] for times in ends]
        return min((t for times in after for t in times), default=None)

    def goes_too_far(self, ran: float) -> bool:
        """Return True if this crack advance (m) is too far; then make the step shorter."""
        pace = self._plan.pace
        if pace is None or self.start is None or ran <= pace.advance * TIE:
            return False
        if self._step <= pace.shortest * TIE:
            return False
        self.length = max(self._step / FACTOR, pace.shortest)
        return True

    def onward(self, time: float, ran: float) -> None:
        """Continue from this time (s), after a step with this crack advance (m).

        The first step starts without cracks: its advance says nothing of the next.
        """
        pace = self._plan.pace
        if pace and self.start is not None:
            most = FACTOR * self.length
            fitting = SAFETY * pace.advance * self._step / ran if ran > 0 else most
            self.length = min(max(min(fitting, most), pace.shortest), pace.longest)
        self.start = time

    def back(self, time: float) -> None:
        """Continue with short steps from this earlier time (s), at which there are cracks now."""
        if self._plan.pace:
            self.length = self._plan.pace.shortest
        self.start = time
