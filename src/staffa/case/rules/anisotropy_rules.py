"""Rules on what has directions: which keys of a stiffness go together, axes, lists along them."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from staffa.case.schema.case import Case
from staffa.case.schema.material_keys import ELASTIC, ORIENTATION, is_isotropic
from staffa.case.schema.toml_text import as_toml, inline
from staffa.case.values.subdomains import Subdomain, has_directions, subdomains_of
from staffa.errors import InputError

BEDDED = ("E", "nu", "E_axis", "nu_axis", "G_axis")
ORTHOTROPIC = {"E": "E1, E2, E3", "nu": "nu12, nu23, nu13", "G": "G12, G23, G13"}
PERPENDICULAR = 1e-6  # cosine of the angle between two axes


def stiffness_is_complete(case: Case) -> None:
    """Require E and nu; or these and three more across a bedding, three lists, or a whole
    stiffness."""
    for subdomain in subdomains_of(case):
        keys = subdomain.keys
        if keys.stiffness is not None:
            _stiffness_is_alone(case, subdomain)
        elif any(getattr(keys, name) is not None for name in BEDDED[2:]):
            _is_bedded(subdomain)
        elif is_isotropic(keys):
            _are_given(subdomain, ("E", "nu"), "an isotropic rock has both")
        else:
            _is_orthotropic(case, subdomain)


def _said(case: Case, subdomain: Subdomain) -> list[str]:
    """Return the keys of the stiffness that a subdomain gives, not those left at their defaults."""
    keys = subdomain.keys
    return [
        name
        for name in ELASTIC
        if getattr(keys, name) is not None and name in keys.model_fields_set
    ]


def _stiffness_is_alone(case: Case, subdomain: Subdomain) -> None:
    others = [name for name in _said(case, subdomain) if name != "stiffness"]
    if others:
        raise InputError(
            f"{subdomain.where}: stiffness says all of the elasticity, and {' and '.join(others)} "
            f"cannot stand beside it; leave one of them out"
        )
    C = subdomain.keys.stiffness or ()
    if len(C) != 6 or any(len(row) != 6 for row in C):
        rows = "one row" if len(C) == 1 else f"{len(C)} rows"
        raise InputError(
            f"{subdomain.where}.stiffness has {rows} of {_lengths(C)} numbers; it needs six "
            f"rows of six, in the order 11, 22, 33, 23, 13, 12"
        )


def _lengths(rows: Sequence[Sequence[float]]) -> str:
    return " and ".join(str(n) for n in sorted({len(row) for row in rows})) or "no"


def _is_bedded(subdomain: Subdomain) -> None:
    keys, where = subdomain.keys, subdomain.where
    if keys.G is not None or isinstance(keys.E, tuple) or isinstance(keys.nu, tuple):
        raise InputError(
            f"{where}: E_axis, nu_axis and G_axis are of a rock with bedding, and lists of E, nu "
            f"and G of an orthotropic one; leave one of the two out"
        )
    _are_given(subdomain, BEDDED, "a rock with bedding (transversely isotropic) has all five")
    if keys.axis is None:
        raise InputError(
            f"{where}.axis is missing: E_axis, nu_axis and G_axis are across the bedding; give "
            f"its direction, like axis = {inline([0.0] * (subdomain.dim - 1) + [1.0])}"
        )


def _is_orthotropic(case: Case, subdomain: Subdomain) -> None:
    keys, where = subdomain.keys, subdomain.where
    _are_given(subdomain, ("E", "nu", "G"), "an orthotropic rock has a list of each")
    flat = case.plane_stress
    for name, fewer in (("E", 2), ("nu", 1), ("G", 1)):
        given = getattr(keys, name)
        counts = (fewer, 3) if flat else (3,)
        if not isinstance(given, tuple) or len(given) not in counts:
            few = ORTHOTROPIC[name].split(", ")[:fewer]
            enough = f" (in plane stress {', '.join(few)} {'is' if fewer == 1 else 'are'} enough)"
            raise InputError(
                f"{where}.{name} = {as_toml(given)}: of an orthotropic rock it is a list, "
                f"[{ORTHOTROPIC[name]}]{enough if flat else ''}"
            )
    if keys.axis is not None:
        raise InputError(
            f"{where}.axis is for a rock with bedding, and lists of E, nu and G make it "
            f"orthotropic; give its axes by {turning(subdomain.dim)}"
        )


def _are_given(subdomain: Subdomain, needed: Sequence[str], rule: str) -> None:
    for name in needed:
        if getattr(subdomain.keys, name) is None:
            region = subdomain.where != "material"
            whole = "; a region with its own stiffness gives all of it" if region else ""
            raise InputError(f"{subdomain.where}.{name} is missing: {rule}{whole}; add it")


def turning(dim: int) -> str:
    """Return the key that says how axes lie."""
    return "angle" if dim == 2 else "axes"


def axes_are_directions(case: Case) -> None:
    """Require at most one of axis, angle and axes, which fits the dimension and has an effect."""
    for subdomain in subdomains_of(case):
        keys, where, dim = subdomain.keys, subdomain.where, case.dim
        given = [name for name in ORIENTATION if getattr(keys, name) is not None]
        if len(given) > 1:
            raise InputError(
                f"{where}: {' and '.join(given)} both say how the rock lies; give one of them"
            )
        fits_the_dimension(where, dim, keys.angle, keys.axes)
        if keys.axis is not None and (len(keys.axis) != dim or not any(keys.axis)):
            raise InputError(
                f"{where}.axis = {inline(keys.axis)} is no direction; give {dim} numbers, not all "
                f"zero"
            )
        if keys.axes is not None:
            are_perpendicular(f"{where}.axes", keys.axes)
    _turn_something(case)


def fits_the_dimension(where: str, dim: int, angle: Any, axes: Any) -> None:
    """Require that the directions of rock are given by angle in 2-D and by axes in 3-D.

    Parameters
    ----------
    where : the table, for messages.
    dim : dimension of the body.
    angle : value of the key angle (degrees), None if left out.
    axes : value of the key axes, two directions, None if left out.
    """
    if angle is not None and dim == 3:
        raise InputError(
            f"{where}.angle = {inline(angle)} is for 2-D bodies; give axes, two directions"
        )
    if axes is not None and dim == 2:
        raise InputError(
            f"{where}.axes is for 3-D bodies; give angle, from x to the first axis in degrees"
        )


def are_perpendicular(where: str, axes: Sequence[Sequence[float]]) -> None:
    """Require two directions in space that enclose a right angle."""
    given = f"{where} = {as_toml(axes)}"
    if len(axes) != 2 or any(len(a) != 3 or not any(a) for a in axes):
        raise InputError(f"{given}: give two directions of three numbers each, not all zero")
    first, second = (np.array(a, dtype=float) / np.linalg.norm(a) for a in axes)
    if abs(cosine := float(first @ second)) > PERPENDICULAR:
        degrees = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
        raise InputError(
            f"{given}: they enclose {degrees:.4g} degrees and must be perpendicular; turn one"
        )


def _turn_something(case: Case) -> None:
    body, *others = subdomains_of(case)
    for subdomain in (body, *others):
        own = (
            case.regions[subdomain.where.split(".", 1)[1]]
            if subdomain is not body
            else case.material
        )
        given = [name for name in ORIENTATION if getattr(own, name) is not None]
        found = [body, *others] if subdomain is body else [subdomain]
        if given and not any(has_directions(p.keys) for p in found):
            raise InputError(
                f"{subdomain.where}.{given[0]} turns nothing: this rock is the same in all "
                f"directions; leave it out, or give lists of what differs, like Gc or expansion"
            )


def lists_have_a_number_an_axis(case: Case) -> None:
    """Require that lists along the rock's axes are as long as there are such axes."""
    for subdomain in subdomains_of(case):
        for name in ("Gc", "expansion", "k"):
            given = getattr(subdomain.keys, name)
            if not isinstance(given, tuple):
                continue
            counts, why = _counts(case, subdomain, name)
            if len(given) not in counts:
                needed = " or ".join(str(n) for n in counts)
                raise InputError(
                    f"{subdomain.where}.{name} = {inline(given)}: it needs {needed} numbers, {why}"
                )


def _counts(case: Case, subdomain: Subdomain, name: str) -> tuple[tuple[int, ...], str]:
    if subdomain.keys.axis is not None:
        return (2,), "along the bedding and across it, since axis is given"
    if name == "expansion" and case.dim == 2:
        if case.axial:
            return (3,), "along r, along z and around the axis"
        if case.material.plane == "strain":
            return (3,), "since in plane strain the third direction is constrained"
        return (2, 3), "along the rock's axes"
    return (case.dim,), f"as the body is {case.dim}-D"
