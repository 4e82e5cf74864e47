"""Sentences of `check` on elements: which a case takes, how much too stiff linear ones are."""

from collections.abc import Iterator
from math import sqrt

from staffa.case.schema.case import Case
from staffa.case.values.elements import cells_of, elements_of, is_constrained, largest_nu
from staffa.physics.locking import FROM, LINEAR, cures, too_stiff

MEANINGS = {
    "linear": "linear displacement",
    "quadratic": "quadratic displacement, linear damage",
    "reduced": "the volume change counts in the middle of each cell alone",
}


def element_facts(case: Case) -> list[tuple[str, str, str]]:
    """Return the elements, where they are not linear or matter."""
    elements, nu = elements_of(case), largest_nu(case)[0]
    locks = is_constrained(case) and nu >= FROM
    if elements == LINEAR and not locks:
        return []
    why = f"nu = {nu:.4g}, and from {FROM} on linear ones are too stiff"
    if not locks:
        why = "asked for, though linear ones are hardly too stiff here"
    return [("elements", elements, f"{MEANINGS[elements]}: {why}" if elements != LINEAR else why)]


def cells_across(case: Case) -> float:
    """Return the number of cells over the smallest extent of a body.

    In a plane mesh this extent is the mean width of what holes leave: twice the area over the
    boundary, which has 2 V - C facets (Euler).
    """
    body = case.outline
    found = min(body.size) / body.h
    facets = 2 * body.n_vertices - body.n_cells
    if case.domain.file is None or case.dim == 3 or facets <= 0:
        return found
    return min(found, sqrt(3) / 2 * body.n_cells / facets)


def locking_warnings(case: Case) -> Iterator[str]:
    """Yield a note if linear elements are kept although they lock, with the amount of locking."""
    if elements_of(case) != LINEAR or not is_constrained(case):
        return
    nu, subdomain = largest_nu(case)
    if nu < FROM:
        return
    cells, across = cells_of(case), cells_across(case)
    yield (
        f'domain.elements = "{LINEAR}" with nu = {nu:.4g} ({subdomain.name}): they lock, and the '
        f"body is about {100 * too_stiff(nu, cells, across):.2g} % too stiff with {across:.3g} "
        f"cells across it, more at cracks and in thin parts; take domain.elements = "
        f'"{cures(cells)}", or leave it out'
    )
