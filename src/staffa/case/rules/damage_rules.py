"""Rules on the damage law."""

from math import inf

from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import amount, at_most
from staffa.case.schema.toml_text import inline
from staffa.case.values.damage_law import case_irwin_length, softening
from staffa.case.values.default_split import given_strengths
from staffa.errors import InputError
from staffa.physics.damage import COHESIVE, longest_cohesive_ell
from staffa.physics.strength_surface import StrengthSurface, least_biaxial
from staffa.units import Quantity


def cohesive_is_possible(case: Case) -> None:
    """Require the strength of a cohesive law, and an ell that is small beside Irwin's length."""
    keys = case.damage
    if keys.law != COHESIVE:
        for name in ("strength", "softening", "biaxial", "compressive"):
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


def strengths_agree(case: Case) -> None:
    """Require strengths that one convex surface has, and a split and a law that have them."""
    keys, split = case.damage, StrengthSurface.name
    for name in given_strengths(case):
        if keys.split not in (None, split):
            raise InputError(
                f'damage.split = "{keys.split}" takes no damage.{name}: they follow from the '
                f"energy; leave one of the two out"
            )
    if keys.split == split and keys.law != COHESIVE:
        raise InputError(
            f'damage.split = "{split}" is for damage.law = "{COHESIVE}", whose strength is given; '
            f"take that law, or another split"
        )
    if keys.strength is None:
        return
    if keys.compressive is not None and keys.compressive <= keys.strength:
        raise InputError(
            f"damage.compressive = {inline(keys.compressive)} must be larger than damage.strength "
            f"= {inline(keys.strength)}: rock bears more pressure than tension; give a larger one"
        )
    if keys.biaxial is not None:
        _biaxial_is_possible(case, keys.biaxial, keys.strength)


def _biaxial_is_possible(case: Case, biaxial: Quantity, strength: Quantity) -> None:
    pressed = case.damage.compressive
    most = float(strength)
    least = most * least_biaxial(inf if pressed is None else float(pressed) / most)
    if not least < float(biaxial) <= most:
        raise InputError(
            f"damage.biaxial = {inline(biaxial)}: with these strengths of a bar, tension along two "
            f"directions must break the rock above {amount(case, least, 'Pa')} (each direction on "
            f"its own) and at {amount(case, most, 'Pa')} at most (the larger one alone): give one "
            f"between"
        )
