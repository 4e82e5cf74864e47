"""Value of the key that gives another strength."""

from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import at_least, at_most
from staffa.physics.damage import COHESIVE


def key_of_strength(case: Case, factor: float) -> str:
    """Return the key of the strength with its value for the strength times a factor."""
    if case.damage.law == COHESIVE:
        assert case.damage.strength is not None
        bears = factor * float(case.damage.strength)
        if factor > 1:
            return f"damage.strength >= {at_least(case, bears, 'Pa')}"
        return f"damage.strength <= {at_most(case, bears, 'Pa')}"
    ell = float(case.damage.ell) / factor**2
    if factor > 1:
        return f"damage.ell <= {at_most(case, ell, 'm')} (a higher strength)"
    return f"damage.ell >= {at_least(case, ell, 'm')} (a lower strength)"
