"""Means over the members of an ensemble, and their standard errors."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import sqrt
from statistics import fmean, stdev

import numpy as np


@dataclass(frozen=True, kw_only=True)
class Average:
    """Mean of a number over the members that have it.

    Attributes
    ----------
    mean : mean; None without a member.
    error : standard error of the mean; None with fewer than two members.
    members : number of members that have the number.
    """

    mean: float | None
    error: float | None
    members: int


def average(values: Sequence[float | None]) -> Average:
    """Return the mean and its standard error.

    The error is s/sqrt(n), with s^2 = sum (x - mean)^2/(n - 1).

    Parameters
    ----------
    values : number of each member; a member without one, None, is left out.
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
    """Series of several members, brought to common times.

    Attributes
    ----------
    at : common times, shape (n,).
    values : value of each member at each time, shape (members, n).
    mean : mean over the members, shape (n,).
    error : standard error of the mean, shape (n,).
    """

    at: np.ndarray
    values: np.ndarray
    mean: np.ndarray
    error: np.ndarray


def mean_over_time(
    series: Sequence[tuple[Sequence[float], Sequence[float]]], *, linear: bool = False
) -> Spread:
    """Bring the series of at least two members to common times, and average them at each.

    A state lasts until the next step, so a value is a step function of time: the value of the last
    step that is not later. A production curve is linear between two steps. The common times are
    those of all members, from the latest first time to the earliest last time: nothing is known of
    a member outside its own times.

    Parameters
    ----------
    series : of each member, increasing times and the value at each of them.
    linear : True for values that are linear between two steps.
    """
    first, last = max(at[0] for at, _ in series), min(at[-1] for at, _ in series)
    union = np.unique(np.concatenate([np.asarray(at, dtype=float) for at, _ in series]))
    clock = union[(union >= first) & (union <= last)]
    rows = [
        np.interp(clock, at, values)
        if linear
        else np.asarray(values, dtype=float)[np.searchsorted(at, clock, side="right") - 1]
        for at, values in series
    ]
    values = np.array(rows).reshape(len(series), len(clock))
    error = values.std(axis=0, ddof=1) / sqrt(len(series))
    return Spread(at=clock, values=values, mean=values.mean(axis=0), error=error)
