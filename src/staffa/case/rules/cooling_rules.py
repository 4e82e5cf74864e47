"""Rules on the cooling, and on what is measured below the cooled face."""

from itertools import pairwise

import numpy as np

from staffa.case.rules.body_rules import ROUND_OFF
from staffa.case.rules.time_rules import times_given
from staffa.case.schema.case import Case
from staffa.case.schema.cooling_keys import FACELESS, FORMULA, NO_FACE, RESERVOIR
from staffa.case.schema.quantity_text import amount
from staffa.case.schema.toml_text import as_toml, inline
from staffa.case.values.diffusion_time import depth, times_in
from staffa.errors import InputError, choices
from staffa.properties.formula import formula, formula_variables, trial

TRIED = 41  # times at which a formula is tried


# Profiles without a drop, and the keys that give their temperature.
ELSEWHERE = {
    "none": "",
    "heat": ", where [heat] says what does",
    RESERVOIR: ", where [reservoir] says what does",
    FORMULA: ", where temperature.T says what does",
}


def cooling_is_one(case: Case) -> None:
    """Require a face that exists; refuse dT and severity together, or where they do not count."""
    keys = case.temperature
    faces = case.outline.faces
    needed = keys.has_face or (case.domain.is_block and keys.face != NO_FACE)
    if keys.face not in faces and needed:
        raise InputError(
            f"temperature.face: the body has no face '{keys.face}'; {choices(keys.face, faces)}"
        )
    if keys.profile in ELSEWHERE:
        for name in ("dT", "severity", "biot"):
            if getattr(keys, name) is not None:
                elsewhere = ELSEWHERE[keys.profile]
                raise InputError(
                    f"temperature.{name} = {inline(getattr(keys, name))} cools nothing with "
                    f'temperature.profile = "{keys.profile}"{elsewhere}; leave one of them out'
                )
    elif keys.dT is not None and keys.severity is not None:
        raise InputError(
            "temperature.dT and temperature.severity: both are given; give exactly one of them"
        )


def cooling_is_complete(case: Case) -> None:
    """Require one of dT and severity, or the formula, if they make the temperature."""
    keys = case.temperature
    if keys.profile == FORMULA and keys.T is None:
        raise InputError(
            f'temperature.T is missing: with temperature.profile = "{FORMULA}" it gives the change '
            f'of temperature; write it like T = "-80*exp(-y/0.02)*(1 - exp(-t/60))"'
        )
    if keys.profile not in ELSEWHERE and keys.dT is None and keys.severity is None:
        raise InputError(
            "temperature.dT and temperature.severity: neither is given; give exactly one of them"
        )


def depth_has_a_meaning(case: Case) -> None:
    """Require that the cooled face is a flat side of the body, where keys need a depth below it."""
    keys, sides = case.temperature, case.outline.sides
    if not keys.has_face or sides[keys.face] is not None:
        return
    flat = ", ".join(sorted(name for name, side in sides.items() if side)) or "none"
    why = (
        f"'{keys.face}' (temperature.face) is no flat side of the body, below which there is a "
        f"depth; flat are: {flat}"
    )
    if keys.profile in FACELESS:
        raise InputError(f'temperature.face: {why}; name one of them, or take face = "{NO_FACE}"')
    if keys.profile != "heat":
        raise InputError(
            f'temperature.profile = "{keys.profile}": {why}; take temperature.profile = "heat", '
            f"which cools any face"
        )
    if case.time.tau is not None:
        raise InputError(f"time.tau counts in the depth of the body, and {why}; give time.t")
    if case.measures.depths:
        raise InputError(f"measures.depths = {inline(case.measures.depths)}: {why}; leave it out")


def film_is_convective(case: Case) -> None:
    """Require biot for a convective profile, and refuse it for others."""
    keys = case.temperature
    if keys.profile == "convective" and keys.biot is None:
        raise InputError(
            "temperature.biot is missing: a convective profile needs the film coefficient times L "
            "over the conductivity; write it like biot = 10.0"
        )
    if keys.profile not in ("convective", *ELSEWHERE) and keys.biot is not None:
        raise InputError(
            f'temperature.biot = {keys.biot:g} has no meaning for profile = "{keys.profile}"; '
            f'leave it out or take temperature.profile = "convective"'
        )


def measures_are_inside(case: Case) -> None:
    """Require counting depths inside of the body, each once, and only below a flat face."""
    if not case.measures.depths:
        return
    where = f"measures.depths = {inline(case.measures.depths)}"
    if not case.temperature.acts:
        raise InputError(
            f'{where}: there is no cooled face to count from (temperature.profile = "none"); '
            f"leave it out"
        )
    if not case.temperature.has_face:
        raise InputError(
            f'{where}: there is no face to count from (temperature.face = "{NO_FACE}"); give it, '
            f'like face = "bottom", or leave depths out'
        )
    L = depth(case)
    for below in case.measures.depths:
        if below * ROUND_OFF >= L:
            raise InputError(
                f"measures.depths: {inline(below)} lies outside the body, which is "
                f"{amount(case, L, 'm', digits=6)} deep; take smaller depths"
            )
    for before, after in pairwise(sorted(case.measures.depths)):
        if after <= before * ROUND_OFF:
            raise InputError(f"measures.depths: {inline(after)} is there twice; leave one out")


def formula_of_temperature_gives_numbers(case: Case) -> None:
    """Require finite values of temperature.T at sampled places and times, and T only where it
    counts.

    The body starts at rest with a change of 0. What the formula gives at t = 0 is a jump that
    belongs to the first step, as a face that is cold at once does.
    """
    keys = case.temperature
    if keys.T is None:
        return
    said = f"temperature.T = {as_toml(keys.T)}"
    if keys.profile != FORMULA:
        raise InputError(
            f'{said} has no meaning with temperature.profile = "{keys.profile}"; leave it out or '
            f'take temperature.profile = "{FORMULA}"'
        )
    names, x = formula_variables(case.dim), case.outline.places.on()
    last = times_in(case, times_given(case)[-1:])[0]
    times = {*np.linspace(0.0, last, TRIED).tolist(), *times_in(case, times_given(case))}
    try:
        function = formula(keys.T, names)
        for t in sorted(times):
            trial(function, names, x, t)
    except InputError as error:
        raise InputError(f"{said}: {error}") from None
