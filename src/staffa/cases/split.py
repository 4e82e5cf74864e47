"""Which energy split a case takes, and why."""

from staffa.cases.model import Case
from staffa.cases.pieces import averages, pieces
from staffa.cases.rock_keys import is_isotropic
from staffa.physics.split import SPLITS, Contact, EnergySplit, StarConvex

GAMMA = 5.0


def presses(case: Case) -> str:
    """What in [forces] may press cracks shut, or nothing."""
    keys = case.forces
    if keys is None:
        return ""
    own = ("prestress", "gravity", "pore_pressure", "crack_pressure", "crack_volume")
    return ", ".join([*(name for name in own if getattr(keys, name) is not None), *keys.by_side()])


def is_anisotropic(case: Case) -> bool:
    """Whether the stiffness of some rock of a case depends on the direction."""
    return not all(is_isotropic(keys) for keys in (case.material, *case.regions.values()))


def takes_principal_strains(case: Case) -> bool:
    """Whether splits by principal strains are for its rock: isotropic, with nu >= 0."""
    return not is_anisotropic(case) and all(averages(piece).nu >= 0 for piece in pieces(case))


def default_split(case: Case) -> str:
    """None where cold alone acts: it pulls. Else what breaks the least under pressure of what its
    rock takes: isotropic rock with nu >= 0 does not break at all."""
    if not presses(case):
        return "none"
    return "no-tension" if takes_principal_strains(case) else "volumetric-deviatoric"


def energy_split(case: Case) -> EnergySplit:
    """The split of a case."""
    name = case.damage.split or default_split(case)
    if name == "star-convex":
        gamma = GAMMA if case.damage.gamma is None else case.damage.gamma
        return StarConvex(gamma=gamma, name=name)
    if name == "contact":
        return Contact(friction=case.damage.friction or 0.0)
    return SPLITS[name]
