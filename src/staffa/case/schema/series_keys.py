"""Temperature and pressure from files of another simulator, as keys: a file for each time."""

from typing import Annotated

from pydantic import Field, PrivateAttr, StringConstraints, ValidationInfo, model_validator

from staffa.case.schema.field_types import CaseTable, FilePath, Instant, Length
from staffa.case.schema.file_access import FileAccess
from staffa.case.schema.property_keys import PLACE
from staffa.errors import InputError
from staffa.properties.field_series import FieldSeries, read_series
from staffa.properties.mesh_field import Counting
from staffa.units import parse

MOST_FILES = 1000
FieldName = Annotated[str, StringConstraints(max_length=200)]
UnitName = Annotated[str, StringConstraints(max_length=20)]


class FieldsKeys(CaseTable):
    """Fields at given times, linear between them. They are read with the case, on rank 0, and go
    by their files' names then."""

    t: tuple[Instant, ...] = Field(
        max_length=MOST_FILES,
        description="times, increasing, from 0 to the end of the run",
        examples=[["0 s", "30 d", "1 y"]],
    )
    files: tuple[FilePath, ...] = Field(
        max_length=MOST_FILES,
        description="a file for each time, such as .vtu, .vtkhdf or a table of points .csv; "
        "paths count from the case file",
        examples=[["T-0.vtu", "T-1.vtu", "T-2.vtu"]],
    )
    T: FieldName = Field(
        description="name of the temperature in each file", examples=["temperature"]
    )
    T_unit: UnitName = Field(default="K", description="unit of the temperature", examples=["°C"])
    p: FieldName | None = Field(
        default=None,
        description="name of the pressure; without it pressure acts nowhere",
        examples=["pressure"],
    )
    p_unit: UnitName = Field(default="Pa", description="unit of the pressure", examples=["MPa"])
    unit: Length | None = Field(
        default=None,
        description="how long what coordinates count as 1 is; default 1 m",
        examples=["1 mm"],
    )
    _series: FieldSeries | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _read(self, info: ValidationInfo) -> "FieldsKeys":
        place = (info.context or {}).get(PLACE, FileAccess())
        try:
            paths = [place.file(file) for file in self.files]
            self._series = read_series(
                paths,
                [float(t) for t in self.t],
                T=self.T,
                p=self.p,
                T_counts=self._counting("T_unit", self.T_unit, "temperature"),
                p_counts=self._counting("p_unit", self.p_unit, "pressure"),
            )
        except InputError as error:
            raise ValueError(str(error)) from None
        object.__setattr__(self, "files", tuple(path.name for path in paths))  # as `FieldFile`
        return self

    def _counting(self, key: str, unit: str, dimension: str) -> Counting:
        try:
            zero, one = (float(parse(f"{n} {unit}", dimension)) for n in (0, 1))
        except InputError as error:
            raise InputError(f'{key} = "{unit}": {error}') from None
        return Counting(length=float(self.unit or 1.0), zero=zero, one=one)

    @property
    def series(self) -> FieldSeries:
        """Return temperature and pressure at all times."""
        assert self._series is not None
        return self._series
