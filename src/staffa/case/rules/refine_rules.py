"""Rules on a mesh that follows the cracks."""

from staffa.case.schema.case import Case
from staffa.case.schema.domain_keys import BLOCKS
from staffa.case.schema.quantity_text import amount, at_least, at_most
from staffa.case.schema.shape_keys import Layers
from staffa.case.schema.toml_text import inline
from staffa.errors import InputError
from staffa.geometry.block import divisions

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
        raise InputError(f"domain.refine = {inline(keys.refine)}: {_not_halved(case)}, {OFF}")


def _not_halved(case: Case) -> str:
    """Return why no edge can be halved down to h, and what to take."""
    keys, body = case.domain, case.outline
    h, shown = float(keys.h or 0.0), f"domain.h = {inline(keys.h)}"
    if body.edges is not None:
        mean = body.edges.mean
        return (
            f"the mean edge of the mesh, {amount(case, mean, 'm')}, is not twice as long as "
            f"{shown}, so no edge is halved; take domain.h <= {at_most(case, mean / 2, 'm')}, or "
            f"a coarser mesh"
        )
    if keys.longest < 2 * h * (1 - 1e-9):
        given = keys.refining is not None and keys.refining.coarsest is not None
        begin = "domain.refine.coarsest" if given else "a sixteenth of the body"
        return (
            f"{begin}, {amount(case, keys.longest, 'm')}, with which cells begin, is not twice as "
            f"long as {shown}, so no edge is halved; take domain.h <= "
            f'{at_most(case, keys.longest / 2, "m")}, or a coarser start, like coarsest = "4 h"'
        )
    counts = divisions(body.size, 2 * h)
    ends = [length / count / 2 for length, count in zip(body.size, counts, strict=True)]
    return (
        f"a block has whole numbers of cells, and those that begin with 2 h would be "
        f"{amount(case, min(ends), 'm')} long when halved, more than a sixth less than {shown}; "
        f"take domain.h = {at_least(case, min(ends), 'm')}"
    )
