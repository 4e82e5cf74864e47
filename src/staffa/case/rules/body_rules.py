"""Rules on the body: its dimension, its mesh, and what is drawn into it."""

from staffa.case.schema.case import Case, Disc, Named, Segment
from staffa.case.schema.quantity_text import unit
from staffa.case.schema.toml_text import inline
from staffa.case.values.elements import cells_of, displacement_unknowns
from staffa.errors import InputError
from staffa.geometry.block import UNSTRUCTURED
from staffa.geometry.places import SAME
from staffa.physics.locking import LINEAR, QUADRATIC, cures

CELLS = {
    2: ("quadrilateral", "triangle", UNSTRUCTURED),
    3: ("hexahedron", "tetrahedron", UNSTRUCTURED),
}
# PETSc, as it is mostly built, numbers unknowns with 32 bits.
LARGEST = 2_000_000_000
ROUND_OFF = 1 + 1e-9  # "0.03 mm" and "30 um" differ in the last digit


def dimension_agrees(case: Case) -> None:
    """Require that cells, plane state and sides fit the body's dimension."""
    dim, cells = case.dim, case.domain.cells
    if case.domain.is_block and cells is not None and cells not in CELLS[dim]:
        raise InputError(
            f'domain.cells = "{cells}" does not fit domain.size with {dim} numbers; use '
            f"{' or '.join(CELLS[dim])}"
        )
    if dim == 3 and case.material.plane is not None:
        raise InputError(
            f'material.plane = "{case.material.plane}" is for 2-D bodies, and this one is 3-D; '
            f"leave it out"
        )


def elements_fit_the_cells(case: Case) -> None:
    """Require elements that the cells have: quadratic and reduced ones are for some cells only."""
    elements, cells = case.domain.elements, cells_of(case)
    if elements not in (None, LINEAR, cures(cells)):
        kind = "simplices" if cures(cells) == QUADRATIC else "quadrilaterals and hexahedra"
        raise InputError(
            f'domain.elements = "{elements}" does not fit {cells} cells: {kind} have '
            f'"{LINEAR}" and "{cures(cells)}" ones; take one of these, or leave it out'
        )


def mesh_carries_cracks(case: Case) -> None:
    """Require ell >= h unless opted out, and a body larger than either."""
    ell, h, smallest = case.damage.ell, _edge(case), _smallest(case)
    if h > smallest * ROUND_OFF:
        raise InputError(
            f"domain.h = {inline(h)}: a cell is larger than the body, whose smallest extent is "
            f"{inline(smallest)}; take a smaller h"
        )
    if ell * ROUND_OFF < h and not case.damage.allow_coarse:
        raise InputError(
            f"damage.ell = {inline(ell)} is less than {_edge_in_words(case)}: the mesh would "
            f"steer the cracks; take h <= ell/3, or set damage.allow_coarse = true to do it "
            f"knowingly"
        )
    if ell > smallest * ROUND_OFF:
        raise InputError(
            f"damage.ell = {inline(ell)} is larger than the body's smallest extent, "
            f"{inline(smallest)}, so that no crack fits in; take a smaller ell"
        )


def mesh_can_be_numbered(case: Case) -> None:
    """Refuse more unknowns than a 32-bit number counts, but for a mesh that follows the cracks."""
    unknowns = displacement_unknowns(case)
    if unknowns > LARGEST and not case.domain.halvings:
        raise InputError(
            f"{_edge_in_words(case)} gives {unknowns:.2g} unknowns of displacement, "
            f"more than the {LARGEST:.0e} that can be numbered; take a larger h"
        )


def bands_are_inside(case: Case) -> None:
    """Require that every band is a box that meets the body."""
    for table, keys in (("toughness", case.toughness), ("heat", case.heat)):
        for number, band in enumerate(keys.bands if keys else (), start=1):
            box_is_inside(case, band.lower, band.upper, f"{table}.bands, entry {number}")


def box_is_inside(
    case: Case, lower: tuple[float, ...], upper: tuple[float, ...], where: str
) -> None:
    """Require that a box has an extent along each axis, and meets the body.

    Parameters
    ----------
    case : the case.
    lower, upper : corners of the box (m), one number per axis.
    where : the key of the box, for messages.
    """
    for name, corner in (("lower", lower), ("upper", upper)):
        if len(corner) != case.dim:
            raise InputError(
                f"{where}, {name} = {inline(corner)}: it needs {case.dim} numbers, as the body "
                f"is {case.dim}-D"
            )
    slack = SAME * case.outline.h
    if any(b - a <= slack for a, b in zip(lower, upper, strict=True)):
        raise InputError(
            f"{where}: upper = {inline(upper)} must be larger than lower = {inline(lower)} along "
            f"each axis"
        )
    body = case.outline
    extent = zip(lower, upper, body.lower, body.upper, strict=True)
    if any(low > end + slack or high < start - slack for low, high, start, end in extent):
        raise InputError(
            f"{where}: the box from {inline(lower)} to {inline(upper)} lies outside the body, "
            f"{_extent(case)}; move it in or leave it out"
        )


def cracks_are_inside(case: Case) -> None:
    """Require that every initial crack has the body's dimension, lies in it, and has an extent."""
    for number, crack in enumerate(case.cracks, start=1):
        where = f"cracks, entry {number}"
        if isinstance(crack, Named):
            continue
        if isinstance(crack, Disc) != (case.dim == 3):
            raise InputError(
                f"{where}: a 2-D body has straight cracks (start, end) and a 3-D body discs "
                f"(center, radius, normal); this body is {case.dim}-D"
            )
        points = _points(crack)
        for name, point in points.items():
            is_inside(case, f"{where}, {name} = {inline(point)}", point)
        if isinstance(crack, Disc):
            _has_a_direction(crack, where)
        elif crack.start == crack.end:
            raise InputError(
                f"{where}: start and end are both {inline(crack.start)}; move one, since a crack "
                f"needs a length"
            )


def _points(crack: Segment | Disc) -> dict[str, tuple[float, ...]]:
    if isinstance(crack, Disc):
        return {"center": crack.center}
    return {"start": crack.start, "end": crack.end}


def is_inside(case: Case, what: str, point: tuple[float, ...]) -> None:
    """Require that a point has the dimension of the body and lies inside of it.

    Parameters
    ----------
    case : the case.
    what : the key and value of the point, for messages.
    point : coordinates (m), one number per axis.
    """
    body = case.outline
    if len(point) != case.dim:
        raise InputError(f"{what}: it needs {case.dim} numbers, as the body is {case.dim}-D")
    slack = (ROUND_OFF - 1) * max(body.size)
    ends = zip(point, body.lower, body.upper, strict=True)
    if any(not low - slack <= c <= high + slack for c, low, high in ends):
        raise InputError(f"{what} lies outside the body, {_extent(case)}; move it in")


def _extent(case: Case) -> str:
    """Return the extent of a body in words."""
    if case.domain.size is not None and case.domain.hole is None:
        return f"whose size is {inline(case.domain.size)} from the origin"
    lower, upper = (
        " ".join(f"{c:.4g}" for c in end) for end in (case.outline.lower, case.outline.upper)
    )
    return f"which reaches from ({lower}) to ({upper}){unit(case, 'm')}"


def _edge(case: Case) -> float:
    """Return the edge of its cells, as it is written if it is."""
    return case.outline.h if case.domain.h is None else case.domain.h


def _edge_in_words(case: Case) -> str:
    if case.domain.h is not None:
        return f"domain.h = {inline(case.domain.h)}"
    return f"the mesh's mean edge, {case.outline.h:.3g}{unit(case, 'm')}"


def _smallest(case: Case) -> float:
    return min(case.domain.size or case.outline.size)


def _has_a_direction(crack: Disc, where: str) -> None:
    if len(crack.normal) != 3 or not any(crack.normal):
        raise InputError(
            f"{where}, normal = {inline(crack.normal)} is no direction; give three numbers, not "
            f"all zero"
        )
