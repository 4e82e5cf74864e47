"""The warning about an ell that is possible with a cohesive law, but makes rock break all over."""

from collections.abc import Iterator

from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import amount, at_most
from staffa.case.values.damage_law import case_irwin_length
from staffa.physics.damage import COHESIVE, spreading_ell


def cohesive_warnings(case: Case) -> Iterator[str]:
    """Yield a sentence where rock near its strength breaks all over beside a crack.

    Parameters
    ----------
    case : the case.
    """
    if case.damage.law != COHESIVE:
        return
    most = spreading_ell(case_irwin_length(case))
    ell = float(case.damage.ell)
    if ell > most:
        yield (
            f"damage.ell = {amount(case, ell, 'm')} is more than 2/pi of Irwin's length: rock near "
            f"its strength stores more than broken rock costs, so damage spreads from a crack into "
            f"all of it; take damage.ell <= {at_most(case, most, 'm')}"
        )
