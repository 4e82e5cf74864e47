"""Damage law of a case."""

from staffa.case.schema.case import Case
from staffa.case.values.subdomains import averages, subdomains_of
from staffa.physics.damage import COHESIVE, LAWS, DamageLaw, cohesive, irwin_length

SOFTENS = "linear"


def damage_law(case: Case) -> DamageLaw:
    """Return the damage law of a case.

    A cohesive law is the same in all of a body: it has the strength where Young's modulus and the
    toughness are the averages of `material`, and one that goes with sqrt(E Gc) elsewhere.
    """
    if case.damage.law != COHESIVE:
        return LAWS[case.damage.law]
    return cohesive(
        irwin=case_irwin_length(case), ell=float(case.damage.ell), softening=softening(case)
    )


def softening(case: Case) -> str:
    """Return the softening of a case's cohesive law."""
    return case.damage.softening or SOFTENS


def case_irwin_length(case: Case) -> float:
    """Return Irwin's length (m) of the rock of `material`, from a case's strength."""
    assert case.damage.strength is not None
    rock = averages(subdomains_of(case)[0])
    return irwin_length(E=rock.E, Gc=rock.Gc, strength=float(case.damage.strength))
