"""Numbers with units: what a user writes, "70 GPa", and the SI number that is computed with."""

import re
from functools import cache
from math import inf
from typing import Any

import pint
from pydantic_core import CoreSchema
from pydantic_core.core_schema import is_instance_schema, plain_serializer_function_ser_schema

from staffa.display_units import Unit
from staffa.errors import InputError

# One unit a dimension, the SI one; the names are those of the messages.
SI_UNITS = {
    "length": "m",
    "stress": "Pa",
    "toughness": "J/m**2",
    "temperature difference": "K",
    "thermal expansion": "1/K",
    "time": "s",
    "diffusivity": "m**2/s",
    "temperature": "K",
    "temperature gradient": "K/m",
    "conductivity": "W/(m*K)",
    "density": "kg/m**3",
    "heat capacity": "J/(kg*K)",
    "heat flux": "W/m**2",
    "film coefficient": "W/(m**2*K)",
    "heat source": "W/m**3",
    "rotation": "deg",  # as case files count them
    "acceleration": "m/s**2",
    "stress gradient": "Pa/m",
    "volume": "m**3",
    "volume per thickness": "m**2",
    "pressure": "Pa",
    "pressure gradient": "Pa/m",
    "permeability": "m**2",
    "viscosity": "Pa*s",
    "mass rate": "kg/s",
}
EXAMPLES = {
    "length": "5 mm",
    "stress": "70 GPa",
    "toughness": "10 J/m^2",
    "temperature difference": "120 K",
    "thermal expansion": "9e-6 1/K",
    "time": "2 min",
    "diffusivity": "0.5 mm^2/s",
    "temperature": "20 °C",
    "temperature gradient": "0.03 K/m",
    "conductivity": "2.5 W/(m K)",
    "density": "2700 kg/m^3",
    "heat capacity": "800 J/(kg K)",
    "heat flux": "0.06 W/m^2",
    "film coefficient": "500 W/(m^2 K)",
    "heat source": "2e-6 W/m^3",
    "rotation": "30 deg",
    "acceleration": "9.81 m/s^2",
    "stress gradient": "0.02 MPa/m",
    "volume": "0.2 m^3",
    "volume per thickness": "0.2 m^2",
    "pressure": "20 MPa",
    "pressure gradient": "0.01 MPa/m",
    "permeability": "1e-15 m^2",
    "viscosity": "0.3 mPa s",
    "mass rate": "5 kg/s",
}

# A number, then a product of units: stricter than pint, which would read "10^-6/K" as ten to the
# power of something and "1,5 mm" as 15.
NUMBER = r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"
FACTOR = r"\(*(?:°?[^\W\d]+|%)(?:(?:\^|\*\*)[+-]?\d)?\)*"
WRITTEN = re.compile(rf"{NUMBER}(.*)", re.DOTALL)
UNIT = re.compile(rf"(?:1?\s*/)?\s*{FACTOR}(?:\s*[*/·\s]\s*{FACTOR})*")
COMPOUND = re.compile(r"[/*·\s]")
# Beyond these a product of a few quantities leaves the range of a float.
SMALLEST, LARGEST = 1e-30, 1e30
LONGEST = 80  # characters of a number with its unit


class Quantity(float):
    """A number that remembers how it was written; its value is in SI, or the bare scaled one.

    `given` is what stands in the case file; `has_units` is True if that was a text with a unit.
    """

    given: str | float
    has_units: bool

    def __new__(cls, value: float, given: str | float | None = None) -> "Quantity":
        self = super().__new__(cls, value)
        self.given = float(value) if given is None else given
        self.has_units = isinstance(given, str)
        return self

    @classmethod
    def __get_pydantic_core_schema__(cls, source: Any, handler: Any) -> CoreSchema:
        """Return an object of this class; in JSON, as it was given."""
        as_given = plain_serializer_function_ser_schema(lambda self: self.given, when_used="json")
        return is_instance_schema(cls, serialization=as_given)

    # A float is made of one argument, and this one of two.
    def __getnewargs__(self) -> tuple[float, str | float]:  # type: ignore[override]
        return float(self), self.given


class Temperature(Quantity):
    """A temperature itself, not a difference: its zero means something else in each unit."""


@cache
def _registry() -> pint.UnitRegistry:
    return pint.UnitRegistry()


def parse(value: Any, dimension: str) -> Quantity:
    """Read a bare number or a text such as "5 mm" as a quantity of the given dimension.

    Raises
    ------
    InputError
        The text is no number with a unit, its unit measures something else, or the number is not
        finite or absurdly large or small.
    """
    if isinstance(value, Quantity):
        return value
    quantity = Temperature if dimension == "temperature" else Quantity
    if isinstance(value, str):
        return quantity(sensible(_to_si(value, dimension)), value)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f'{_a(dimension)} is a number, or a text like "{EXAMPLES[dimension]}"')
    number = sensible(value)
    return quantity(number, number)


def _a(dimension: str) -> str:
    return f"{'an' if dimension[0] in 'aeiou' else 'a'} {dimension}"


def sensible(value: float) -> float:
    """Return a number that can be computed with: zero, or between 1e-30 and 1e30.

    Raises
    ------
    InputError
        It is something else.
    """
    if value != value or value in (inf, -inf):
        raise InputError("it must be a finite number")
    if value and not SMALLEST <= abs(value) <= LARGEST:
        raise InputError(f"it must lie between {SMALLEST:g} and {LARGEST:g}; check its unit")
    return float(value)


def _to_si(text: str, dimension: str) -> float:
    example = f'write it like "{EXAMPLES[dimension]}"'
    if len(text) > LONGEST:
        raise InputError(f"that is too long for {_a(dimension)}; {example}")
    written = WRITTEN.fullmatch(text)
    if written is None:
        raise InputError(f"that is no {dimension}, which begins with a number; {example}")
    number, unit = written[1], written[2].strip()
    if not unit:
        raise InputError(
            f"{_a(dimension)} in quotes needs a unit; {example}, or leave out the quotes if the "
            f"case is scaled"
        )
    if dimension != "temperature" and COMPOUND.search(unit):  # a degree in them is a difference
        unit = re.sub("°C|degC", "K", unit)
    one = _unit(unit, example)
    if not one.is_compatible_with(SI_UNITS[dimension]):
        raise InputError(f"'{unit}' does not measure {_a(dimension)}; {example}")
    if dimension == "temperature":
        kelvin = _kelvin(float(number), one.units, f"'{unit}' measures a difference; {example}")
        if kelvin < 0:
            raise InputError("it lies below absolute zero; check its unit")
        return kelvin
    if _registry().Quantity(0.0, one.units).to(SI_UNITS[dimension]).magnitude != 0:
        raise InputError(f"'{unit}' has its own zero, and {_a(dimension)} has none; {example}")
    return float(number) * float(one.to(SI_UNITS[dimension]).magnitude)


def _kelvin(number: float, unit: pint.Unit, refusal: str) -> float:
    """Return a temperature in K, from a unit that may have an offset."""
    if "delta_" in str(unit):
        raise InputError(refusal)
    return float(_registry().Quantity(number, unit).to("K").magnitude)


def _unit(unit: str, example: str) -> pint.Quantity:
    try:
        if len(unit) > 40 or not UNIT.fullmatch(unit):
            raise ValueError
        one = _registry().Quantity(f"1 {unit}")
    except Exception:  # pint raises many kinds for a text that is no unit
        raise InputError(f"'{unit}' is no unit that staffa knows; {example}") from None
    return one


def unit_of(quantity: Quantity, dimension: str) -> Unit | None:
    """Return the unit of a quantity as it is written; None without one of this dimension."""
    written = WRITTEN.fullmatch(quantity.given) if isinstance(quantity.given, str) else None
    if written is None:
        return None
    unit = _registry().Quantity(f"1 {written[2].strip()}").units
    if not unit.is_compatible_with(SI_UNITS[dimension]):
        return None
    name = _shown(unit)
    zero, one = (
        float(_registry().Quantity(count, unit).to(SI_UNITS[dimension]).magnitude)
        for count in (0.0, 1.0)
    )
    return Unit(name=name, size=one - zero, zero=zero)


def unit_name(text: str) -> str:
    """Return the name of a unit as results show it: "J/m²" of "J/m^2".

    Raises
    ------
    InputError
        It is no unit.
    """
    return _shown(_unit(text, "write it like mm or J/m^2").units)


def _shown(unit: pint.Unit) -> str:
    return f"{unit:~P}".replace("\u03bc", "\u00b5")  # the micro sign, as everywhere here
