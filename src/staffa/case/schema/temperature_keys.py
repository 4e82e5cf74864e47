"""Properties of the rock that temperature changes, as keys: a table of temperature, or a formula
of T.

Beside `at_points`, their values at a reference temperature, they have `law`, the factor on these by
temperature, None where there is none. The reference is the mean temperature at the start; each
part of the rock knows it (`case.values.subdomains`).
"""

from collections.abc import Iterable
from typing import Annotated, Any, Self

import numpy as np
from pydantic import (
    BaseModel,
    Discriminator,
    Field,
    InstanceOf,
    PrivateAttr,
    StringConstraints,
    Tag,
)

from staffa.case.schema.field_types import (
    CaseTable,
    Conductivity,
    Density,
    Expansion,
    Formula,
    HeatCapacity,
    Modulus,
    Number,
    PositiveNumber,
    Temperature,
    Toughness,
)
from staffa.case.schema.property_keys import (
    ConductivityFile,
    DensityFile,
    ExpansionFile,
    FieldFile,
    HeatCapacityFile,
    ModulusFile,
    PropertyValue,
    RandomConductivity,
    RandomDensity,
    RandomExpansion,
    RandomHeatCapacity,
    RandomModulus,
    RandomNumber,
    RandomToughness,
    ToughnessFile,
    kind_of_property_value,
)
from staffa.physics.elasticity import PointFunction, values
from staffa.physics.temperature import ARRAYS, Law, LinearTable, Secant, Written
from staffa.properties.formula import LONGEST, formula_variables, generic, uses
from staffa.units import Quantity

LONGEST_TABLE = 100
OF_T = "T"  # what formulas call temperature


class WithReference(CaseTable):
    """A value of temperature and place."""

    _reference: float = PrivateAttr(default=0.0)

    def known_at(self, T: float) -> Self:
        """Return the same with another reference temperature (K)."""
        copy = self.model_copy()
        copy._reference = T
        return copy

    @property
    def of_temperature(self) -> bool:
        """Return True if temperature changes it."""
        return True

    def law(self, dim: int) -> Law | None:
        """Return values over those at the reference temperature, of a body of dim dimensions."""
        raise NotImplementedError


class InTemperature(CaseTable):
    """Values by temperature: linear between the given ones and constant beyond them."""

    T: tuple[Temperature, ...] = Field(
        max_length=LONGEST_TABLE,
        description="temperatures, increasing",
        examples=[["20 °C", "600 °C"]],
    )
    value: tuple[InstanceOf[Quantity] | float, ...] = Field(description="the value at each of them")

    def values_at(self, T: np.ndarray | float) -> np.ndarray:
        """Return its values at temperatures (K), of the same shape."""
        at, values = np.array(self.T, dtype=float), np.array(self.value, dtype=float)
        found: np.ndarray = np.interp(T, at, values)
        return found


class PropertyInTemperature(InTemperature, WithReference):
    """A property of the rock by temperature."""

    factor: PropertyValue[PositiveNumber, RandomNumber, FieldFile] | None = Field(
        default=None,
        description="factor on all of them by place: a formula of x, y (and z), a random field, or "
        "a field in a file",
        examples=[{"mean": 1.0, "variation": 0.2, "length": "5 mm"}],
    )

    def at_points(self, dim: int) -> PointFunction:
        """Return values at the reference temperature."""
        level = self._level()
        if self.factor is None:
            return lambda x: np.full(x.shape[1], level)
        factor = self.factor.at_points(dim) if isinstance(self.factor, CaseTable) else self.factor
        return lambda x: level * values(factor, x)

    def law(self, dim: int) -> Law | None:
        """See `WithReference`."""
        level = self._level()
        rows = tuple(float(value) / level for value in self.value)
        return LinearTable(T=tuple(float(T) for T in self.T), value=rows)

    def _level(self) -> float:
        return float(self.values_at(self._reference))


def _values(*examples: str | float) -> Any:
    return Field(description="the value at each of them", examples=[list(examples)])


class ModulusInTemperature(PropertyInTemperature):
    """A modulus by temperature."""

    value: tuple[Modulus, ...] = _values("70 GPa", "60 GPa")


class NumberInTemperature(PropertyInTemperature):
    """A number by temperature."""

    value: tuple[Number, ...] = _values(0.2, 0.25)


class ToughnessInTemperature(PropertyInTemperature):
    """A toughness by temperature."""

    value: tuple[Toughness, ...] = _values("10 J/m^2", "20 J/m^2")


class ConductivityInTemperature(PropertyInTemperature):
    """A conductivity by temperature."""

    value: tuple[Conductivity, ...] = _values("3 W/(m K)", "2 W/(m K)")


class DensityInTemperature(PropertyInTemperature):
    """A density by temperature."""

    value: tuple[Density, ...] = _values("2700 kg/m^3", "2650 kg/m^3")


class HeatCapacityInTemperature(PropertyInTemperature):
    """A heat capacity by temperature."""

    value: tuple[HeatCapacity, ...] = _values("800 J/(kg K)", "1100 J/(kg K)")


SECANT: Any = Field(
    default=None,
    description="temperature from which the values are secant (mean) coefficients; tangent ones if "
    "left out",
    examples=["20 °C"],
)


class ExpansionInTemperature(PropertyInTemperature):
    """An expansion coefficient by temperature."""

    value: tuple[Expansion, ...] = _values("8e-6 1/K", "12e-6 1/K")
    secant: Temperature | None = SECANT

    def law(self, dim: int) -> Law | None:
        """See `PropertyInTemperature`."""
        return _secant(super().law(dim), self.secant)


class PropertyFormula(WithReference, Formula):
    """A formula of place and T, the temperature (K), in SI units, or scaled as the case is."""

    formula: Annotated[str, StringConstraints(max_length=LONGEST)] = Field(
        description="of x, y (and z), and of the temperature T (K)",
        examples=["70e9 - 1e7*(T - 293)"],
    )

    @property
    def of_temperature(self) -> bool:
        """See `WithReference`."""
        return uses(self.formula, OF_T)

    def values_at(self, T: np.ndarray, x: np.ndarray) -> np.ndarray:
        """Return its values at temperatures (K) and places, shapes (n,) and (3, n)."""
        found = self._value(3)(T, x, ARRAYS.functions)
        return np.broadcast_to(found, np.shape(T)).astype(float)

    def at_points(self, dim: int) -> PointFunction:
        """Return values at the reference temperature."""
        if not self.of_temperature:
            return super().at_points(dim)
        value, T = self._value(dim), self._reference
        return lambda x: np.broadcast_to(value(T, x, ARRAYS.functions), x.shape[1:]).astype(float)

    def law(self, dim: int) -> Law | None:
        """See `WithReference`."""
        if not self.of_temperature:
            return None
        return Written(text=self.formula, reference=self._reference, value=self._value(dim))

    def _value(self, dim: int) -> Any:
        evaluated = generic(self.formula, (*formula_variables(dim, time=False), OF_T))
        return lambda T, x, functions: evaluated(
            {"x": x[0], "y": x[1], "z": x[2], OF_T: T}, functions
        )


class ExpansionFormula(PropertyFormula):
    """A formula of an expansion coefficient."""

    secant: Temperature | None = SECANT

    def law(self, dim: int) -> Law | None:
        """See `PropertyFormula`."""
        return _secant(super().law(dim), self.secant)


def _secant(law: Law | None, reference: Temperature | None) -> Law | None:
    if law is None or reference is None:
        return law
    return Secant(mean=law, reference=float(reference))


def of_temperature(value: Any) -> bool:
    """Return True if temperature changes a property."""
    return isinstance(value, WithReference) and value.of_temperature


def depends_on_place(value: Any) -> bool:
    """Return True if a table that stands for a property differs from place to place."""
    if isinstance(value, PropertyInTemperature):
        return value.factor is not None
    if isinstance(value, PropertyFormula):
        return not value.of_temperature or any(uses(value.formula, axis) for axis in "xyz")
    return True


def law_of(value: Any, dim: int) -> Law | None:
    """Return the law of a property; None where temperature does not change it."""
    return value.law(dim) if isinstance(value, WithReference) else None


def with_reference[K: BaseModel](keys: K, fields: Iterable[str], T: float) -> K:
    """Return a table whose properties of temperature refer to a temperature.

    Parameters
    ----------
    keys : the table.
    fields : names of its properties.
    T : reference temperature (K).
    """
    found = {name: getattr(keys, name) for name in fields}
    known = {n: v.known_at(T) for n, v in found.items() if isinstance(v, WithReference)}
    return keys.model_copy(update=known) if known else keys


def kind_of_property(value: Any) -> str:
    """Tell which alternative of a property is meant: by its keys, so that only one complains."""
    if isinstance(value, InTemperature) or (isinstance(value, dict) and OF_T in value):
        return "a table of temperature"
    return kind_of_property_value(value)


# R: the random field whose mean is a Q; L: its table of temperature; F: its formula; X: the field
# in a file whose values are.
type LawfulValue[Q, R, L, F, X] = Annotated[
    Annotated[Q, Tag("one value")]
    | Annotated[F, Tag("a formula")]
    | Annotated[R, Tag("a random field")]
    | Annotated[L, Tag("a table of temperature")]
    | Annotated[X, Tag("a file")],
    Discriminator(kind_of_property),
]
ModulusValue = LawfulValue[
    Modulus, RandomModulus, ModulusInTemperature, PropertyFormula, ModulusFile
]
ToughnessValue = LawfulValue[
    Toughness, RandomToughness, ToughnessInTemperature, PropertyFormula, ToughnessFile
]
ExpansionValue = LawfulValue[
    Expansion, RandomExpansion, ExpansionInTemperature, ExpansionFormula, ExpansionFile
]
ConductivityValue = LawfulValue[
    Conductivity, RandomConductivity, ConductivityInTemperature, PropertyFormula, ConductivityFile
]
DensityValue = LawfulValue[
    Density, RandomDensity, DensityInTemperature, PropertyFormula, DensityFile
]
HeatCapacityValue = LawfulValue[
    HeatCapacity, RandomHeatCapacity, HeatCapacityInTemperature, PropertyFormula, HeatCapacityFile
]
type RatioValue[Q] = LawfulValue[Q, RandomNumber, NumberInTemperature, PropertyFormula, FieldFile]
