"""Requests to stop a run: by a signal, or because its wall time is nearly over."""

import os
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter
from types import FrameType

from staffa.errors import StaffaError

SIGNALS = (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGQUIT)
# A launcher and a terminal may both pass on one Ctrl-C; within this time (s) it is the same one.
ONCE = 1.0
# Time left after the last look: this multiple of the longest time between two looks, and seconds to
# save and to end.
MARGIN, SECONDS = 2.0, 1.0


class Stopping:
    """Requests to stop."""

    def __init__(self, wall_time: float | None = None) -> None:
        """Start the clock.

        Parameters
        ----------
        wall_time : longest time of the run (s); None for any.
        """
        self._wall_time, self._began = wall_time, perf_counter()
        self._asked: str | None = None
        self._at = self._looked = self._longest = 0.0

    def left(self) -> float | None:
        """Return the time that is left of the wall time (s); None without one."""
        return None if self._wall_time is None else self._wall_time + self._began - perf_counter()

    def reason(self) -> str | None:
        """Return the reason to stop now, or None."""
        now = perf_counter()
        if self._looked:
            self._longest = max(self._longest, now - self._looked)
        self._looked = now
        if self._asked:
            return self._asked
        if self._wall_time is None:
            return None
        left = self._wall_time - (now - self._began)
        return None if left > MARGIN * self._longest + SECONDS else "its wall time is nearly over"

    def _ask(self, number: int, frame: FrameType | None) -> None:
        now = perf_counter()
        if self._asked and now - self._at > ONCE:
            signal.signal(number, signal.SIG_DFL)
            os.kill(os.getpid(), number)
        elif not self._asked:
            self._asked, self._at = f"{signal.Signals(number).name} asked for it", now

    @contextmanager
    def heeded(self, ranks: int = 1) -> Iterator[None]:
        """Let a signal ask to stop in this context; a second one ends the process at once.

        A compiler at work gets the signal too, and fails because of it. On several ranks its
        failure counts as an error all the same: they might wait for the rank with the signal.
        """
        before = {number: signal.signal(number, self._ask) for number in SIGNALS}
        try:
            yield
        except Exception as error:
            if self._asked and ranks == 1 and not isinstance(error, StaffaError):
                raise KeyboardInterrupt from error
            raise
        finally:
            for number, handler in before.items():
                signal.signal(number, handler)
