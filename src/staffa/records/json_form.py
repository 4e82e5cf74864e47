"""Records as JSON holds them, and records read from JSON: both through pydantic."""

from collections.abc import Mapping
from functools import cache
from typing import Any

from pydantic import TypeAdapter, ValidationError


@cache
def _adapter(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


def json_form(record: Any) -> dict[str, Any]:
    """Return the fields of a record by name, as values that JSON holds.

    Records within it become dictionaries, and tuples lists. NaN and infinity stay numbers, which
    `json.dumps` writes as NaN and Infinity.

    Parameters
    ----------
    record : a frozen dataclass; each field holds what its annotation says.
    """
    kind: Any = type(record)
    found: dict[str, Any] = _adapter(kind).dump_python(record, mode="json")
    return found


def made[R](kind: type[R], record: Mapping[str, Any]) -> R:
    """Return the record of a kind that `json_form` gave, of this version or of another one.

    A field that is missing gets its default. A name that the kind does not know is left out.

    Parameters
    ----------
    kind : the dataclass.
    record : names and values as JSON holds them.

    Raises
    ------
    ValueError
        A field without a default is missing, or a value is of another type.
    """
    try:
        found: R = _adapter(kind).validate_python(record)  # type: ignore[arg-type]
        return found
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        raise ValueError(f"{'.'.join(map(str, first['loc']))}: {first['msg']}") from None
