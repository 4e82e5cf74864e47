"""The values that a property of the rock may have, as keys: a number, a formula, a random field,
or a field in a file.

Each kind that varies is a table with a method `at_points`, which gives its values as a function of
points, shape (3, n) -> (n,), in a body of dim dimensions, in SI or scaled as the case is. Another
kind is another such class, a line in `form`, and one in `PropertyValue`.
"""

from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import (
    Discriminator,
    Field,
    PrivateAttr,
    StringConstraints,
    Tag,
    ValidationInfo,
    model_validator,
)

from staffa.case.schema.field_types import (
    Angle,
    CaseTable,
    Conductivity,
    Density,
    Direction,
    Expansion,
    FilePath,
    Formula,
    HeatCapacity,
    Integer,
    Length,
    Modulus,
    Permeability,
    PositiveNumber,
    Toughness,
    kind,
)
from staffa.case.schema.file_access import FileAccess
from staffa.errors import InputError
from staffa.physics.elasticity import PointFunction
from staffa.properties.axes import turned_by, with_third
from staffa.properties.mesh_field import Counting, MeshField, read_field
from staffa.properties.random_field import random_factor
from staffa.units import parse

PLACE = "place"  # of the case file, in the context of its validation


class RandomField(CaseTable):
    """A seeded random field, the same on any mesh partition."""

    mean: PositiveNumber = Field(description="mean of the field", examples=[0.2])
    variation: Annotated[PositiveNumber, Field(ge=1e-3, le=1)] = Field(
        description="coefficient of variation: standard deviation over mean", examples=[0.2]
    )
    distribution: Literal["lognormal", "normal", "weibull"] = Field(
        default="lognormal", description="of the values; normal up to a variation of 0.2 only"
    )
    length: Annotated[
        Annotated[Length, Tag("a value")] | Annotated[tuple[Length, ...], Tag("a list")],
        Discriminator(kind),
    ] = Field(
        description="correlation length: one, or one along x, y (and z), or along the axes",
        examples=[0.06, [0.5, 0.05]],
    )
    angle: Angle | None = Field(
        default=None,
        description="2-D only: from x to the direction of the first length, in degrees",
        examples=[30.0],
    )
    axes: tuple[Direction, ...] | None = Field(
        default=None,
        description="3-D only: directions of the first two lengths, perpendicular",
        examples=[[[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]],
    )
    seed: Annotated[Integer, Field(ge=0, lt=2**32)] = Field(
        default=0,
        description="of the random numbers: with one seed and one length, properties rise and fall "
        "together",
    )

    def at_points(self, dim: int) -> PointFunction:
        """Return values about its mean."""
        lengths = self.length if isinstance(self.length, tuple) else (self.length,) * dim
        axes = np.eye(3) if self.axes is None else with_third(self.axes)
        if self.angle is not None:
            axes = turned_by(self.angle)
        factor = random_factor(
            self.distribution,
            self.variation,
            lengths=tuple(float(length) for length in lengths),
            axes=axes[:dim, :dim],
            seed=self.seed,
        )
        return lambda x: float(self.mean) * factor(x)


def _mean(example: str) -> Any:
    return Field(description="mean of the field", examples=[example])


class RandomNumber(RandomField):
    """A random field of numbers."""


class RandomModulus(RandomField):
    """A random field of moduli."""

    mean: Modulus = _mean("70 GPa")


class RandomToughness(RandomField):
    """A random field of toughnesses."""

    mean: Toughness = _mean("10 J/m^2")


class RandomExpansion(RandomField):
    """A random field of expansion coefficients."""

    mean: Expansion = _mean("9e-6 1/K")


class RandomConductivity(RandomField):
    """A random field of conductivities."""

    mean: Conductivity = _mean("2.5 W/(m K)")


class RandomDensity(RandomField):
    """A random field of densities."""

    mean: Density = _mean("2700 kg/m^3")


class RandomHeatCapacity(RandomField):
    """A random field of heat capacities."""

    mean: HeatCapacity = _mean("800 J/(kg K)")


class RandomPermeability(RandomField):
    """A random field of permeabilities."""

    mean: Permeability = _mean("1e-15 m^2")


class FieldFile(CaseTable):
    """A field in a file, on any mesh, interpolated; in SI units, or scaled as the case is, if the
    other keys give no unit.

    It is read with the case, on rank 0, and goes with it to the other ranks. Once read it goes by
    its file's name, as the copy that is kept with a run does.
    """

    dimension: ClassVar[str] = ""

    file: FilePath = Field(
        description="the file, such as .vtu, .vtk or .vtkhdf; its path counts from the case file",
        examples=["rock.vtu"],
    )
    name: Annotated[str, StringConstraints(max_length=200)] = Field(
        description="name of the field in it", examples=["E"]
    )
    unit: Length | None = Field(
        default=None,
        description="how long what its coordinates count as 1 is; default 1 m",
        examples=["1 mm"],
    )
    field_unit: Annotated[str, StringConstraints(max_length=20)] | None = Field(
        default=None, description="unit of its values; default that of SI", examples=["GPa"]
    )
    _field: MeshField | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _read(self, info: ValidationInfo) -> "FieldFile":
        place = (info.context or {}).get(PLACE, FileAccess())
        try:
            self._field = read_field(place.file(self.file), self.name, self._counting())
        except InputError as error:
            raise ValueError(str(error)) from None
        object.__setattr__(self, "file", self.path.name)  # by nobody else: a case is frozen
        return self

    def _counting(self) -> Counting:
        """Return the units of its values and coordinates."""
        length = float(self.unit or 1.0)
        if self.field_unit is None:
            return Counting(length=length)
        if not self.dimension:
            raise InputError(f'field_unit = "{self.field_unit}" is for a quantity that has a unit')
        zero, one = (float(parse(f"{n} {self.field_unit}", self.dimension)) for n in (0, 1))
        return Counting(length=length, zero=zero, one=one)

    @property
    def field(self) -> MeshField:
        """Return the field."""
        assert self._field is not None
        return self._field

    @property
    def path(self) -> Path:
        """Return the path of the file."""
        assert self._field is not None
        return self._field.path

    def at_points(self, dim: int) -> PointFunction:
        """Return the values of the field, interpolated; NaN outside of its mesh."""
        assert self._field is not None
        return self._field


class ModulusFile(FieldFile):
    """A field of moduli."""

    dimension: ClassVar[str] = "stress"


class ToughnessFile(FieldFile):
    """A field of toughnesses."""

    dimension: ClassVar[str] = "toughness"


class ExpansionFile(FieldFile):
    """A field of expansion coefficients."""

    dimension: ClassVar[str] = "thermal expansion"


class ConductivityFile(FieldFile):
    """A field of conductivities."""

    dimension: ClassVar[str] = "conductivity"


class DensityFile(FieldFile):
    """A field of densities."""

    dimension: ClassVar[str] = "density"


class HeatCapacityFile(FieldFile):
    """A field of heat capacities."""

    dimension: ClassVar[str] = "heat capacity"


class PermeabilityFile(FieldFile):
    """A field of permeabilities."""

    dimension: ClassVar[str] = "permeability"


def kind_of_property_value(value: Any) -> str:
    """Return the alternative of a property by its keys, so that only one can complain."""
    keys = set(value) if isinstance(value, dict) else set()
    if isinstance(value, Formula) or "formula" in keys:
        return "a formula"
    if isinstance(value, FieldFile) or "file" in keys:
        return "a file"
    if keys or isinstance(value, RandomField):
        return "a random field"
    return "no table" if isinstance(value, dict) else "one value"


def one_or_more(value: Any) -> str:
    """Return in words whether a property has one value or a list of them."""
    return "a list" if isinstance(value, list | tuple) else "one property"


# R: the random field whose mean is a Q; F: the field in a file whose values are.
type PropertyValue[Q, R, F] = Annotated[
    Annotated[Q, Tag("one value")]
    | Annotated[Formula, Tag("a formula")]
    | Annotated[R, Tag("a random field")]
    | Annotated[F, Tag("a file")],
    Discriminator(kind_of_property_value),
]
type OneOrMore[One, Each] = Annotated[
    Annotated[One, Tag("one property")] | Annotated[tuple[Each, ...], Tag("a list")],
    Discriminator(one_or_more),
]
