"""The kinds of values that a case file holds: quantities, numbers, flags, and tables."""

from collections.abc import Callable, Iterable
from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    InstanceOf,
    Strict,
    StringConstraints,
)
from pydantic_core import CoreSchema
from pydantic_core.core_schema import no_info_before_validator_function

from staffa.case.schema.json_schema import Rule, Schema
from staffa.errors import InputError, did_you_mean
from staffa.physics.elasticity import PointFunction
from staffa.properties.formula import LONGEST, formula, formula_variables
from staffa.records.authorship import is_author, is_license
from staffa.units import EXAMPLES, SI_UNITS, Quantity, parse, sensible

LONGEST_NAME = 60
LONGEST_LINE = 200
LONGEST_PATH = 1000
# A number and a unit, as the pattern of a JSON schema; `units.parse` says what else it must be.
WITH_UNIT = r"^\s*[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?\s*[^\s\d.]"


def _or_value_error(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Return the function with its errors as Pydantic collects them."""

    def told(value: Any) -> Any:
        try:
            return function(value)
        except InputError as error:
            raise ValueError(str(error)) from None

    return told


class _Read:
    """Reads a quantity as a user writes it; its JSON schema says how that is."""

    def __init__(self, read: Callable[[Any], Any], *dimensions: str) -> None:
        self._read, self._dimensions = _or_value_error(read), dimensions

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Read before it is held to be a quantity."""
        return no_info_before_validator_function(self._read, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Return a number, or a text with a unit; editors ignore keywords that begin with x-."""
        return {
            "type": ["number", "string"],
            "pattern": WITH_UNIT,
            "examples": [EXAMPLES[name] for name in self._dimensions],
            "x-dimensions": {name: SI_UNITS[name] for name in self._dimensions},
        }


def _reads(dimension: str) -> _Read:
    return _Read(lambda value: parse(value, dimension), dimension)


def _volume(value: Any) -> Any:
    """Return a volume of a 3-D body or, if it is written so, one per thickness of a 2-D body."""
    try:
        return parse(value, "volume")
    except InputError:
        try:
            return parse(value, "volume per thickness")
        except InputError:
            return parse(value, "volume")


def _positive(value: Any) -> Any:
    if not value > 0:
        raise ValueError("it must be larger than zero")
    return value


def _not_negative(value: Any) -> Any:
    if not value >= 0:
        raise ValueError("it must not be negative")
    return value


def _in_degrees(value: Any) -> Any:
    """Return an angle as a plain number: it may have a unit, whatever the case's other numbers
    have."""
    return float(parse(value, "rotation")) if isinstance(value, str) else value


def is_name(text: str) -> str:
    """Return the text, if it can stand for a part of a case in sentences, tables and pictures."""
    if not (text.strip() and len(text) <= LONGEST_NAME and text.isprintable()):
        raise ValueError(f"a name has 1 to {LONGEST_NAME} characters that can be printed")
    return text


def is_path(text: str) -> str:
    """Return the text, if it can be the path of a file."""
    if len(text) > LONGEST_PATH or not text.isprintable():
        raise ValueError(f"a path has at most {LONGEST_PATH} characters, which can be printed")
    return text


def is_line(text: str) -> str:
    """Return the text, if it can stand on a line of tables and pictures, or on a terminal."""
    if len(text) > LONGEST_LINE or not text.isprintable():
        raise ValueError(f"it must be one line of at most {LONGEST_LINE} characters to be printed")
    return text


def _is_author(text: str) -> str:
    if not is_author(text):
        raise ValueError(
            'it must be a name, alone or with an ORCID or a mail address, like "Ada Lovelace '
            '<https://orcid.org/0000-0002-1825-0097>"'
        )
    return text


def _is_license(text: str) -> str:
    if not is_license(text):
        raise ValueError('it must be an identifier of spdx.org, like "CC-BY-4.0", or an address')
    return text


POSITIVE = Rule(_positive, exclusiveMinimum=0)
NOT_NEGATIVE = Rule(_not_negative, minimum=0)
Position = Annotated[InstanceOf[Quantity], _reads("length")]
Length = Annotated[Position, POSITIVE]
Stress = Annotated[InstanceOf[Quantity], _reads("stress")]
Modulus = Annotated[InstanceOf[Quantity], _reads("stress"), POSITIVE]
Strength = Annotated[InstanceOf[Quantity], _reads("stress"), POSITIVE]
Toughness = Annotated[InstanceOf[Quantity], _reads("toughness"), POSITIVE]
Expansion = Annotated[InstanceOf[Quantity], _reads("thermal expansion"), POSITIVE]
Diffusivity = Annotated[InstanceOf[Quantity], _reads("diffusivity"), POSITIVE]
Conductivity = Annotated[InstanceOf[Quantity], _reads("conductivity"), POSITIVE]
Density = Annotated[InstanceOf[Quantity], _reads("density"), POSITIVE]
HeatCapacity = Annotated[InstanceOf[Quantity], _reads("heat capacity"), POSITIVE]
Temperature = Annotated[InstanceOf[Quantity], _reads("temperature")]
TemperatureGradient = Annotated[InstanceOf[Quantity], _reads("temperature gradient")]
HeatFlux = Annotated[InstanceOf[Quantity], _reads("heat flux")]
HeatSource = Annotated[InstanceOf[Quantity], _reads("heat source")]
FilmCoefficient = Annotated[InstanceOf[Quantity], _reads("film coefficient")]
Drop = Annotated[InstanceOf[Quantity], _reads("temperature difference"), POSITIVE]
Acceleration = Annotated[InstanceOf[Quantity], _reads("acceleration")]
StressGradient = Annotated[InstanceOf[Quantity], _reads("stress gradient")]
Pressure = Annotated[InstanceOf[Quantity], _reads("pressure"), POSITIVE]
PressureGradient = Annotated[InstanceOf[Quantity], _reads("pressure gradient")]
Permeability = Annotated[InstanceOf[Quantity], _reads("permeability"), POSITIVE]
Viscosity = Annotated[InstanceOf[Quantity], _reads("viscosity"), POSITIVE]
MassRate = Annotated[InstanceOf[Quantity], _reads("mass rate")]
CrackVolume = Annotated[
    InstanceOf[Quantity], _Read(_volume, "volume", "volume per thickness"), NOT_NEGATIVE
]
Instant = Annotated[InstanceOf[Quantity], _reads("time"), NOT_NEGATIVE]
Number = Annotated[float, Strict(), AfterValidator(_or_value_error(sensible))]
PositiveNumber = Annotated[Number, POSITIVE]
Direction = tuple[Number, ...]
Angle = Annotated[Number, _Read(_in_degrees, "rotation")]
Name = Annotated[str, Rule(is_name, minLength=1, maxLength=LONGEST_NAME)]
FilePath = Annotated[str, Rule(is_path, maxLength=LONGEST_PATH)]
Line = Annotated[str, Rule(is_line, maxLength=LONGEST_LINE)]
Author = Annotated[Line, Rule(_is_author)]
License = Annotated[Line, Rule(_is_license)]
Integer = Annotated[int, Strict()]
Flag = Annotated[bool, Strict()]
ONE = Quantity(1.0)


def one_of(known: Iterable[str]) -> Rule:
    """Return the rule for one of the names of a registry, so that additions count at once."""
    names = tuple(known)

    def is_known(value: str) -> str:
        if value not in names:
            listed = ", ".join(f'"{name}"' for name in names)
            raise ValueError(f"it must be one of {listed}.{did_you_mean(value, names)}")
        return value

    return Rule(is_known, enum=list(names))


def kind(value: Any) -> str:
    """Return the alternative of a key by how it is written, so that only one can complain.

    The names of alternatives hold a space, which no key does.
    """
    if isinstance(value, dict | BaseModel):
        return "a table"
    return "a list" if isinstance(value, list | tuple) else "a value"


class CaseTable(BaseModel):
    """A table of the case file: no unknown key, nothing changed later."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @classmethod
    def model_json_schema(cls, *args: Any, **options: Any) -> dict[str, Any]:
        """Return the keys, for editors and for programs that write cases."""
        if len(args) < 3:  # the third is the generator
            options.setdefault("schema_generator", Schema)
        return super().model_json_schema(*args, **options)


class Formula(CaseTable):
    """A formula in SI units, or scaled as the case is."""

    formula: Annotated[str, StringConstraints(max_length=LONGEST)] = Field(
        description="of x, y and z, and in [heat] of t", examples=["293 - 5*sin(2*pi*t/3600)"]
    )

    def at_points(self, dim: int) -> PointFunction:
        """Return the values of keys that do not depend on time."""
        evaluated = formula(self.formula, formula_variables(dim, time=False))
        return lambda x: evaluated(x, 0.0)


class SidesTable(CaseTable):
    """A table that also takes the names of a body's faces as keys."""

    model_config = ConfigDict(extra="allow")

    def on(self, face: str) -> Any:
        """Return the keys of a face, None if it has none."""
        return getattr(self, face, None)
