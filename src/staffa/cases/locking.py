"""What `check` says of elements: which a case takes, and how much too stiff linear ones are."""

from collections.abc import Iterator

from staffa.cases.elements import cells_of, elements_of, is_constrained, largest_nu
from staffa.cases.model import Case
from staffa.physics.locking import FROM, LINEAR, cures, too_stiff

MEANINGS = {
    "linear": "linear displacement",
    "quadratic": "quadratic displacement, linear damage",
    "reduced": "the volume change counts in the middle of each cell alone",
}


def element_facts(case: Case) -> list[tuple[str, str, str]]:
    """The elements, where they are not linear or matter."""
    elements, nu = elements_of(case), largest_nu(case)[0]
    locks = is_constrained(case) and nu >= FROM
    if elements == LINEAR and not locks:
        return []
    why = f"nu = {nu:.4g}, and from {FROM} on linear ones are too stiff"
    if not locks:
        why = "asked for, though linear ones are hardly too stiff here"
    return [("elements", elements, f"{MEANINGS[elements]}: {why}" if elements != LINEAR else why)]


def locking_cautions(case: Case) -> Iterator[str]:
    """That linear elements are kept where they lock, and by how much they do."""
    if elements_of(case) != LINEAR or not is_constrained(case):
        return
    nu, piece = largest_nu(case)
    if nu < FROM:
        return
    cells, across = cells_of(case), min(case.outline.size) / case.outline.h
    yield (
        f'domain.elements = "{LINEAR}" with nu = {nu:.4g} ({piece.name}): they lock, and the body '
        f"is about {100 * too_stiff(nu, cells, across):.2g} % too stiff with {across:.3g} cells "
        f"over its smallest extent, its cracks and thin parts more; take "
        f'domain.elements = "{cures(cells)}", or leave it out'
    )
