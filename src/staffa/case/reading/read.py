"""From TOML text to a case, or to one sentence that says what is wrong with it."""

import re
import tomllib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from staffa.arguments import path_of, require, settings_of
from staffa.case.reading.earlier_keys import refuse, translate
from staffa.case.reading.inspect_mesh import inspected
from staffa.case.reading.messages import message, unknown_key
from staffa.case.reading.size_limits import LARGEST_FILE, text_is_short, too_large, values_are_few
from staffa.case.rules import obey
from staffa.case.schema.case import Case, SupportKeys
from staffa.case.schema.field_types import SidesTable
from staffa.case.schema.file_access import FileAccess
from staffa.case.schema.force_keys import ForceKeys
from staffa.case.schema.heat_keys import HeatKeys
from staffa.case.schema.property_keys import PLACE
from staffa.errors import InputError, choices
from staffa.io.run_directory import CASE, MANIFEST

# A number that TOML does not know, and a shell's user may type.
BARE_POINT = re.compile(r"[+-]?(\d+\.|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)

# What Python's reader says, where it means more to programmers.
SYNTAX = {
    "Cannot overwrite a value": "a key is given twice",
    "Duplicate inline table key": "a key is given twice",
    "Cannot declare": "a table is given twice",
    "Cannot redefine": "a table is given twice",
    "Cannot mutate": "a table is given twice",
    "Invalid value": "here is no value; a text needs quotes",
    "Invalid statement": "here is no key = value and no [table]",
}


def read_case(path: str | Path, settings: Sequence[str] = (), *, outside: bool = False) -> Case:
    """Read a case file, with `section.key=value` settings put over it.

    Parameters
    ----------
    path : the case file.
    settings : texts "section.key=value" that replace keys of the file.
    outside : True if the files that it names may lie outside of its folder.

    Raises
    ------
    InputError
        In one sentence: the key, the value, the rule, and the way out.
    """
    path, settings = path_of(path, "path"), settings_of(settings)
    content = _content(path)
    if len(content) > LARGEST_FILE:
        raise too_large(str(path))
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        raise InputError(f"{path} is no TOML file: it is not UTF-8 text; save it as such") from None
    of_run = path.name == CASE and (path.parent / MANIFEST).is_file()
    return parse_case(
        text, settings, name=str(path), folder=path.parent, outside=outside, of_run=of_run
    )


def _content(path: Path) -> bytes:
    """Return at most one byte more than a case file may have, also from an endless device."""
    try:
        with path.open("rb") as file:
            return file.read(LARGEST_FILE + 1)
    except FileNotFoundError:
        raise InputError(
            f"there is no file {path}; `staffa new slab > my.toml` writes one"
        ) from None
    except IsADirectoryError:
        inside = path / "case.toml"
        hint = f"{inside} is one" if inside.is_file() else "name the TOML file in it"
        raise InputError(f"{path} is a folder and no case file; {hint}") from None
    except OSError as error:
        raise InputError(
            f"{path} cannot be read ({error.strerror}); name a TOML file that you may read"
        ) from None


def parse_case(
    text: str,
    settings: Sequence[str] = (),
    *,
    name: str = "the case",
    folder: str | Path = Path(),
    outside: bool = False,
    of_run: bool = False,
) -> Case:
    """Read a case from TOML text; see `read_case`.

    Parameters
    ----------
    text : text of a case file.
    settings : `section.key=value` settings put over it.
    name : name of the case in messages.
    folder : folder from which paths in it count.
    outside : True if the files that it names may lie outside of that folder.
    of_run : True for the case of a run directory, where keys of 0.1.0 are translated.
    """
    require(text, str, "text", "give the text of a case file; staffa.read_case(path) reads a file")
    settings, folder = settings_of(settings), path_of(folder, "folder")
    text_is_short(text, name)
    try:
        table = tomllib.loads(text)
    except RecursionError:
        raise InputError(f"{name} is no case file: its brackets are nested too deeply") from None
    except ValueError as error:
        raise InputError(f"{name} is no TOML file: {_syntax(error)}") from None
    if of_run:
        translate(table)
    for setting in settings:
        _set(table, setting)
    refuse(table)
    values_are_few(table, name)
    _name_sides(table)
    place = FileAccess(folder, outside)
    try:
        case = Case.model_validate(table, context={PLACE: place})
    except ValidationError as error:
        raise InputError(message(error)) from None
    return obey(inspected(case, place))


# Tables whose keys may be the names of faces.
SIDED: dict[str, type[SidesTable]] = {
    "supports": SupportKeys,
    "heat": HeatKeys,
    "forces": ForceKeys,
}


def _name_sides(table: dict[str, Any]) -> None:
    """Refuse names of faces that a block does not have: such a name is a key misspelled."""
    domain = table.get("domain")
    if isinstance(domain, dict) and {"mesh", "shape"} & set(domain):
        return
    for name, model in SIDED.items():
        keys = table.get(name)
        for key in keys if isinstance(keys, dict) else ():
            if key not in model.model_fields:
                raise InputError(unknown_key([name], key))


def _syntax(error: ValueError) -> str:
    """Return the reader's words in the user's, with the place."""
    words, at, place = str(error).rpartition(" (at ")
    if not at:  # Python refuses whole numbers of thousands of digits without saying where
        return "it holds a number that is too long; shorten it"
    plain = [ours for theirs, ours in SYNTAX.items() if words.startswith(theirs)]
    what = plain[0] if plain else words[:1].lower() + words[1:]
    return f"{what} (at {place.removesuffix(')')}); correct it there"


def _set(table: dict[str, Any], setting: str) -> None:
    path, value = setting_names(setting), typed_value(setting_parts(setting)[1])
    within: Any = table
    for name in path[:-1]:
        within = _inner(setting, within, name)
    if isinstance(within, list):
        within[_entry(setting, within, path[-1])] = value
    else:
        within[path[-1]] = value


def _inner(setting: str, within: Any, name: str) -> Any:
    """Return the table or the list of a name in a table, or in a list."""
    if isinstance(within, list):
        inner = within[_entry(setting, within, name)]
    else:
        inner = within.setdefault(name, {})
    if not isinstance(inner, dict | list):
        raise InputError(
            f"--set {setting}: '{name}' is no table of the case; write it like --set damage.law=AT2"
        )
    return inner


def _entry(setting: str, entries: list[Any], name: str) -> int:
    """Return the place of the entry with this name in a list, or of this number from 1 on."""
    names = [one.get("name") if isinstance(one, dict) else None for one in entries]
    if name in names:
        return names.index(name)
    if name.isdecimal() and len(name) < 5 and 1 <= int(name) <= len(entries):
        return int(name) - 1
    known = [str(one) for one in names if one is not None]
    way_out = choices(name, known) if known else f"count from 1 to {len(entries)}"
    raise InputError(f"--set {setting}: no entry of this list is '{name}'; {way_out}")


def setting_names(setting: str) -> list[str]:
    """Return the names of a setting's key, the table's first.

    Raises
    ------
    InputError
        It is no setting.
    """
    names, _ = setting_parts(setting)
    if not all(names):
        raise InputError(f"--set {setting}: write it like --set damage.law=AT2")
    return names


def setting_parts(setting: str) -> tuple[list[str], str]:
    """Return the names of a setting's key and the text of its value; an empty name without a key.

    A name with a dot, a space or an equals sign is in quotes, as in TOML.
    """
    text_is_short(setting, f"--set {setting[:40]}...")
    for found in re.finditer("=", setting):
        with suppress(ValueError, RecursionError):
            return _names_in(setting[: found.start()]), setting[found.end() :]
    key, equals, text = setting.partition("=")
    return [name.strip() for name in key.split(".")] if equals else [""], text


def typed_value(text: str) -> Any:
    """Return a value as TOML reads it; a number like `.5` or `5.` too; else the text itself."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except (ValueError, RecursionError):
        plain = text.strip()
        return float(plain) if BARE_POINT.fullmatch(plain) else plain


def _names_in(key: str) -> list[str]:
    """Return the names of a dotted key of TOML; ValueError if it is none."""
    names: list[str] = []
    inner: Any = tomllib.loads(f"{key} = 0")
    while isinstance(inner, dict):
        ((name, inner),) = inner.items()
        names.append(name)
    return names
