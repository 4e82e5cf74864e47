"""Rules on the table [forces], and on the energy split that goes with it."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from staffa.case.rules.heat_rules import TRIED
from staffa.case.rules.time_rules import table_agrees, times_given
from staffa.case.schema.case import Case
from staffa.case.schema.field_types import Formula
from staffa.case.schema.force_keys import ForceKeys, StressWithDepth
from staffa.case.schema.heat_keys import InTime
from staffa.case.schema.toml_text import as_toml, inline
from staffa.case.values.applied_forces import COMPONENTS
from staffa.case.values.default_split import (
    default_split,
    given_strengths,
    is_anisotropic,
    presses,
)
from staffa.case.values.diffusion_time import times_in
from staffa.case.values.subdomains import averages, subdomains_of
from staffa.errors import InputError
from staffa.physics.split import SPLITS
from staffa.properties.formula import formula, formula_variables, trial
from staffa.units import Quantity, parse

# Values that do not change with time: the rock is in equilibrium under them.
STILL = "prestress"
BY_DEFAULT = "the default where something may be pressed"


def forces_say_something(case: Case) -> None:
    """Require that the table acts on the body, and that its needs are met."""
    keys = case.forces
    if keys is None:
        return
    if keys.prestress is not None and not keys.prestress.model_fields_set:
        raise InputError(
            f"forces.prestress says nothing; give {', '.join(COMPONENTS)} or some of them, or "
            f"leave it out"
        )
    if not presses(case):
        raise InputError(
            "[forces] says nothing; give prestress, gravity, a side, pore_pressure, "
            "crack_pressure or crack_volume, or leave it out"
        )
    if keys.crack_pressure is not None and keys.crack_volume is not None:
        raise InputError(
            "forces.crack_pressure and forces.crack_volume: the volume that a fluid takes up "
            "determines its pressure; leave one of them out"
        )
    if keys.crack_volume is not None and not case.cracks:
        raise InputError(
            "forces.crack_volume: there is no crack for the fluid; give one in [[cracks]]"
        )
    exact = case.solver.stability in ("report", "follow")
    if keys.crack_volume is not None and exact:
        raise InputError(
            f"solver.stability = {inline(case.solver.stability)} does not know of a "
            f"prescribed volume; leave it out, or take forces.crack_pressure"
        )
    if keys.biot is not None and keys.pore_pressure is None:
        raise InputError(
            f"forces.biot = {keys.biot:g} has no meaning without forces.pore_pressure; leave it out"
        )


def forces_fit_the_body(case: Case) -> None:
    """Require sides, components and gradients that the body and its plane state have."""
    keys, dim = case.forces, case.dim
    if keys is None:
        return
    for name, side in keys.by_side().items():
        where = f"forces.{name}"
        if not side.model_fields_set:
            raise InputError(f"{where} says nothing; give pressure, x or y, or leave it out")
        if dim == 2 and side.z is not None:
            raise InputError(f"{where}.z: a 2-D body has no such axis; leave it out")
    if keys.gravity is not None and len(keys.gravity) != dim:
        raise InputError(
            f"forces.gravity = {inline(keys.gravity)}: it needs {dim} numbers, as the body is "
            f"{dim}-D"
        )
    _stress_fits(case, keys)
    for where, value, _ in _values(keys):
        if isinstance(value, StressWithDepth) and len(value.gradient) != dim:
            raise InputError(
                f"{where}.gradient = {inline(value.gradient)}: it needs {dim} numbers, as the body "
                f"is {dim}-D"
            )
        if isinstance(value, InTime):
            table_agrees(where, value.t, value.value, "value")
    _volume_fits(case, keys)


def _stress_fits(case: Case, keys: ForceKeys) -> None:
    if keys.pore_pressure is not None and case.plane_stress:
        raise InputError(
            "forces.pore_pressure: in plane stress pores would press the plate apart; take "
            'material.plane = "strain", or a 3-D body'
        )
    if keys.prestress is None or case.dim == 3:
        return
    for name in ("yz", "xz"):
        if getattr(keys.prestress, name) is not None:
            raise InputError(f"forces.prestress.{name}: a 2-D body has none; leave it out")
    if keys.prestress.zz is not None and case.plane_stress:
        raise InputError(
            "forces.prestress.zz: plane stress has none across the plane; leave it out, or take "
            'material.plane = "strain"'
        )


def _volume_fits(case: Case, keys: ForceKeys) -> None:
    """Require that a volume in 2-D is one per thickness."""
    value = keys.crack_volume
    for volume in value.value if isinstance(value, InTime) else (value,):
        if isinstance(volume, Quantity) and volume.has_units:
            try:
                parse(volume.given, "volume per thickness" if case.extents == 2 else "volume")
            except InputError as error:
                raise InputError(f"forces.crack_volume = {as_toml(volume)}: {error}") from None


def split_fits_the_rock(case: Case) -> None:
    """Require isotropic rock with nu >= 0 for splits by principal strains."""
    name = case.damage.split
    if case.damage.gamma is not None and name != "star-convex":
        raise InputError(
            f"damage.gamma = {case.damage.gamma:g} has no meaning but with damage.split = "
            f'"star-convex"; leave it out'
        )
    name = name or default_split(case)
    if name == "none":
        return
    if case.plane_stress and any(averages(p).nu >= 0.5 for p in subdomains_of(case)):
        raise InputError(
            f'damage.split = "{name}"{_by_default(case)} needs a bulk modulus, and rock with nu = '
            f"0.5 has none; take 0.49 or less"
        )
    if not SPLITS[name].isotropic:
        return
    if is_anisotropic(case):
        raise InputError(
            f'damage.split = "{name}"{_by_default(case)} is for isotropic rock, and this one is '
            f"not; {_for_any_rock(case)}"
        )
    for subdomain in subdomains_of(case):
        if (nu := averages(subdomain).nu) < 0:
            raise InputError(
                f'damage.split = "{name}"{_by_default(case)} is for nu >= 0, and '
                f"{subdomain.where}.nu = {nu:g}; {_for_any_rock(case)}"
            )


def _by_default(case: Case) -> str:
    if case.damage.split:
        return ""
    strengths = given_strengths(case)
    of = f"that of damage.{' and damage.'.join(strengths)}" if strengths else BY_DEFAULT
    return f", {of},"


def _for_any_rock(case: Case) -> str:
    """Return the way out of a split that is for isotropic rock with nu >= 0."""
    keys = [f"damage.{name}" for name in given_strengths(case)]
    if not keys:
        return 'take "volumetric-deviatoric"'
    keys += ["damage.split"] if case.damage.split else []
    return f"such rock has no strengths but damage.strength: leave {' and '.join(keys)} out"


def _values(keys: ForceKeys) -> Iterator[tuple[str, Any, str | None]]:
    """Yield each value that may be a table or a formula: its key, itself, and its side if any."""
    for name in COMPONENTS if keys.prestress is not None else ():
        yield f"forces.prestress.{name}", getattr(keys.prestress, name), None
    for side, table in keys.by_side().items():
        for name in type(table).model_fields:
            yield f"forces.{side}.{name}", getattr(table, name), side
    for name in ("pore_pressure", "crack_pressure", "crack_volume"):
        yield f"forces.{name}", getattr(keys, name), None


def formulas_of_forces_give_numbers(case: Case) -> None:
    """Require that every formula gives finite numbers, see `formulas_give_numbers`."""
    if case.forces is None:
        return
    visited = times_in(case, times_given(case)[[0, -1]])
    times = sorted({*np.linspace(0.0, visited[-1], TRIED).tolist(), *visited})
    for where, value, side in _values(case.forces):
        if not isinstance(value, Formula):
            continue
        still = side is None and where.split(".")[1] == STILL
        of_volume = where == "forces.crack_volume"
        known = ("t",) if of_volume else formula_variables(case.dim, time=not still)
        try:
            function = formula(value.formula, known)
            there = case.outline.places.on(side)
            for t in times:
                found = trial(function, known, there, t)
                if of_volume and found.min() < 0:
                    raise InputError(f"it must not be negative, and is at t = {t:.4g}")
        except InputError as error:
            raise InputError(f"{where}.formula = {as_toml(value.formula)}: {error}") from None
