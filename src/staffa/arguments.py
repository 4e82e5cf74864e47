"""Checks that what a script hands to the public functions is of the right kind."""

import re
from collections.abc import Iterable
from os import PathLike
from pathlib import Path
from typing import Any

from staffa.errors import InputError

LONGEST = 60  # characters of a value that is shown


def require(value: Any, kind: type | tuple[type, ...], name: str, way_out: str) -> None:
    """Refuse an argument of another type.

    Parameters
    ----------
    value : the argument.
    kind : the type, or types, that it may have.
    name : its name, for the message.
    way_out : advice that ends the message.

    Raises
    ------
    InputError
        With the argument's name, what it is, and the way out.
    """
    if not isinstance(value, kind):
        raise InputError(f"{name} = {py_text(value)} is {told(value)}; {way_out}")


def path_of(value: Any, name: str) -> Path:
    """Return a path that is given as one, or as a text."""
    require(value, (str, PathLike), name, "give a path, as a text or a pathlib.Path")
    return Path(value)


def settings_of(value: Any) -> tuple[str, ...]:
    """Return the settings of a case, each a text like "domain.h=0.1"."""
    way_out = 'give a list of texts, like ["domain.h=0.1"]'
    if isinstance(value, str):
        raise InputError(f"settings = {py_text(value)} is one text; {way_out}")
    require(value, Iterable, "settings", way_out)
    settings = tuple(value)
    for setting in settings:
        require(setting, str, "a setting", way_out)
    return settings


def py_text(value: Any) -> str:
    """Return a value as Python writes it, cut short."""
    text = re.sub(" at 0x[0-9a-f]+", "", repr(value))
    return text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."


def told(value: Any) -> str:
    """Return the kind of a value, in words."""
    if isinstance(value, type):
        return "a class"
    name = type(value).__name__
    return f"{'an' if name[0].lower() in 'aeiou' else 'a'} {name}"
