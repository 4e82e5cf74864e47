"""A step of TR-BDF2: its numbers, and what both kinds of rock have in common."""

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
    """A step tried: the temperature after it, its error over the tolerance, what entered (J)."""

    T: np.ndarray
    error: float
    entered: dict[str, float]


def by_cause(
    at: HeatOperators, taken: np.ndarray, gain: np.ndarray, entering: dict[str, np.ndarray]
) -> dict[str, float]:
    """Heat that enters the body (W): on held sides, what their vertices gain beyond the rest.

    Of this rank's own vertices.

    Parameters
    ----------
    taken : heat that the held vertices take up (W), shape (n_held,).
    gain : heat that all vertices gain from neighbors and causes (W), shape (n_owned,).
    entering : the part of it from each cause, likewise.
    """
    found = {name: float(part.sum()) for name, part in entering.items()}
    needed = taken - gain[at.held]
    for name, part in at.held_by_side():
        found[name] = found.get(name, 0.0) + float(needed[part].sum())
    return found
