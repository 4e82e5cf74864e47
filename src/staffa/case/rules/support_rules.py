"""Rules on what holds and moves the body."""

from collections.abc import Callable
from functools import partial
from itertools import combinations

import numpy as np
import scipy

from staffa.case.rules.time_rules import table_agrees
from staffa.case.schema.case import Case, Prescribed
from staffa.case.schema.support_keys import DisplacementFile, DisplacementHistory
from staffa.case.schema.toml_text import inline
from staffa.case.values.given_files import factors, largest_displacement
from staffa.errors import InputError
from staffa.geometry.places import SAME

PrescribedValue = float | DisplacementHistory | DisplacementFile
# Part of the largest displacement by which fields in files may differ where two sides meet.
INTERPOLATED = 1e-6


def rollers_are_flat(case: Case) -> None:
    """Require that rollers are on faces that are flat across an axis."""
    faces = case.outline.faces
    for name, plane in faces.items():
        if case.supports.on(name) == "rollers" and plane is None:
            flat = ", ".join(sorted(n for n, p in faces.items() if p is not None)) or "none"
            raise InputError(
                f'supports.{name} = "rollers": rollers need a face that is flat across an axis, '
                f"as are {flat}; hold components of this one, like {{ x = 0.0 }}, or clamp it"
            )


def section_owns_its_sides(case: Case) -> None:
    """Require that a section is 2-D, has left and right, and is cooled from below or above."""
    keys, section = case.supports, f'supports.section = "{case.supports.section}"'
    if keys.section == "none":
        return
    for side in ("left", "right"):
        if case.outline.sides.get(side) != side:
            raise InputError(
                f"{section} needs flat sides named left and right, and the body has no such "
                f"'{side}'; leave it out, or name them so"
            )
    if case.dim == 3:
        raise InputError(f"{section} is for 2-D cells; in 3-D give rollers to the sides")
    for side in ("left", "right"):
        if keys.on(side) not in (None, "free", "rollers"):
            raise InputError(
                f"supports.{side} = {inline(keys.on(side))}: {section} already puts rollers "
                f"there; leave one out"
            )
    if case.temperature.has_face and case.temperature.face in ("left", "right"):
        raise InputError(
            f'temperature.face = "{case.temperature.face}": a cell with {section} is cooled from '
            f"its bottom or top; take one of these"
        )


def section_can_stretch(case: Case) -> None:
    """Require that right, bottom and top leave free the strain that a section leaves open."""
    if case.supports.section not in ("stretch", "free"):
        return
    for side in ("right", "bottom", "top"):
        support = case.supports.on(side)
        holds = support == ("rollers" if side == "right" else "clamped")
        if holds or (isinstance(support, Prescribed) and support.x is not None):
            raise InputError(
                f"supports.{side} = {inline(support)} holds x, which supports.section = "
                f'"{case.supports.section}" leaves free to stretch; leave one out'
            )


def prescribed_agree(case: Case) -> None:
    """Require that prescribed sides name components that exist, and tables of the same length."""
    for side in case.outline.faces:
        support = case.supports.on(side)
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
            given = getattr(support, name)
            if isinstance(given, DisplacementHistory):
                table_agrees(f"supports.{side}.{name}", given.t, given.u, "u")


def edges_agree(case: Case) -> None:
    """Require that two sides that meet prescribe the same values on their common edge."""
    holds = {side: is_held_at(case, side) for side in case.outline.faces}
    for one, other in combinations(holds, 2):
        if frozenset((one, other)) not in case.outline.touching:
            continue
        for name in sorted(holds[one].keys() & holds[other].keys()):
            here, there = holds[one][name], holds[other][name]
            if not _same(here, there, partial(_shared, case, one, other)):
                raise InputError(
                    f"supports.{one} and supports.{other} meet, and hold {name} differently there, "
                    f"at {inline(here)} and at {inline(there)}; give both the same, or take {name} "
                    f"from one of them"
                )


def is_held_at(case: Case, side: str) -> dict[str, PrescribedValue]:
    """Return the components that are prescribed on a side, with a section's rollers."""
    support, names = case.supports.on(side), "xyz"[: case.dim]
    axis = case.outline.axis(side)
    across = "" if axis is None else names[axis]
    if side == "left" and case.supports.section != "none":
        return {across: 0.0}
    if side == "right" and case.supports.section == "fixed":
        return {across: 0.0}
    if isinstance(support, Prescribed):
        given = {name: getattr(support, name) for name in names}
        return {name: value for name, value in given.items() if value is not None}
    return dict.fromkeys({"rollers": across, "clamped": names}.get(support, ""), 0.0)


def _same(one: PrescribedValue, other: PrescribedValue, shared: Callable[[], np.ndarray]) -> bool:
    """Return whether two piecewise linear histories are equal wherever their sides meet.

    Parameters
    ----------
    one, other : the prescribed displacements.
    shared : returns the places of both sides (m), shape (3, n).
    """
    (t, u), (s, v) = as_table(one), as_table(other)
    times = np.union1d(t, s)
    first, second = np.interp(times, t, u), np.interp(times, s, v)
    slack = 1e-9 * max(np.abs(u).max(), np.abs(v).max())  # "0.03 mm" and "30 um" differ a little
    if isinstance(one, DisplacementFile) or isinstance(other, DisplacementFile):
        places = shared()
        first, second = _at(one, first, places), _at(other, second, places)
        slack = INTERPOLATED * max(np.abs(u).max(), np.abs(v).max())
    return bool(np.all(np.abs(first - second) <= slack))


def _at(value: PrescribedValue, history: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Return a displacement at places and times, shape (n, times); history: its largest value."""
    if not isinstance(value, DisplacementFile):
        return np.broadcast_to(history, (places.shape[1], len(history)))
    share = value.field.reaching(np.inf)(places) / (largest_displacement(value) or 1.0)
    return np.asarray(share[:, None] * history)


def _shared(case: Case, one: str, other: str) -> np.ndarray:
    """Return the places that two faces share, of those that are looked at, shape (3, n)."""
    here, there = (case.outline.places.on(face) for face in (one, other))
    near = scipy.spatial.cKDTree(there.T).query(here.T)[0] <= SAME * max(case.outline.size)
    return here[:, near]


def as_table(value: PrescribedValue) -> tuple[np.ndarray, np.ndarray]:
    """Return times (s) and displacements (m) of a component, each of shape (n,).

    A field in a file counts by its largest value.
    """
    if isinstance(value, DisplacementFile):
        times, factor = factors(value)
        return times, factor * largest_displacement(value)
    if isinstance(value, DisplacementHistory):
        return np.array(value.t, dtype=float), np.array(value.u, dtype=float)
    return np.zeros(1), np.full(1, float(value))


def something_happens(case: Case) -> None:
    """Require that the body is cooled or moved, or that forces act on it."""
    if case.temperature.profile == "none" and not is_moved(case) and case.forces is None:
        raise InputError(
            'the case loads nothing: temperature.profile = "none", no prescribed displacement '
            "other than zero, and no [forces]; give one of them, or a load of a script"
        )


def is_moved(case: Case) -> bool:
    """Return True if a displacement other than zero is prescribed on some side."""
    return any(_moves(case.supports.on(side)) for side in case.outline.faces)


def moved_axes(case: Case) -> tuple[int, ...]:
    """Return axes along which faces across them are moved; none if a face is moved sideways too."""
    faces = case.outline.faces
    moved = [(case.outline.axis(side), _moves(case.supports.on(side))) for side in faces]
    if any(along - {axis} for axis, along in moved):
        return ()
    return tuple(sorted(set().union(*(along for _, along in moved))))


def _moves(support: object) -> set[int]:
    """Return the axes along which a support moves its side."""
    if not isinstance(support, Prescribed):
        return set()
    given = (support.x, support.y, support.z)
    return {k for k, c in enumerate(given) if c is not None and np.any(as_table(c)[1])}
