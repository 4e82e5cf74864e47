"""Identities of objects of a script: a text, or numbers, by which each is known again."""

from dataclasses import fields, is_dataclass
from hashlib import sha256
from typing import Any

import numpy as np

from staffa.errors import InputError

LONGEST, DEEPEST = 300, 4  # characters of an identity; records within records


def said_identity(load: Any) -> tuple[str, tuple[float, ...]]:
    """Return the text and the numbers by which a load without values says that it is known.

    Raises
    ------
    InputError
        It says nothing, or neither a short text nor finite numbers.
    """
    name = type(load).__name__
    way_out = "give it a method identity() that returns a short text, or numbers, of what it does"
    said = getattr(load, "identity", None)
    if said is None:
        raise InputError(
            f"the load {name} does not tell what it is: its temperatures are not known beforehand, "
            f"and a run that goes on must know it again; {way_out}"
        )
    try:
        said = said() if callable(said) else said
        if isinstance(said, str):
            if said.strip() and said.isprintable() and len(said) <= LONGEST:
                return said, ()
        else:
            numbers = np.atleast_1d(np.asarray(said, dtype=float))
            if numbers.ndim == 1 and numbers.size and np.all(np.isfinite(numbers)):
                return name, tuple(numbers.tolist())
    except Exception as error:  # whatever a user's function raises
        raise InputError(
            f"the load {name}: identity() fails ({type(error).__name__}: {error}); {way_out}"
        ) from error
    raise InputError(
        f"the load {name}: its identity is neither a line of at most {LONGEST} characters nor "
        f"finite numbers; {way_out}"
    )


def object_identity(thing: Any) -> str:
    """Return name and parameters of an object: its text `identity`, or its class with its fields.

    The fields are those of a dataclass, else the attributes whose names do not begin with "_".
    """
    text = _identity(thing, DEEPEST)
    if len(text) <= LONGEST:
        return text
    return f"{text[: LONGEST - 20]}... {sha256(text.encode()).hexdigest()[:16]}"


def _identity(thing: Any, deepest: int) -> str:
    said = getattr(thing, "identity", None)
    if callable(said) and not isinstance(thing, type):
        text, numbers = said_identity(thing)
        return f"{text}({', '.join(map(repr, numbers))})" if numbers else text
    if isinstance(said, str):
        return said
    name = type(thing).__qualname__.rpartition("<locals>.")[2]
    if is_dataclass(thing):
        own = {field.name: getattr(thing, field.name) for field in fields(thing)}
    else:
        known = getattr(thing, "__dict__", {})
        own = {key: known[key] for key in sorted(known) if not key.startswith("_")}
    listed = (f"{key}={_parameter(value, deepest)}" for key, value in own.items())
    return f"{name}({', '.join(listed)})"


def _parameter(value: Any, deepest: int) -> str:
    """Return a parameter as text, the same in any process."""
    if value is None or isinstance(value, bool | int | str | bytes | complex):
        return repr(value)
    if isinstance(value, float):
        return repr(float(value))
    if isinstance(value, np.generic):
        return repr(value.item())
    if isinstance(value, np.ndarray):
        content = sha256(np.ascontiguousarray(value).tobytes()).hexdigest()[:16]
        return f"array({value.shape}, {value.dtype}, {content})"
    if deepest == 0:
        return "..."
    if isinstance(value, list | tuple):
        return f"({', '.join(_parameter(item, deepest - 1) for item in value)})"
    if isinstance(value, dict):
        items = (f"{key!r}: {_parameter(item, deepest - 1)}" for key, item in value.items())
        return f"{{{', '.join(items)}}}"
    if isinstance(value, type) or not hasattr(type(value), "__dict__") or callable(value):
        return str(getattr(value, "__qualname__", type(value).__qualname__))
    return _identity(value, deepest - 1)
