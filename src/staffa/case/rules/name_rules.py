"""Rules on names: what a case says of the parts of its body is said of parts that are there."""

from collections.abc import Collection
from pathlib import Path

from staffa.case.schema.case import Case, Named, SupportKeys
from staffa.case.schema.force_keys import ForceKeys
from staffa.case.schema.heat_keys import HeatKeys
from staffa.case.schema.toml_text import inline
from staffa.case.values.attached_files import attached
from staffa.errors import InputError, choices
from staffa.geometry.block import SIDES
from staffa.geometry.outline import Outline

# What stands in these tables beside the names of faces.
OWN = {
    "supports": set(SupportKeys.model_fields) - set(SIDES[3]),
    "heat": set(HeatKeys.model_fields) - set(SIDES[3]),
    "forces": set(ForceKeys.model_fields) - set(SIDES[3]),
}


def faces_are_there(case: Case) -> None:
    """Require that tables name faces of the body, and that no face has the name of a key."""
    faces = case.outline.faces
    for table in OWN:
        keys = getattr(case, table)
        if keys is None:
            continue
        for name in sorted(OWN[table] & set(faces)):
            raise InputError(
                f"the body has a face '{name}', which is a key of [{table}]; call it otherwise"
            )
        for name in sorted(keys.model_fields_set - OWN[table] - set(faces)):
            if keys.on(name) is not None:
                raise InputError(f"{table}.{name}: {_none(case)}; {choices(name, faces)}")


def _none(case: Case) -> str:
    if case.domain.is_block:
        return "a 2-D body has no such face"
    return f"the {'mesh' if case.domain.mesh else 'shape'} has no such face"


def files_are_called_apart(case: Case) -> None:
    """Require that no two files have one name: a run keeps them side by side."""
    found: dict[str, Path] = {}
    for file in attached(case):
        other = found.setdefault(file.name, file)
        if other != file:
            raise InputError(
                f"{other} and {file} have one name, by which a run keeps them; rename one"
            )


def cracks_are_there(case: Case) -> None:
    """Require that a case names each crack of its mesh once, and no others.

    Cracks that the mesh only numbers need no name: meshers number every line between two parts.
    """
    cracks = case.outline.cracks
    named = [crack.name for crack in case.cracks if isinstance(crack, Named)]
    for name in named:
        if name not in cracks:
            none = "it has none; name it in the mesh, or leave it out"
            has = choices(name, cracks) if cracks else none
            raise InputError(
                f"cracks, name = {inline(name)}: the body has no such crack inside; {has}"
            )
        if named.count(name) > 1:
            raise InputError(f'cracks, name = "{name}" is there twice; leave one out')
    for name in cracks:
        if name not in named and not name.isdigit():
            raise InputError(
                f"the mesh names '{name}' inside the body, of which the case says nothing; add "
                f'[[cracks]] with name = "{name}" if it is a crack, or remove the name from the '
                f"mesh; its names inside are {', '.join(cracks)}"
            )


def regions_are_there(given: Collection[str], body: Outline) -> None:
    """Require that a case names regions of the body, and each of them if there are several.

    A single region need not be named, nor regions that the mesh only numbers.

    Parameters
    ----------
    given : names after [regions. in the case.
    body : outline of the body.
    """
    for name in given:
        if name not in body.regions:
            has = choices(name, body.regions) if body.regions else "it has none; leave it out"
            raise InputError(f"regions.{name}: the body has no such region; {has}")
    for name in body.regions:
        if len(body.regions) > 1 and name not in given and not name.isdigit():
            raise InputError(
                f"the body has a region '{name}', of which the case says nothing; add a table "
                f"[regions.{name}], empty if its rock is that of [material]; its regions are "
                f"{', '.join(body.regions)}"
            )
