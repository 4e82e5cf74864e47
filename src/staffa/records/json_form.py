"""Frozen results from names and values as JSON holds them."""

from collections.abc import Mapping
from functools import cache
from typing import Any

from pydantic import TypeAdapter, ValidationError


@cache
def _reader(kind: Any) -> TypeAdapter[Any]:
    return TypeAdapter(kind)


def made[R](kind: type[R], record: Mapping[str, Any]) -> R:
    """A record of this kind, from names and values as JSON holds them.

    What the record lacks is as the kind has it by default; what a later version added is left.

    Raises
    ------
    ValueError
        An entry is missing, or of another type.
    """
    try:
        found: R = _reader(kind).validate_python(record)  # type: ignore[arg-type]
        return found
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        raise ValueError(f"{'.'.join(map(str, first['loc']))}: {first['msg']}") from None
