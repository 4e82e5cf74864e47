"""A caution on closed cracks that do not slide, with the splits for which they are stuck."""

from collections.abc import Iterator

import numpy as np

from staffa.cases.forces import forces
from staffa.cases.model import Case
from staffa.cases.rules import is_moved
from staffa.cases.split import takes_principal_strains

# Splits that keep the shear stiffness of a closed crack, or most of it.
STUCK = ("no-tension", "spectral")


def sliding_cautions(case: Case) -> Iterator[str]:
    """Where a closed crack may be sheared, and its split does not let it slide."""
    if case.damage.split not in STUCK:
        return
    pressed = case.cracks and (case.forces is not None or is_moved(case))
    if not pressed and not is_sheared(case):
        return
    way_out = (
        'take damage.split = "contact", with damage.friction'
        if takes_principal_strains(case)
        else "only isotropic rock has a split that lets them slide"
    )
    yield (
        f'damage.split = "{case.damage.split}": the faces of closed cracks do not slide, so that a '
        f"crack pressed shut carries nearly all shear; if cracks close under shear here, {way_out}"
    )


def is_sheared(case: Case) -> bool:
    """Whether [forces] shears: by a prestress, or along a face."""
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
