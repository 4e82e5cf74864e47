"""Rules on the rock: where its regions are, and that its values are such as rocks have."""

from typing import Any

import numpy as np

from staffa.case.rules.anisotropy_rules import are_perpendicular, fits_the_dimension, turning
from staffa.case.rules.body_rules import box_is_inside
from staffa.case.rules.file_rules import covers
from staffa.case.rules.name_rules import regions_are_there
from staffa.case.schema.case import Case
from staffa.case.schema.field_types import Formula, is_name
from staffa.case.schema.material_keys import RATIOS, RegionKeys, RockKeys, is_isotropic
from staffa.case.schema.property_keys import RandomField
from staffa.case.schema.temperature_keys import of_temperature
from staffa.case.schema.toml_text import as_toml, inline
from staffa.case.values.property_functions import point_property, varies
from staffa.case.values.stiffness import elasticity
from staffa.case.values.subdomains import Subdomain, subdomains_of
from staffa.errors import InputError
from staffa.physics.elasticity import checked
from staffa.properties.formula import formula, formula_variables, trial

# A normal field of a larger variation would reach zero at one place in a few million.
NORMAL = 0.2


def regions_are_places(case: Case) -> None:
    """Require regions that are boxes that meet a block, or that a shape or a mesh names."""
    for name, region in case.regions.items():
        try:
            is_name(name)
        except ValueError as error:
            raise InputError(
                f"[regions.{as_toml(name, 20)}]: {error}; write it like [regions.clay]"
            ) from None
        if case.domain.is_block:
            _is_a_box(case, f"regions.{name}", region)
        elif region.lower is not None or region.upper is not None:
            raise InputError(
                f"[regions.{name}] has a box, but the regions of a shape or a mesh are those that "
                f"it names; leave lower and upper out"
            )
    if not case.domain.is_block:
        regions_are_there(case.regions, case.outline)


def _is_a_box(case: Case, where: str, region: RegionKeys) -> None:
    if not {*RockKeys.model_fields} & region.model_fields_set:
        raise InputError(
            f"[{where}] says nothing of its rock; give what differs from [material], like E"
        )
    if region.lower is None or region.upper is None:
        raise InputError(
            f"[{where}] needs its box: in a body of domain.size a region is where lower and "
            f"upper say; give both, as corners"
        )
    box_is_inside(case, region.lower, region.upper, where)


def random_fields_are_possible(case: Case) -> None:
    """Require lengths and directions of the body's dimension, and normal fields far from zero."""
    for subdomain in subdomains_of(case):
        for _, where, value in subdomain.properties():
            if isinstance(value, RandomField):
                _is_possible(where, value, case.dim)


def _is_possible(where: str, value: RandomField, dim: int) -> None:
    several = value.length if isinstance(value.length, tuple) else None
    if several is not None and len(several) != dim:
        raise InputError(
            f"{where}.length = {inline(several)}: give one number, or {dim}, as the body is {dim}-D"
        )
    fits_the_dimension(where, dim, value.angle, value.axes)
    if value.axes is not None:
        are_perpendicular(f"{where}.axes", value.axes)
    if several is None and (value.angle is not None or value.axes is not None):
        raise InputError(
            f"{where}.{turning(dim)} turns nothing: one length is the same in all directions; "
            f"leave it out, or give a list of lengths"
        )
    if value.distribution == "normal" and value.variation > NORMAL:
        raise InputError(
            f"{where}.variation = {value.variation:g}: a normal field of more than {NORMAL:g} "
            f'would fall below zero somewhere; take distribution = "lognormal" or "weibull"'
        )


def properties_have_values(case: Case) -> None:
    """Require that properties that vary have possible values at all sampled places."""
    for subdomain in subdomains_of(case):
        for name, where, value in subdomain.properties():
            if not varies(value) or isinstance(value, RandomField) or of_temperature(value):
                continue  # a random field's values are looked at with the mesh, others by their law
            found = _tried_values(where, value, subdomain)
            if name not in RATIOS and found.min() <= 0:
                raise InputError(
                    f"{where} = {as_toml(value)}: it is {found.min():.4g} somewhere and must be "
                    f"larger than zero"
                )


def _tried_values(where: str, value: Any, subdomain: Subdomain) -> np.ndarray:
    """Return a property's values at the sampled places of its subdomain, if they are finite
    numbers."""
    places = subdomain.places().x
    if isinstance(value, Formula):
        try:
            known = formula_variables(subdomain.dim, time=False)
            return trial(formula(value.formula, known), known, places, 0.0)
        except InputError as error:
            raise InputError(f"{where}.formula = {as_toml(value.formula)}: {error}") from None
    found: np.ndarray = value.at_points(subdomain.dim)(places)
    covers(where, value, subdomain.dim, places, found)
    return found


def elasticity_is_definite(case: Case) -> None:
    """Require that the stiffness resists every strain.

    nu must be less than 0.5 where the volume is constrained, or where the whole stiffness is needed
    since other rock of the body has directions.
    """
    where = "" if case.plane_stress else "plane strain" if case.material.plane else "3-D"
    where = "a body of revolution" if case.axial else where
    if not all(is_isotropic(subdomain.keys) for subdomain in subdomains_of(case)):
        where = where or "a body some of whose stiffness has directions"
    for subdomain in subdomains_of(case):
        keys = subdomain.keys
        if is_isotropic(keys):
            _can_be_compressed(subdomain, where)
            continue
        varying = any(varies(value) for _, _, value in subdomain.properties())
        try:
            places = subdomain.places().x if varying else np.zeros((3, 1))
            checked(elasticity(keys, _tried(subdomain)).stiffness(places))
        except InputError as error:
            raise InputError(f"{subdomain.where}: {error}") from None


def _tried(subdomain: Subdomain) -> Any:
    """Return a function that evaluates a property for a trial: a random field by its mean."""
    return lambda value: (
        float(value.mean)
        if isinstance(value, RandomField)
        else point_property(value, subdomain.dim)
    )


def _can_be_compressed(subdomain: Subdomain, where: str) -> None:
    """Require nu less than 0.5. where: the kind of body for which this holds, for the message."""
    given = subdomain.keys.nu
    nu = _tried(subdomain)(given)
    largest = float(np.max(nu(subdomain.places().x))) if callable(nu) else nu
    least = float(np.min(nu(subdomain.places().x))) if callable(nu) else nu
    said = f"{subdomain.where}.nu = {as_toml(given)}"
    if not -1 < least <= largest <= 0.5:
        beyond = least if least <= -1 else largest
        raise InputError(f"{said}: it is {beyond:.4g} somewhere; keep it between -1 and 0.5")
    if largest >= 0.5 and where:
        out = ', or material.plane = "stress"' if where == "plane strain" else ""
        raise InputError(
            f"{said}: in {where} it must be less than 0.5 (incompressible); take 0.49 or less{out}"
        )
