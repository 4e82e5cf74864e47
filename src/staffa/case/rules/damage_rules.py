"""Rules on the damage law."""

from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import amount, at_most
from staffa.case.schema.toml_text import inline
from staffa.case.values.damage_law import case_irwin_length, softening
from staffa.errors import InputError
from staffa.physics.damage import COHESIVE, longest_cohesive_ell


def cohesive_is_possible(case: Case) -> None:
    """Require the strength of a cohesive law, and an ell that is small beside Irwin's length."""
    keys = case.damage
    if keys.law != COHESIVE:
        for name in ("strength", "softening"):
            if (value := getattr(keys, name)) is not None:
                raise InputError(
                    f"damage.{name} = {inline(value)} has no meaning but with damage.law = "
                    f'"{COHESIVE}": the strength of {keys.law} follows from E, Gc and ell; leave '
                    f"it out, or take that law"
                )
        return
    if keys.strength is None:
        raise InputError(
            f'damage.law = "{COHESIVE}" needs damage.strength, the stress that a bar of the rock '
            f'bears, like "10 MPa"; give it'
        )
    irwin = case_irwin_length(case)
    most = longest_cohesive_ell(irwin, softening(case))
    if float(keys.ell) > most:
        raise InputError(
            f"damage.ell = {inline(keys.ell)}: Irwin's length E Gc/strength^2 is "
            f'{amount(case, irwin, "m")}, and damage.law = "{COHESIVE}" with {softening(case)} '
            f"softening needs an ell of {at_most(case, most, 'm')} at most; no such law has this "
            f"strength and this toughness at a larger one: take a smaller ell, or damage.law = "
            f'"AT1" with cracks that are given or start from weak places'
        )
