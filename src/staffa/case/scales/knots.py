"""Times at which steps end, so that straight lines between them tell what a case prescribes."""

from collections.abc import Sequence
from dataclasses import dataclass
from heapq import heappop, heappush

import numpy as np
import scipy

# Between two knots no value departs from the straight line by more than this part of its range.
DEPART = 0.02
# Knots of a value at most, besides its ends: a log of 10,000 noisy rows has no more.
MOST = 500
# What begins at a knot is felt once the value has left its trend by this part of its range.
FELT = 0.1


@dataclass(frozen=True, kw_only=True)
class Knots:
    """Times that describe a value in time.

    Attributes
    ----------
    times : jumps, extremes and kinks (s), increasing, the ends included, shape (n,).
    depart : largest departure of the value from linear interpolation between `times`, as a part of
        its range.
    onsets : (time, length) (s) of each change that begins at a time, a steeper or reversed trend,
        with the time in which it is felt.
    """

    times: np.ndarray
    depart: float
    onsets: tuple[tuple[float, float], ...]


def knots(
    t: np.ndarray,
    values: np.ndarray,
    *,
    through: Sequence[float] = (),
    depart: float = DEPART,
    most: int = MOST,
) -> Knots | None:
    """Find the knots of a value.

    The extremes that stand out by `depart` come first, the most prominent ones if there are too
    many; then the part between two knots that departs the most is cut where it does, until none
    departs by more (Douglas and Peucker 1973).

    Parameters
    ----------
    t : times (s), increasing, shape (n,).
    values : at these times and at some places, shape (n, m).
    through : times among t (s) that are visited anyway: knots from the start.
    depart : see DEPART.
    most : see MOST; those of `through` do not count.

    Returns
    -------
    None of a value that does not change.
    """
    extent = float(np.ptp(values, axis=0).max()) if len(t) > 1 else 0.0
    if extent == 0.0:
        return None
    given = {0, len(t) - 1, *np.searchsorted(t, np.array(through, dtype=float)).tolist()}
    found = given | {*_extremes(values, depart * extent, most)}
    most += len(given)
    waiting: list[tuple[float, int, int, int]] = []
    for a, b in zip(sorted(found), sorted(found)[1:], strict=False):
        _weigh(waiting, t, values, a, b)
    while waiting and -waiting[0][0] > depart * extent and len(found) < most:
        _, a, middle, b = heappop(waiting)
        found.add(middle)
        _weigh(waiting, t, values, a, middle)
        _weigh(waiting, t, values, middle, b)
    at = np.array(sorted(found))
    left = -waiting[0][0] / extent if waiting else 0.0
    return Knots(times=t[at], depart=left, onsets=_onsets(t[at], values[at], extent))


def departure(t: np.ndarray, values: np.ndarray, visited: np.ndarray) -> tuple[float, float]:
    """Return the largest departure of a value from linear interpolation between some times.

    Parameters
    ----------
    t, values : see `knots`.
    visited : times between which the value is interpolated (s), increasing.

    Returns
    -------
    The departure as a part of the value's range, and its time (s).
    """
    extent = float(np.ptp(values, axis=0).max())
    lines = np.array([np.interp(t, visited, np.interp(visited, t, v)) for v in values.T])
    apart = np.abs(values - lines.T).max(axis=1)
    worst = int(apart.argmax())
    return (float(apart[worst]) / extent if extent else 0.0), float(t[worst])


def excursion(t: np.ndarray, values: np.ndarray, visited: np.ndarray) -> tuple[float, float]:
    """Return how far a value leaves the range of its values at the two visited times around.

    Parameters
    ----------
    t, values : see `knots`.
    visited : times at which steps end (s), increasing.

    Returns
    -------
    The distance as a part of the value's range, and its time (s).
    """
    extent = float(np.ptp(values, axis=0).max())
    after = np.searchsorted(visited, t).clip(min(1, len(visited) - 1), len(visited) - 1)
    there = np.array([np.interp(visited, t, v) for v in values.T]).T
    one, other = there[np.maximum(after - 1, 0)], there[after]
    above, below = values - np.maximum(one, other), np.minimum(one, other) - values
    apart = np.maximum(above, below).max(axis=1)
    worst = int(apart.argmax())
    return (max(float(apart[worst]), 0.0) / extent if extent else 0.0), float(t[worst])


def _extremes(values: np.ndarray, prominence: float, most: int) -> list[int]:
    """Return indices of peaks and troughs, both edges of level ones, that exceed a prominence."""
    found: dict[int, float] = {}
    for column in (*values.T, *(-values).T):
        _, told = scipy.signal.find_peaks(column, prominence=prominence, plateau_size=1)
        for edge in ("left_edges", "right_edges"):
            for index, height in zip(told[edge].tolist(), told["prominences"], strict=True):
                found[index] = max(found.get(index, 0.0), float(height))
    return sorted(found, key=lambda index: (-found[index], index))[:most]


def _weigh(
    waiting: list[tuple[float, int, int, int]], t: np.ndarray, values: np.ndarray, a: int, b: int
) -> None:
    """Put the part between two indices in a heap, by minus its departure, with where that is."""
    if b - a < 2:
        return
    inner = slice(a + 1, b)
    share = ((t[inner] - t[a]) / (t[b] - t[a]))[:, None]
    apart = np.abs(values[inner] - (values[a] + share * (values[b] - values[a]))).max(axis=1)
    worst = int(apart.argmax())
    heappush(waiting, (-float(apart[worst]), a, a + 1 + worst, b))


def _onsets(t: np.ndarray, values: np.ndarray, extent: float) -> tuple[tuple[float, float], ...]:
    """Return the onsets of a value that is piecewise linear in time, see `Knots`."""
    slopes = np.diff(values, axis=0) / np.diff(t)[:, None]
    before, after = np.vstack([np.zeros_like(slopes[:1]), slopes[:-1]]), slopes
    begins = (np.abs(after) > np.abs(before)) | (after * before < 0)
    change = np.where(begins, np.abs(after - before), 0.0).max(axis=1)
    starts = zip(t[:-1].tolist(), change.tolist(), strict=True)
    return tuple((start, FELT * extent / much) for start, much in starts if much > 0)
