"""The table [reservoir]: rock, water and wells of a reservoir, and who computes their flow."""

from typing import Annotated, Literal

from pydantic import (
    Discriminator,
    Field,
    PrivateAttr,
    Tag,
    ValidationInfo,
    field_validator,
    model_validator,
)

from staffa.case.schema.boxes import Box
from staffa.case.schema.field_types import (
    CaseTable,
    Conductivity,
    Density,
    FilePath,
    Flag,
    HeatCapacity,
    Length,
    MassRate,
    Name,
    Number,
    Permeability,
    Position,
    PositiveNumber,
    Pressure,
    PressureGradient,
    Temperature,
    Viscosity,
    kind,
)
from staffa.case.schema.file_access import FileAccess
from staffa.case.schema.fracture_keys import FractureKeys, OpeningKeys
from staffa.case.schema.heat_keys import Even, Geotherm, Given
from staffa.case.schema.property_keys import (
    PLACE,
    FieldFile,
    PermeabilityFile,
    PropertyValue,
    RandomNumber,
    RandomPermeability,
)
from staffa.case.schema.series_keys import FieldsKeys
from staffa.case.schema.tolerances import Agreement
from staffa.errors import InputError
from staffa.units import Quantity

IAPWS: Literal["iapws"] = "iapws"


class PressureWithDepth(Even):
    """A pressure that changes evenly along a direction."""

    value: Pressure = Field(description="pressure at the origin", examples=["20 MPa"])
    gradient: tuple[PressureGradient, ...] = Field(
        description="its change along x, y (2-D) or x, y, z (3-D)",
        examples=[["0 MPa/m", "-0.01 MPa/m"]],
    )


TemperatureInSpace = Given[Temperature, Geotherm]
PressureInSpace = Given[Pressure, PressureWithDepth]
PermeabilityValue = PropertyValue[Permeability, RandomPermeability, PermeabilityFile]
PorosityValue = PropertyValue[PositiveNumber, RandomNumber, FieldFile]

PERMEABILITY_EXAMPLES = [
    "1e-15 m^2",
    {"formula": "1e-15*exp(-y/50)"},
    {"mean": "1e-15 m^2", "variation": 0.5, "length": "10 m"},
]


class WaterKeys(CaseTable):
    """Water of constant properties."""

    rho: Density = Field(description="density", examples=["1000 kg/m^3"])
    c: HeatCapacity = Field(description="specific heat capacity", examples=["4200 J/(kg K)"])
    mu: Viscosity = Field(description="viscosity", examples=["0.3 mPa s"])
    k: Conductivity = Field(
        default=Quantity(0.6, "0.6 W/(m K)"),
        description="conductivity",
        examples=["0.6 W/(m K)"],
    )


class ReservoirBox(Box):
    """A part of the reservoir whose permeability or porosity differs."""

    permeability: Permeability | None = Field(
        default=None, description="its permeability", examples=["1e-13 m^2"]
    )
    porosity: Annotated[PositiveNumber, Field(lt=1)] | None = Field(
        default=None, description="its porosity", examples=[0.2]
    )


class WellKeys(CaseTable):
    """A well at a point: an injector, which has a temperature, or a producer."""

    name: Name = Field(description="its name in tables and pictures", examples=["injector"])
    at: tuple[Position, ...] = Field(
        description="place at which it is open", examples=[["0 m", "0 m"]]
    )
    rate: MassRate | None = Field(
        default=None,
        description="mass rate into the rock, negative of a producer; give this or pressure",
        examples=["5 kg/s", "-5 kg/s"],
    )
    pressure: Pressure | None = Field(
        default=None, description="pressure in it", examples=["20 MPa"]
    )
    T: Temperature | None = Field(
        default=None, description="temperature of the water that it injects", examples=["60 °C"]
    )
    radius: Length = Field(
        default=Quantity(0.1, "0.1 m"), description="radius of the borehole", examples=["0.1 m"]
    )

    @property
    def injects(self) -> bool:
        """Return True for an injector."""
        return self.rate > 0 if self.rate is not None else self.T is not None


FIELDS_EXAMPLE = {"t": ["0 s", "30 d"], "files": ["a.vtu", "b.vtu"], "T": "temperature", "p": "p"}
WELLS_EXAMPLE = [
    {"name": "injector", "at": ["0 m", "0 m"], "rate": "5 kg/s", "T": "60 °C"},
    {"name": "producer", "at": ["60 m", "0 m"], "pressure": "20 MPa"},
]


class ReservoirKeys(CaseTable):
    """Water that circulates between wells, for temperature.profile = "reservoir": a reservoir
    simulator computes temperature and pressure in cells of its grid, which the rock then
    follows (docs/how-to/circulation.md). All numbers have units."""

    simulator: Literal["darts", "single", "fields"] = Field(
        default="darts",
        description="darts: open-DARTS, another program (`make reservoir`); single: one "
        "fracture along a side of impermeable rock, in closed form; fields: temperature "
        "and pressure from files of any other simulator",
    )
    feedback: Flag = Field(
        default=False,
        description="darts only: whether water flows in the cracks too, and in fractures along "
        "sides that open; otherwise cracks do not change the flow",
    )
    openings: OpeningKeys = Field(
        default_factory=OpeningKeys,
        description="with feedback: bounds of the openings that water flows in, and the radius "
        "over which cracks are spread in the cells",
        examples=[{"smallest": "20 um", "largest": "2 mm", "spread": "2 m"}],
    )
    coupling: Literal["iterated", "explicit"] = Field(
        default="iterated",
        description="with feedback: iterated: the flow of a step has the cracks that it ends "
        "with; explicit: those that it began with",
    )
    agreement: Agreement | None = Field(
        default=None,
        description="with feedback, iterated: largest difference between two temperatures in turn, "
        "and pressures, at the end of a step, over their largest change; default tolerance",
        examples=[1e-3],
    )
    shadow: Flag = Field(
        default=True,
        description="with feedback: whether the flow is computed once more with the permeability "
        "before the first step, so that production is told with and without cracks",
    )
    python: FilePath | None = Field(
        default=None,
        description="Python that has open-DARTS, a program that runs with your rights: taken with "
        "--outside alone; default: that of STAFFA_DARTS, or of .reservoir",
        examples=["/opt/darts/bin/python"],
    )
    temperature: TemperatureInSpace | None = Field(
        default=None,
        description="temperature before the first step: a value, one with a gradient, or a "
        "formula of x, y (and z)",
        examples=["200 °C", {"value": "200 °C", "gradient": ["0 K/m", "-0.03 K/m"]}],
    )
    pressure: PressureInSpace | None = Field(
        default=None,
        description="pressure before the first step, likewise",
        examples=["20 MPa", {"value": "20 MPa", "gradient": ["0 MPa/m", "-0.01 MPa/m"]}],
    )
    h: Length | None = Field(
        default=None,
        description="edge of its cells in and beside the body; default 2 domain.h",
        examples=["1 m"],
    )
    beyond: dict[str, Length] = Field(
        default_factory=dict,
        description="how far it goes on beyond sides of the body, in growing cells",
        examples=[{"top": "40 m"}],
    )
    thickness: Length | None = Field(
        default=None,
        description="2-D only: extent across the plane, of which rates are; default 1 m",
        examples=["1 m"],
    )
    permeability: PermeabilityValue | None = Field(
        default=None,
        description="permeability, the same in all directions: a value, a formula of x, y (and z), "
        "a random field, or a field in a file",
        examples=PERMEABILITY_EXAMPLES,
    )
    porosity: PorosityValue | None = Field(
        default=None, description="porosity, likewise", examples=[0.01]
    )
    boxes: tuple[ReservoirBox, ...] = Field(
        default=(),
        max_length=100,
        description="at most 100 parts whose permeability or porosity differs; where they overlap, "
        "the last one counts",
        examples=[[{"lower": ["0 m", "5 m"], "upper": ["60 m", "8 m"], "porosity": 0.2}]],
    )
    water: Annotated[
        Annotated[Literal["iapws"], Tag("a value")] | Annotated[WaterKeys, Tag("a table")],
        Discriminator(kind),
    ] = Field(
        default=IAPWS,
        description="properties of the water: iapws (IAPWS-95, liquid alone), or constants",
        examples=[
            {"rho": "1000 kg/m^3", "c": "4200 J/(kg K)", "mu": "0.3 mPa s", "k": "0.6 W/(m K)"}
        ],
    )
    fractures: tuple[FractureKeys, ...] = Field(
        default=(),
        max_length=100,
        description="fractures that water flows in: along a side of the body, or start and end "
        "(2-D), or center, radius and normal (3-D)",
        examples=[[{"side": "bottom", "opening": "0.2 mm", "height": "0.1 m"}]],
    )
    wells: tuple[WellKeys, ...] = Field(
        default=(),
        max_length=100,
        description="wells: each injects at a temperature, or produces, at a rate or a pressure",
        examples=[WELLS_EXAMPLE],
    )
    fields: FieldsKeys | None = Field(
        default=None,
        description="fields only: times, a file at each, and what it calls temperature and "
        "pressure; linear in time between them",
        examples=[FIELDS_EXAMPLE],
    )
    biot: Annotated[Number, Field(ge=0, le=1)] | None = Field(
        default=None,
        description="Biot's coefficient: the part of the pressure that counts in pores, in cracks "
        "all of it does; default 1, and 0 in plane stress, where pores would press the plate apart",
        examples=[0.8],
    )
    tolerance: Annotated[PositiveNumber, Field(ge=1e-6, le=0.1)] = Field(
        default=1e-3,
        description="error of a step of the simulator over the drop from rock to injected water",
    )
    _interpreter: str | None = PrivateAttr(default=None)

    @field_validator("python")
    @classmethod
    def _trusted(cls, value: str | None, info: ValidationInfo) -> str | None:
        """Return the path of a program that the case may choose only with leave."""
        place = (info.context or {}).get(PLACE, FileAccess())
        if value is None:
            return None
        if not place.outside:
            raise ValueError(
                "a case may not choose a program by itself; allow it with --outside if you trust "
                "the case, or name it in STAFFA_DARTS"
            )
        try:
            return str(place.file(value))
        except InputError as error:
            raise ValueError(str(error)) from None

    @model_validator(mode="after")
    def _apart(self) -> "ReservoirKeys":
        """Keep the program apart: the record of a run does not name it, so that a run from anyone
        can be resumed."""
        if self.python is not None:
            self._interpreter = self.python
            object.__setattr__(self, "python", None)
        return self

    @property
    def interpreter(self) -> str | None:
        """Return the Python that the case names for the simulator, None for a search."""
        return self._interpreter
