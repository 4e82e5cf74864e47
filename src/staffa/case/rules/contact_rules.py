"""Rules on cracks whose faces touch: what their split and their friction allow."""

from staffa.case.schema.case import Case
from staffa.case.schema.toml_text import inline
from staffa.case.values.elements import elements_of
from staffa.errors import InputError
from staffa.physics.locking import LINEAR

CONTACT = "contact"


def contact_is_possible(case: Case) -> None:
    """Require the split of friction, and refuse keys that need one energy for several steps."""
    friction, is_contact = case.damage.friction, case.damage.split == CONTACT
    if friction is not None and not is_contact:
        raise InputError(
            f"damage.friction = {friction:g} has no meaning but with damage.split = "
            f'"{CONTACT}"; leave it out, or take that split'
        )
    if is_contact and case.solver.backtracking:
        raise InputError(
            f'solver.backtracking = true: with damage.split = "{CONTACT}" the energy of a step '
            f"depends on the normals of its cracks, so that none can be compared with an "
            f"earlier one; leave it out"
        )
    if is_contact and case.axial:
        raise InputError(
            f'damage.split = "{CONTACT}": faces of cracks in a body of revolution '
            f'(domain.symmetry = "axis") are not known; leave the split out, which holds closed '
            f"cracks, or take a 3-D body"
        )
    if not friction:
        return
    if elements_of(case) != LINEAR:
        raise InputError(
            f"domain.elements = {inline(elements_of(case))}: with damage.friction = {friction:g} "
            f'slip is one number a cell, and needs domain.elements = "{LINEAR}"'
        )
    tested = "stability" in case.solver.model_fields_set and case.solver.stability != "none"
    if tested:
        raise InputError(
            f"solver.stability = {inline(case.solver.stability)}: with damage.friction = "
            f"{friction:g} a step has no second order, since friction depends on the pressure of "
            f"its own minimum; leave it out"
        )
    if case.heat is not None and case.heat.cracks is not None:
        raise InputError(
            f"heat.cracks: with damage.friction = {friction:g} cracks cannot change the flow of "
            f"heat; leave one of them out"
        )
    if case.forces is not None and case.forces.crack_volume is not None:
        raise InputError(
            f"forces.crack_volume: with damage.friction = {friction:g} the volume in cracks cannot "
            f"be prescribed; take forces.crack_pressure"
        )
