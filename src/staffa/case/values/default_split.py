"""Which energy split a case takes, and why."""

from staffa.case.schema.case import Case
from staffa.case.schema.material_keys import is_isotropic
from staffa.case.values.pressing_loads import acting_forces, pressing
from staffa.case.values.subdomains import averages, subdomains_of
from staffa.physics.split import SPLITS, Contact, EnergySplit, StarConvex
from staffa.physics.strength_surface import StrengthSurface

GAMMA = 5.0


def presses(case: Case) -> str:
    """Return the keys of [forces] that are given, which may press cracks shut, or nothing."""
    return ", ".join(acting_forces(case.forces))


def is_anisotropic(case: Case) -> bool:
    """Return True if the stiffness of some rock of a case depends on the direction."""
    return not all(is_isotropic(keys) for keys in (case.material, *case.regions.values()))


def takes_principal_strains(case: Case) -> bool:
    """Return True if splits by principal strains are for its rock: isotropic, with nu >= 0."""
    return not is_anisotropic(case) and all(
        averages(subdomain).nu >= 0 for subdomain in subdomains_of(case)
    )


def safest_split(case: Case) -> str:
    """Return the split of its rock under which pressure breaks the least.

    Isotropic rock with nu >= 0 does not break at all: no-tension is safe, see `physics.split`.
    """
    return "no-tension" if takes_principal_strains(case) else "volumetric-deviatoric"


def default_split(case: Case) -> str:
    """Return the default split: none where only cooling acts, which pulls; else see `pressing`.

    Strengths besides that of a pulled bar ask for the split that has them.
    """
    if given_strengths(case):
        return StrengthSurface.name
    return safest_split(case) if pressing(case) else "none"


def given_strengths(case: Case) -> list[str]:
    """Return the names of the given strengths besides that of a pulled bar."""
    return [n for n in ("biaxial", "compressive") if getattr(case.damage, n) is not None]


def is_by_default(case: Case) -> bool:
    """Return True if the case does not give its split itself."""
    return "split" not in case.damage.model_fields_set


def for_any_load(case: Case) -> Case:
    """Return the case with the split that is safe under any load of a script, unless it has one."""
    if not is_by_default(case):
        return case
    damage = case.damage.model_copy(update={"split": safest_split(case)})
    return case.model_copy(update={"damage": damage})


def energy_split(case: Case) -> EnergySplit:
    """Return the split of a case."""
    name = case.damage.split or default_split(case)
    if name == "star-convex":
        gamma = GAMMA if case.damage.gamma is None else case.damage.gamma
        return StarConvex(gamma=gamma, name=name)
    if name == "contact":
        return Contact(friction=case.damage.friction or 0.0)
    if name == StrengthSurface.name:
        return _strength_surface(case)
    return SPLITS[name]


def _strength_surface(case: Case) -> StrengthSurface:
    """Return the energy of the strengths of a case, whose law is cohesive."""
    keys = case.damage
    assert keys.strength is not None
    given = {n: float(getattr(keys, n) / keys.strength) for n in given_strengths(case)}
    return StrengthSurface(**given)
