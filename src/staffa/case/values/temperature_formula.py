"""The formula of temperature.T, and the changes of temperature that it gives."""

import numpy as np

from staffa.case.schema.case import Case
from staffa.loads.forces import InSpaceAndTime
from staffa.properties.formula import formula, formula_variables

SAMPLES = 101  # times at which it is looked at: evenly, and as many that crowd at the start


def temperature_change(case: Case) -> InSpaceAndTime:
    """Return the change of temperature (K) of a case with profile "formula"."""
    assert case.temperature.T is not None  # a rule of cases
    return formula(case.temperature.T, formula_variables(case.dim))


def change_range(case: Case, last: float) -> tuple[float, float]:
    """Return the least and the largest change (K) at sampled places, the 0 of the start included.

    Parameters
    ----------
    case : a case with profile "formula".
    last : end of the run (s).
    """
    change, x = temperature_change(case), case.outline.places.on()
    shares = np.linspace(0.0, 1.0, SAMPLES)
    found = [change(x, last * float(share)) for share in (*shares, *shares**4)]
    return min(0.0, float(np.min(found))), max(0.0, float(np.max(found)))
