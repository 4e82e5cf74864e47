"""Limits on the size of a case file: a page of text, so that a refusal takes no time."""

import re
from collections.abc import Mapping
from typing import Any

from staffa.errors import InputError

LARGEST_FILE = 1_000_000  # bytes
MOST_VALUES = 25_000  # a table of 12,000 times and values is one of measurements
MOST_BITS = 13_000  # Python does not write whole numbers of more than 4,300 digits
DEEPEST = 12  # the deepest key there is, of a table in time, has 6
# Of the squares of the dots in each line but decimal points: Python's reader takes time and memory
# like the square of the number of names in a.b.c = 1.
MOST_DOTS = 1_000_000
DECIMAL = re.compile(r"\d\.\d")


def text_is_short(text: str, name: str) -> None:
    """Refuse a text that Python's reader would take long over.

    Raises
    ------
    InputError
        It is too large, or one of its keys has too many names.
    """
    if len(text) > LARGEST_FILE:
        raise too_large(name)
    dots = (DECIMAL.sub("", line).count(".") for line in text.splitlines() if "." in line)
    if sum(n * n for n in dots) > MOST_DOTS:
        raise InputError(f"{name} has a key of too many names; shorten it")


def too_large(name: str) -> InputError:
    """Return the error for a file of more than `LARGEST_FILE` bytes."""
    return InputError(
        f"{name} is no case file: it is larger than {LARGEST_FILE:,} bytes; a case is a page"
    )


def values_are_few(table: Mapping[str, Any], name: str) -> None:
    """Refuse a case of too many values, or with too many brackets within one another.

    Raises
    ------
    InputError
        It is so.
    """
    count = 0
    level: list[Any] = [table]
    for _ in range(DEEPEST):
        inside = [held for values in level for held in _held(values)]
        count += len(inside)
        level = [value for value in inside if isinstance(value, dict | list)]
        if any(isinstance(value, int) and value.bit_length() > MOST_BITS for value in inside):
            raise InputError(
                f"{name} holds a whole number of more than 3,900 digits; write it like 1e20"
            )
        if count > MOST_VALUES:
            raise InputError(
                f"{name} holds more than {MOST_VALUES:,} values; write equal steps as "
                f"{{ start, stop, steps }}, and a field as a separate file"
            )
    if level:
        raise InputError(f"{name} is no case file: its brackets are nested too deeply")


def _held(values: Any) -> list[Any]:
    return list(values.values()) if isinstance(values, dict) else values
