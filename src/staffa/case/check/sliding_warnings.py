"""Warning about closed cracks that do not slide, with the splits for which they are stuck."""

from collections.abc import Iterator

import numpy as np

from staffa.case.rules import is_moved
from staffa.case.schema.case import Case
from staffa.case.values.applied_forces import forces
from staffa.case.values.default_split import takes_principal_strains
from staffa.physics.strength_surface import StrengthSurface

# Splits that keep the shear stiffness of a closed crack, or most of it.
STUCK = ("no-tension", "spectral", StrengthSurface.name)


def sliding_warnings(case: Case) -> Iterator[str]:
    """Warn where a closed crack may be sheared, and its split does not let it slide."""
    if case.damage.split not in STUCK or case.damage.compressive is not None:
        return
    pressed = case.cracks and (case.forces is not None or is_moved(case))
    if not pressed and not is_sheared(case):
        return
    way_out = _way_out(case)
    yield (
        f'damage.split = "{case.damage.split}": the faces of closed cracks do not slide, so that a '
        f"crack pressed shut carries nearly all shear; if cracks close under shear here, {way_out}"
    )


def _way_out(case: Case) -> str:
    """Return the end of the sentence: the split that lets faces slide, and its other needs."""
    if not takes_principal_strains(case):
        return "only isotropic rock has a split that lets them slide"
    if case.axial:
        return "a body of revolution has no split that lets them slide; take a 3-D body"
    keys, heat, forces = case.solver, case.heat, case.forces
    in_the_way = [
        *(["solver.backtracking"] if keys.backtracking else []),
        *(["heat.cracks"] if heat is not None and heat.cracks is not None else []),
        *(["forces.crack_volume"] if forces is not None and forces.crack_volume else []),
        *(["solver.stability"] if keys.stability in ("report", "follow") else []),
    ]
    without = f", without {' and '.join(in_the_way)}" if in_the_way else ""
    return f'take damage.split = "contact", with damage.friction{without}'


def is_sheared(case: Case) -> bool:
    """Return True if [forces] shears: by a prestress, or along a face."""
    if case.forces is None:
        return False
    acting, x = forces(case), case.outline.places.within().x
    if acting.prestress is not None and np.any(acting.prestress(x)[3:] != 0):
        return True
    for side, table in case.forces.by_side().items():
        axis = case.outline.axis(side)
        given = {name for name in "xyz" if getattr(table, name, None) is not None}
        if axis is not None and given - {"xyz"[axis]}:
            return True
    return False
