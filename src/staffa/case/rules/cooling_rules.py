"""Rules on the cooling, and on what is measured below the cooled face."""

from itertools import pairwise

from staffa.case.rules.body_rules import ROUND_OFF
from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import amount
from staffa.case.schema.toml_text import inline
from staffa.case.values.diffusion_time import depth
from staffa.errors import InputError, choices


def cooling_is_one(case: Case) -> None:
    """Require a face that exists; refuse dT and severity together, or where they do not count."""
    keys = case.temperature
    faces = case.outline.faces
    if keys.face not in faces and (case.domain.is_block or keys.profile != "none"):
        raise InputError(
            f"temperature.face: the body has no face '{keys.face}'; {choices(keys.face, faces)}"
        )
    if keys.profile == "none" or case.conducts:
        for name in ("dT", "severity", "biot"):
            if getattr(keys, name) is not None:
                elsewhere = f", where [{keys.profile}] says what does" if case.conducts else ""
                raise InputError(
                    f"temperature.{name} = {inline(getattr(keys, name))} cools nothing with "
                    f'temperature.profile = "{keys.profile}"{elsewhere}; leave one of them out'
                )
    elif keys.dT is not None and keys.severity is not None:
        raise InputError(
            "temperature.dT and temperature.severity: both are given; give exactly one of them"
        )


def cooling_is_complete(case: Case) -> None:
    """Require one of dT and severity, if they make the temperature."""
    keys = case.temperature
    if keys.profile != "none" and not case.conducts and keys.dT is None and keys.severity is None:
        raise InputError(
            "temperature.dT and temperature.severity: neither is given; give exactly one of them"
        )


def depth_has_a_meaning(case: Case) -> None:
    """Require that the cooled face is a flat side of the body, where keys need a depth below it."""
    keys, sides = case.temperature, case.outline.sides
    if keys.profile == "none" or sides[keys.face] is not None:
        return
    flat = ", ".join(sorted(name for name, side in sides.items() if side)) or "none"
    why = (
        f"'{keys.face}' (temperature.face) is no flat side of the body, below which there is a "
        f"depth; flat are: {flat}"
    )
    if not case.conducts:
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
    if keys.profile not in ("convective", "none") and not case.conducts and keys.biot is not None:
        raise InputError(
            f'temperature.biot = {keys.biot:g} has no meaning for profile = "{keys.profile}"; '
            f'leave it out or take temperature.profile = "convective"'
        )


def measures_are_inside(case: Case) -> None:
    """Require counting depths inside of the body, each once, and only below a flat face."""
    if not case.measures.depths:
        return
    where = f"measures.depths = {inline(case.measures.depths)}"
    if case.temperature.profile == "none":
        raise InputError(
            f'{where}: there is no cooled face to count from (temperature.profile = "none"); '
            f"leave it out"
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
