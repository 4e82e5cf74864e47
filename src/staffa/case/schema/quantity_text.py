"""Numbers as the sentences of `check` write them: in units that are easily read, safely rounded."""

from collections.abc import Iterator
from math import ceil, floor, log10
from typing import Any

from pydantic import BaseModel

from staffa.case.schema.case import Case
from staffa.units import Quantity

# The units that a quantity is written in, smallest first, over its SI unit.
READABLE = {
    "m": ((1e-6, "um"), (1e-3, "mm"), (1.0, "m"), (1e3, "km")),
    "Pa": ((1.0, "Pa"), (1e3, "kPa"), (1e6, "MPa"), (1e9, "GPa")),
    "s": ((1.0, "s"), (60.0, "min"), (3600.0, "h"), (86400.0, "d"), (3.15576e7, "y")),
}
NOISE = 1e-9  # relative: "0.03/3" must not become 0.00999


def quantities(table: BaseModel, path: str = "") -> Iterator[tuple[str, Quantity]]:
    """Yield every quantity of a case that was written down, with its key."""
    for name in (*type(table).model_fields, *(table.model_extra or {})):
        if name in table.model_fields_set:
            yield from _quantities(getattr(table, name), f"{path}.{name}".lstrip("."))


def _quantities(value: Any, path: str) -> Iterator[tuple[str, Quantity]]:
    if isinstance(value, Quantity):
        yield path, value
    elif isinstance(value, BaseModel):
        yield from quantities(value, path)
    elif isinstance(value, tuple):
        for item in value:
            yield from _quantities(item, path)
    elif isinstance(value, dict):
        for name, item in value.items():
            yield from _quantities(item, f"{path}.{name}")


def is_scaled(case: Case) -> bool:
    """Return True if no number of the case has a unit."""
    return not any(quantity.has_units for _, quantity in quantities(case))


def unit(case: Case, name: str) -> str:
    """Return the unit behind a number of a case in a sentence; empty if the case is scaled."""
    return "" if is_scaled(case) else f" {name}"


def amount(case: Case, value: float, unit: str, *, digits: int = 3) -> str:
    """Return a number of the case (SI, or scaled) with its unit, rounded to the nearest.

    Parameters
    ----------
    case : the case, which counts in SI units or is scaled.
    value : in `unit`, or scaled.
    unit : "m", "Pa", "s", or any other, which is then written as it is.
    digits : number of significant digits.
    """
    factor, name = _unit(case, value, unit)
    return f"{value / factor:.{digits}g}{name}"


def key(case: Case, value: float, unit: str, *, digits: int = 3) -> str:
    """Return a quantity as a case file has it: in quotes if it has a unit.

    Parameters
    ----------
    case : the case, which counts in SI units or is scaled.
    value : in `unit`, or scaled.
    unit : "m", "Pa", "s", or any other, which is then written as it is.
    digits : number of significant digits.
    """
    return quoted(amount(case, value, unit, digits=digits))


def quoted(text: str) -> str:
    """Return a text as a case file has it: in quotes if it has a unit."""
    return f'"{text}"' if " " in text else text


def at_most(case: Case, value: float, unit: str, *, digits: int = 3) -> str:
    """Return a quantity rounded toward zero: a bound that may not be exceeded.

    Parameters
    ----------
    case : the case, which counts in SI units or is scaled.
    value : in `unit`, or scaled.
    unit : "m", "Pa", "s", or any other, which is then written as it is.
    digits : number of significant digits.
    """
    factor, name = _unit(case, value, unit)
    return f"{_rounded(value / factor, digits, up=False):.{digits}g}{name}"


def at_least(case: Case, value: float, unit: str, *, digits: int = 3) -> str:
    """Return a quantity rounded away from zero: a bound that must be reached.

    Parameters
    ----------
    case : the case, which counts in SI units or is scaled.
    value : in `unit`, or scaled.
    unit : "m", "Pa", "s", or any other, which is then written as it is.
    digits : number of significant digits.
    """
    factor, name = _unit(case, value, unit)
    return f"{_rounded(value / factor, digits, up=True):.{digits}g}{name}"


def as_duration(seconds: float) -> str:
    """Return a time that a run takes, to one digit or two."""
    factor, name = next(
        (known for known in reversed(READABLE["s"]) if seconds >= known[0]), READABLE["s"][0]
    )
    return f"{max(1, round(seconds / factor))} {name}"


def _unit(case: Case, value: float, unit: str) -> tuple[float, str]:
    if is_scaled(case):
        return 1.0, ""
    fitting = [known for known in READABLE.get(unit, ()) if abs(value) >= known[0] * (1 - 5e-4)]
    factor, name = fitting[-1] if fitting else READABLE.get(unit, ((1.0, unit),))[0]
    return factor, f" {name}" if name else ""


def _rounded(value: float, digits: int, *, up: bool) -> float:
    if value == 0:
        return 0.0
    grain = 10.0 ** (floor(log10(abs(value))) - digits + 1)
    parts = abs(value) / grain
    whole = ceil(parts * (1 - NOISE)) if up else floor(parts * (1 + NOISE))
    return whole * grain if value > 0 else -whole * grain
