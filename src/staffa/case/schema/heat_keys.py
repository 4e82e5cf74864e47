"""The table [heat]: where a body's heat comes from and goes to, as keys."""

from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import Discriminator, Field, InstanceOf, StringConstraints, Tag

from staffa.case.schema.boxes import Box
from staffa.case.schema.field_types import (
    NOT_NEGATIVE,
    POSITIVE,
    CaseTable,
    FilmCoefficient,
    Formula,
    HeatFlux,
    HeatSource,
    Instant,
    PositiveNumber,
    SidesTable,
    Temperature,
    TemperatureGradient,
    kind,
)
from staffa.case.schema.property_keys import FieldFile
from staffa.case.schema.temperature_keys import OF_T, InTemperature
from staffa.case.schema.tolerances import Agreement
from staffa.physics.elasticity import PointFunction
from staffa.properties.formula import LONGEST, uses
from staffa.units import Quantity


class InTime(CaseTable):
    """Values in time: linear between the given times and constant beyond them."""

    t: tuple[Instant, ...] = Field(
        description="times, increasing; t also in a case that counts in tau",
        examples=[["0 s", "10 min"]],
    )
    value: tuple[float, ...] = Field(description="the value at each of them")


def _values(*examples: str) -> Any:
    return Field(description="the value at each of them", examples=[list(examples)])


class TemperatureInTime(InTime):
    """A temperature in time."""

    value: tuple[Temperature, ...] = _values("20 °C", "5 °C")


class FluxInTime(InTime):
    """A heat flux in time."""

    value: tuple[HeatFlux, ...] = _values("0 W/m^2", "-500 W/m^2")


class FilmInTime(InTime):
    """A film coefficient in time."""

    value: tuple[Annotated[FilmCoefficient, NOT_NEGATIVE], ...] = _values(
        "0 W/(m^2 K)", "500 W/(m^2 K)"
    )


class FilmInTemperature(InTemperature):
    """A film coefficient by the temperature of the surface, as in a boiling curve."""

    value: tuple[Annotated[FilmCoefficient, NOT_NEGATIVE], ...] = _values(
        "200 W/(m^2 K)", "8000 W/(m^2 K)"
    )


class FilmFormula(Formula):
    """A formula of t, x, y (and z), and T, the temperature of the surface (K)."""

    formula: Annotated[str, StringConstraints(max_length=LONGEST)] = Field(
        description="of t, x, y (and z), and of the surface's temperature T (K)",
        examples=["5.67e-8*(T**2 + 293**2)*(T + 293)"],
    )

    @property
    def of_temperature(self) -> bool:
        """Return True if the surface's temperature changes it."""
        return uses(self.formula, OF_T)


class SourceInTime(InTime):
    """A heat source in time."""

    value: tuple[HeatSource, ...] = _values("0 W/m^3", "100 W/m^3")


class Even(CaseTable):
    """A quantity that changes evenly along a direction."""

    value: InstanceOf[Quantity]
    gradient: tuple[InstanceOf[Quantity], ...]

    def at_points(self, dim: int) -> PointFunction:
        """Return its values."""
        origin, gradient = float(self.value), np.array(self.gradient, dtype=float)
        return lambda x: origin + gradient @ x[:dim]


class Geotherm(Even):
    """A temperature that changes evenly along a direction."""

    value: Temperature = Field(description="temperature at the origin", examples=["20 °C"])
    gradient: tuple[TemperatureGradient, ...] = Field(
        description="its change along x, y (2-D) or x, y, z (3-D)",
        examples=[["0 K/m", "-0.03 K/m"]],
    )


class TemperatureFile(FieldFile):
    """A field of temperatures. In a case with units, field_unit says how they count."""

    dimension: ClassVar[str] = "temperature"


def _is_formula(value: Any) -> bool:
    return isinstance(value, Formula) or (isinstance(value, dict) and "formula" in value)


def kind_of_value(value: Any) -> str:
    """Return the alternative of a value in space or time."""
    return "a formula" if _is_formula(value) else kind(value)


def form_or_file(value: Any) -> str:
    """Return the same, where a field in a file may be meant too."""
    is_file = isinstance(value, FieldFile) or (isinstance(value, dict) and "file" in value)
    return "a file" if is_file else kind_of_value(value)


def form_of_film(value: Any) -> str:
    """Tell which alternative of a film coefficient is meant."""
    in_temperature = isinstance(value, InTemperature) or (isinstance(value, dict) and OF_T in value)
    return "a table of temperature" if in_temperature else kind_of_value(value)


# A number, a table, or a formula of it.
type Given[Value, Table] = Annotated[
    Annotated[Value, Tag("a value")]
    | Annotated[Table, Tag("a table")]
    | Annotated[Formula, Tag("a formula")],
    Discriminator(kind_of_value),
]
# The same, or a field in a file.
type OrFile[Value, Table] = Annotated[
    Annotated[Value, Tag("a value")]
    | Annotated[Table, Tag("a table")]
    | Annotated[Formula, Tag("a formula")]
    | Annotated[TemperatureFile, Tag("a file")],
    Discriminator(form_or_file),
]
TemperatureValue = OrFile[Temperature, TemperatureInTime]
FluxValue = Given[HeatFlux, FluxInTime]
FilmValue = Annotated[
    Annotated[Annotated[FilmCoefficient, POSITIVE], Tag("a value")]
    | Annotated[FilmInTime, Tag("a table")]
    | Annotated[FilmInTemperature, Tag("a table of temperature")]
    | Annotated[FilmFormula, Tag("a formula")],
    Discriminator(form_of_film),
]
SourceValue = Given[HeatSource, SourceInTime]
Start = OrFile[Temperature, Geotherm]

FILE_EXAMPLE = {"file": "T0.vtu", "name": "T", "field_unit": "°C"}
START_EXAMPLES = [
    "20 °C",
    {"value": "20 °C", "gradient": ["0 K/m", "-0.03 K/m"]},
    {"formula": "293 - 0.03*y"},
    FILE_EXAMPLE,
]
TEMPERATURE_EXAMPLES = [
    "5 °C",
    {"t": ["0 s", "10 min"], "value": ["20 °C", "5 °C"]},
    FILE_EXAMPLE,
]
FILM_EXAMPLES = [
    "500 W/(m^2 K)",
    {"formula": "500 + 20*x"},
    {"T": ["100 °C", "200 °C"], "value": ["9000 W/(m^2 K)", "300 W/(m^2 K)"]},
]
FLUX_EXAMPLES = ["-500 W/m^2", {"formula": "-500*exp(-t/3600)"}]
SOURCE_EXAMPLES = ["2e-6 W/m^3", {"formula": "100*exp(-t/3600)"}]


class HeatSide(CaseTable):
    """Heat exchange of a side: T alone, flux alone, or h and T."""

    h: FilmValue | None = Field(
        default=None, description="film coefficient", examples=FILM_EXAMPLES
    )
    T: TemperatureValue | None = Field(
        default=None,
        description="temperature of the side, or with h of the bath beyond its film",
        examples=TEMPERATURE_EXAMPLES,
    )
    flux: FluxValue | None = Field(
        default=None,
        description="heat that enters per area and time, negative where it leaves",
        examples=FLUX_EXAMPLES,
    )


class HeatCracks(CaseTable):
    """Heat exchange of cracks: conductivity alone, or h and T."""

    conductivity: Annotated[PositiveNumber, Field(le=1)] | None = Field(
        default=None,
        description="fraction of the conductivity left in a crack",
        examples=[1e-3],
    )
    h: FilmValue | None = Field(
        default=None,
        description="film coefficient of each of a crack's two faces",
        examples=FILM_EXAMPLES,
    )
    T: Given[Temperature, TemperatureInTime] | None = Field(
        default=None,
        description="temperature of the fluid in the cracks",
        examples=TEMPERATURE_EXAMPLES[:2],
    )


class HeatBand(Box):
    """A part of the body that conducts or stores heat differently."""

    k: PositiveNumber = Field(
        default=1.0, description="its conductivity over material.k", examples=[2.0]
    )
    capacity: PositiveNumber = Field(
        default=1.0,
        description="its heat capacity per volume over material.rho times material.c",
        examples=[0.5],
    )


def _side(words: str) -> Any:
    return Field(
        default=None,
        description=words,
        examples=[{"T": "5 °C"}, {"flux": "-500 W/m^2"}, {"h": "500 W/(m^2 K)", "T": "5 °C"}],
    )


class HeatKeys(SidesTable):
    """The heat equation, for temperature.profile = "heat". A side has { T = "5 °C" },
    takes up heat like { flux = "60 mW/m^2" }, or gives it to a bath through a film like
    { h = "500 W/(m^2 K)", T = "5 °C" }; it is insulated where it is not named. The faces of a mesh
    or a shape go by their names. Each of these
    values may be a table in time { t = [...], value = [...] } or a { formula = "..." } of t, x, y
    (and z in 3-D) in SI units, or scaled as the case is; a temperature also a field in a file,
    { file = "T0.vtu", name = "T", field_unit = "°C" }, which does not change in time."""

    __pydantic_extra__: dict[str, HeatSide]

    initial: Start = Field(
        description="temperature at t = 0: a value, one with a gradient, a formula of x, y "
        "(and z), or a field in a file",
        examples=START_EXAMPLES,
    )
    stress_free: Start | None = Field(
        default=None,
        description="temperature without thermal strain, likewise; the initial one if left out",
        examples=START_EXAMPLES,
    )
    left: HeatSide | None = _side("side x = 0")
    right: HeatSide | None = _side("side x = width")
    bottom: HeatSide | None = _side("lower side")
    top: HeatSide | None = _side("upper side")
    front: HeatSide | None = _side("side y = 0, 3-D only")
    back: HeatSide | None = _side("side y = depth, 3-D only")
    source: SourceValue | None = Field(
        default=None,
        description="heat made in the body per volume and time",
        examples=SOURCE_EXAMPLES,
    )
    bands: tuple[HeatBand, ...] = Field(
        default=(),
        description="boxes with other factors on the conductivity and the heat capacity per volume",
        examples=[[{"lower": [0.0, 0.0], "upper": [5.0, 0.02], "k": 2.0, "capacity": 0.5}]],
    )
    cracks: HeatCracks | None = Field(
        default=None,
        description="what cracks do to heat: the fraction of the conductivity left across them, or "
        "a fluid in them, h and T; nothing if left out",
        examples=[{"conductivity": 1e-3}, {"h": "500 W/(m^2 K)", "T": "5 °C"}],
    )
    tolerance: Annotated[PositiveNumber, Field(ge=1e-9, lt=0.1)] = Field(
        default=1e-4,
        description="largest error of a time step of heat over the largest change of temperature",
    )
    agreement: Agreement = Field(
        default=1e-3,
        description="how well temperature and cracks must agree at a step's end, in that measure",
    )
