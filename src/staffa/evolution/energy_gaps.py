"""Differences between energies of one state that should be equal."""

from staffa.evolution.apply_loads import Loading
from staffa.records.minimization import Outcome


def relative_difference(one: float, other: float, outcome: Outcome) -> float:
    """Return the difference of two energies over the energy.

    Parameters
    ----------
    one : first energy.
    other : second energy.
    outcome : outcome with the scale of the energy.
    """
    return abs(one - other) / max(abs(one), abs(other), outcome.scale)


def gap_between_parts(outcome: Outcome, began: float | None) -> float:
    """Return the relative difference of the end of one part of a step and the start of the next.

    Parameters
    ----------
    outcome : outcome of the one part.
    began : energy (J) that the next one began with; None for none.
    """
    total = outcome.energies.total
    return 0.0 if began is None else relative_difference(total, began, outcome)


def gap_at_start(loading: Loading, outcome: Outcome) -> float:
    """Return the relative difference of the energy under new loads and at the first sweep."""
    return relative_difference(loading.end, outcome.before, outcome)
