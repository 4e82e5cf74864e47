"""Means of numbers that not every member of an ensemble has, and their standard errors."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from statistics import fmean, stdev

import numpy as np


@dataclass(frozen=True, kw_only=True)
class Average:
    """The mean of the members that have a number, its standard error, and how many they are.

    mean: None without a member; error: None with fewer than two.
    """

    mean: float | None
    error: float | None
    members: int


def average(values: Sequence[float | None]) -> Average:
    """Mean and standard error of the mean, s/sqrt(n) with s^2 = sum (x - mean)^2/(n - 1).

    A member without the number, None, is left out.
    """
    known = [value for value in values if value is not None]
    n = len(known)
    return Average(
        mean=fmean(known) if known else None,
        error=stdev(known) / sqrt(n) if n > 1 else None,
        members=n,
    )


@dataclass(frozen=True, kw_only=True)
class Spread:
    """What members did on one clock: times (n,), values (members, n), mean (n,), error (n,)."""

    at: np.ndarray
    values: np.ndarray
    mean: np.ndarray
    error: np.ndarray


def mean_over_time(series: Sequence[tuple[Sequence[float], Sequence[float]]]) -> Spread:
    """Put at least two members on one clock, and average them at each of its times.

    A state lasts until the next step, so that a value is a step function of the time: the one at
    the last step that is not later. The clock has the times of all members, from the latest first
    one to the earliest last one, since nothing is known of a member outside its own.

    Parameters
    ----------
    series : increasing times, and the value at each of them, of every member.
    """
    first, last = max(at[0] for at, _ in series), min(at[-1] for at, _ in series)
    union = np.unique(np.concatenate([np.asarray(at, dtype=float) for at, _ in series]))
    clock = union[(union >= first) & (union <= last)]
    rows = [
        np.asarray(values, dtype=float)[np.searchsorted(at, clock, side="right") - 1]
        for at, values in series
    ]
    values = np.array(rows).reshape(len(series), len(clock))
    error = values.std(axis=0, ddof=1) / sqrt(len(series))
    return Spread(at=clock, values=values, mean=values.mean(axis=0), error=error)
