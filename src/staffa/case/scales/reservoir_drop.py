"""The drop of temperature that circulating water can bring about, before a run."""

import numpy as np

from staffa.case.schema.case import Case
from staffa.case.values.property_functions import in_space
from staffa.case.values.reservoir_places import reservoir_keys


def reservoir_drop(case: Case) -> float:
    """Return the largest drop (K) of the body below its temperature before the first step.

    With a simulator that to the coldest water that a well injects, which no rock passes; with files
    the largest one in them, at the vertices of the body that are looked at.
    """
    keys = reservoir_keys(case)
    if keys.fields is not None:
        return _of_fields(case)
    x = case.outline.places.on()
    warmest = float(np.max(in_space(keys.temperature, case.dim)(x)))
    return max(0.0, warmest - coldest_water(case))


def coldest_water(case: Case) -> float:
    """Return the lowest temperature (K) of injected water."""
    return min(float(well.T) for well in reservoir_keys(case).wells if well.T is not None)


def _of_fields(case: Case) -> float:
    keys = reservoir_keys(case).fields
    assert keys is not None
    x = case.outline.places.on()
    series = keys.series.reaching(case.outline.h)
    return max(0.0, *(float(-np.min(series.temperature(x, t))) for t in series.t))
