"""Step of TR-BDF2: its coefficients, and the parts common to linear and nonlinear rock."""

from dataclasses import dataclass
from math import sqrt

import numpy as np

from staffa.heat.operators import HeatOperators

GAMMA = 2 - sqrt(2)
D, W = GAMMA / 2, sqrt(2) / 4
WEIGHTS = np.array([W, W, D])
EMBEDDED = np.array([(1 - W) / 3, (1 + 3 * W) / 3, D / 3])


@dataclass(frozen=True, kw_only=True)
class Tried:
    """Step that was tried.

    Attributes
    ----------
    T : temperature after it (K), owned entries.
    error : its error over the tolerance.
    entered : heat that entered by cause (J), on this rank.
    """

    T: np.ndarray
    error: float
    entered: dict[str, float]


def by_cause(
    at: HeatOperators, taken: np.ndarray, gain: np.ndarray, entering: dict[str, np.ndarray]
) -> dict[str, float]:
    """Return the heat that enters the body by cause (W), of this rank's vertices.

    On a Dirichlet boundary it is the heat that its vertices take up beyond the rest.

    Parameters
    ----------
    at : operators of the body.
    taken : heat that the Dirichlet vertices take up (W), shape (n_held,).
    gain : heat that all vertices gain from neighbors and causes (W), shape (n_owned,).
    entering : the part of it from each cause (W), shape (n_owned,) each.
    """
    found = {name: float(part.sum()) for name, part in entering.items()}
    needed = taken - gain[at.held]
    for name, part in at.held_by_side():
        found[name] = found.get(name, 0.0) + float(needed[part].sum())
    return found
