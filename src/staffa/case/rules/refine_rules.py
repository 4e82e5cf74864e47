"""Rules on a mesh that follows the cracks."""

from staffa.case.schema.case import Case
from staffa.case.schema.domain_keys import BLOCKS
from staffa.case.schema.shape_keys import Layers
from staffa.case.schema.toml_text import inline
from staffa.errors import InputError

OFF = "or leave domain.refine out"


def refinement_is_possible(case: Case) -> None:
    """Require cells that can be split, that begin longer than h, of a body with flat faces."""
    keys = case.domain
    if keys.refining is None:
        return
    cells = keys.cells or BLOCKS.get(case.dim)
    if keys.is_block and cells in BLOCKS.values():
        simplices = {2: "triangle", 3: "tetrahedron"}[case.dim]
        raise InputError(
            f"domain.refine = {inline(keys.refine)}: {cells} cells cannot be split; take "
            f'domain.cells = "{simplices}" or "unstructured", {OFF}'
        )
    if keys.shape is not None and not isinstance(keys.shape, Layers):
        raise InputError(
            f'domain.refine = {inline(keys.refine)}: the coarse cells of a "{keys.shape.kind}" '
            f"would give its round faces corners; take a body with flat faces, {OFF}"
        )
    if keys.mesh is not None and keys.h is None:
        raise InputError(
            f"domain.refine = {inline(keys.refine)}: a mesh from a file is refined down to "
            f"domain.h; give domain.h, {OFF}"
        )
    if case.reservoir is not None:
        raise InputError(
            f"domain.refine = {inline(keys.refine)}: the cells of [reservoir] are tied to one mesh "
            f"of the rock; leave domain.refine out"
        )
    if not keys.halvings:
        begin = "domain.refine.coarsest" if keys.refining.coarsest else "a sixteenth of the body"
        raise InputError(
            f"domain.refine = {inline(keys.refine)}: {begin} is not twice as long as domain.h = "
            f"{inline(keys.h)}, or cells of h do not come of halving it; take a coarser start or a "
            f"smaller domain.h, {OFF}"
        )
