"""A front of temperature that moves at a steady speed, found in the formula of a case."""

from dataclasses import dataclass

import numpy as np

from staffa.case.schema.case import Case
from staffa.case.values.temperature_formula import temperature_change

ALONG, TIMES = 801, 41  # places along an axis and times at which the formula is looked at
FEWEST = 6  # of these times, with the middle of the front in the body
# Part of the body's extent: what the middle departs from a steady motion by, at most.
STEADY = 0.01
LEAST = 0.1  # part of the body's extent that the middle passes, at least
SAME = 1e-6  # part of the span by which a front that is flat may differ between two lines along it


@dataclass(frozen=True, kw_only=True)
class MovingFront:
    """Front that moves along an axis.

    Attributes
    ----------
    axis : the axis, 0 for x.
    speed : of the isotherm of half the change (m/s), negative if it moves towards lower x.
    length : the change of temperature over its steepest slope (m), kappa/V of a steady front.
    span : the largest less the least change (K).
    width : least extent of the body across the axis (m).
    """

    axis: int
    speed: float
    length: float
    span: float
    width: float


def moving_front(case: Case, last: float) -> MovingFront | None:
    """Return the front that temperature.T moves through the body; None without one.

    Parameters
    ----------
    case : the case.
    last : end of the run (s).
    """
    if case.temperature.T is None:
        return None
    found = (_along(case, last, axis) for axis in range(case.dim))
    return next((front for front in found if front is not None), None)


def _along(case: Case, last: float, axis: int) -> MovingFront | None:
    """Return the front that moves along one axis."""
    lower, upper = np.array(case.outline.lower), np.array(case.outline.upper)
    places = np.linspace(lower[axis], upper[axis], ALONG)
    times = np.linspace(0.0, last, TIMES)
    middle = _changes(case, places, times, (lower + upper) / 2, axis)
    span, extent = float(np.ptp(middle)), float(upper[axis] - lower[axis])
    if span == 0 or np.abs(middle - _changes(case, places, times, lower, axis)).max() > SAME * span:
        return None
    above = middle > (middle.max() + middle.min()) / 2
    crossed = np.diff(above, axis=1)
    once = crossed.sum(axis=1) == 1
    if once.sum() < FEWEST:
        return None
    at = places[crossed[once].argmax(axis=1)]
    speed, start = np.polyfit(times[once], at, 1)
    off = float(np.abs(start + speed * times[once] - at).max())
    if off > STEADY * extent or float(np.ptp(at)) < LEAST * extent:
        return None
    steepest = float(np.abs(np.diff(middle, axis=1)).max()) / float(places[1] - places[0])
    across = np.delete(upper - lower, axis)
    return MovingFront(
        axis=axis,
        speed=float(speed),
        length=span / steepest,
        span=span,
        width=float(across.min()),
    )


def _changes(
    case: Case, places: np.ndarray, times: np.ndarray, through: np.ndarray, axis: int
) -> np.ndarray:
    """Return changes of temperature (K) on a line along an axis, shape (times, places)."""
    x = np.zeros((3, len(places)))
    x[: case.dim] = through[:, None]
    x[axis] = places
    change = temperature_change(case)
    return np.array([change(x, float(time)) for time in times])
