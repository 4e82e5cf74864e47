"""The temperatures that a case names, between which the properties of its rock are needed."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from staffa.case.rules.time_rules import times_given
from staffa.case.schema.case import Case
from staffa.case.schema.heat_keys import InTime
from staffa.case.values.diffusion_time import times_in
from staffa.case.values.heat_equation import start, temperature

SAMPLES = 21  # times at which a formula is looked at


def temperature_range(case: Case) -> tuple[float, float]:
    """Return the lowest and the highest temperature (K) that a case names.

    They are those of the start, of sides, baths and fluids, and the one free of stress.
    Temperatures that follow from fluxes and sources are left out.
    """
    assert case.heat is not None
    found = [np.ravel(T) for T in _temperatures(case)]
    return min(float(T.min()) for T in found), max(float(T.max()) for T in found)


def _temperatures(case: Case) -> Iterator[np.ndarray]:
    keys, places = case.heat, case.outline.places
    assert keys is not None
    there = places.within().x
    for given in (keys.initial, keys.stress_free):
        if given is not None:
            yield start(case, given)(there)
    last = times_in(case, times_given(case)[-1:])[0]
    for side in case.outline.faces:
        surface = keys.on(side)
        if surface is not None and surface.T is not None:
            yield _in_time(case, surface.T, places.on(side), last)
    if keys.cracks is not None and keys.cracks.T is not None:
        yield _in_time(case, keys.cracks.T, there, last)


def _in_time(case: Case, value: Any, x: np.ndarray, last: float) -> np.ndarray:
    """Return the values over the run, at points x, shape (3, n)."""
    times = {float(t) for t in np.linspace(0.0, last, SAMPLES)}
    if isinstance(value, InTime):
        times |= {float(t) for t in value.t if t <= last}
    function = temperature(case, value)
    return np.concatenate([np.ravel(function(x, t)) for t in sorted(times)])
