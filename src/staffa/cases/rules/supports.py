"""Rules on what holds and moves the body."""

from itertools import pairwise

from staffa.cases.model import Case, History, Prescribed
from staffa.cases.rules.body import SIDES_3D
from staffa.cases.writing import inline
from staffa.errors import InputError


def section_owns_its_sides(case: Case) -> None:
    """A section is 2-D, owns left and right, and is cooled from below or above."""
    keys, section = case.supports, f'supports.section = "{case.supports.section}"'
    if keys.section == "none":
        return
    if case.dim == 3:
        raise InputError(f"{section} is for 2-D cells; in 3-D give rollers to the sides")
    for side in ("left", "right"):
        if getattr(keys, side) not in ("free", "rollers"):
            raise InputError(
                f"supports.{side} = {inline(getattr(keys, side))}: {section} already puts rollers "
                f"there; leave one out"
            )
    if case.temperature.profile != "none" and case.temperature.face in ("left", "right"):
        raise InputError(
            f'temperature.face = "{case.temperature.face}": a cell with {section} is cooled from '
            f"its bottom or top; take one of these"
        )


def section_can_stretch(case: Case) -> None:
    """Bottom and top do not hold the strain that a section leaves open."""
    if case.supports.section not in ("stretch", "free"):
        return
    for side in ("bottom", "top"):
        support = getattr(case.supports, side)
        if support == "clamped" or (isinstance(support, Prescribed) and support.x is not None):
            raise InputError(
                f"supports.{side} = {inline(support)} holds x, which supports.section = "
                f'"{case.supports.section}" leaves free to stretch; leave one out'
            )


def prescribed_agree(case: Case) -> None:
    """Prescribed sides name components that exist, and tables of the same length."""
    for side in SIDES_3D:
        support = getattr(case.supports, side)
        if not isinstance(support, Prescribed):
            continue
        names = "xyz"[: case.dim]
        if case.dim == 2 and support.z is not None:
            raise InputError(f"supports.{side}.z: a 2-D body has no component z; it has x and y")
        if all(getattr(support, name) is None for name in names):
            raise InputError(
                f"supports.{side} = {{}} prescribes nothing; give at least one of "
                f"{', '.join(names)}, or leave it out"
            )
        for name in names:
            _table_agrees(f"supports.{side}.{name}", getattr(support, name))


def _table_agrees(where: str, table: float | History | None) -> None:
    if not isinstance(table, History):
        return
    if not table.t or len(table.t) != len(table.u):
        raise InputError(
            f"{where}: t has {len(table.t)} numbers and u has {len(table.u)}; give as many of "
            f"each, and at least one"
        )
    for before, after in pairwise(table.t):
        if after <= before:
            raise InputError(
                f"{where}.t: {inline(after)} comes after {inline(before)}; put the times in "
                f"increasing order, no two of them equal"
            )


def something_happens(case: Case) -> None:
    """The body is cooled or moved."""
    if case.temperature.profile == "none" and not any(
        _moves(getattr(case.supports, side)) for side in SIDES_3D
    ):
        raise InputError(
            'the case loads nothing: temperature.profile = "none" and no prescribed displacement '
            "other than zero; give one of them"
        )


def _moves(support: object) -> bool:
    if not isinstance(support, Prescribed):
        return False
    given = (support.x, support.y, support.z)
    return any(any(c.u) if isinstance(c, History) else bool(c) for c in given)
