"""The table [temperature]: what changes the temperature of the body."""

from typing import Annotated, Any

from pydantic import Field, StringConstraints, model_validator

from staffa.case.schema.field_types import CaseTable, Drop, PositiveNumber, one_of
from staffa.loads.closed_form import PROFILES
from staffa.properties.formula import LONGEST
from staffa.units import EXAMPLES

FORMULA, RESERVOIR = "formula", "reservoir"
# Profiles that need no cooled face: the temperature is that of any place.
FACELESS = (FORMULA, RESERVOIR)
NO_FACE = "none"


class TemperatureKeys(CaseTable):
    """The cooling: known in closed form, from the heat equation of the table [heat], or from the
    circulating water of the table [reservoir]."""

    profile: Annotated[str, one_of((*PROFILES, FORMULA, "heat", RESERVOIR, "none"))] = Field(
        default="half-space",
        description="half-space (endlessly deep, its face cold at once); slab (opposite "
        "boundary insulated); convective (a half-space behind a film); formula (the one of T); "
        "heat (from the heat equation, see [heat]); reservoir (from a reservoir simulator, see "
        "[reservoir]); none",
    )
    face: str = Field(
        default="bottom",
        description="the cooled side, from which depths are measured; with formula and "
        'reservoir any side, or "none", their default',
    )
    dT: Drop | None = Field(
        default=None,
        description="temperature drop; give this or severity",
        examples=[EXAMPLES["temperature difference"]],
    )
    severity: PositiveNumber | None = Field(
        default=None,
        description="expansion dT sqrt(E L/Gc), L the depth of the body; the paper's beta dT",
        examples=[54.0],
    )
    biot: PositiveNumber | None = Field(
        default=None,
        description="convective: film coefficient times L over conductivity",
        examples=[10.0],
    )
    T: Annotated[str, StringConstraints(max_length=LONGEST)] | None = Field(
        default=None,
        description="formula: change of temperature since the start (K, or scaled), of x, y (and "
        "z) and t, in m and s or scaled",
        examples=["-80*exp(-y/0.02)*(1 - exp(-t/60))"],
    )

    @model_validator(mode="before")
    @classmethod
    def _faceless(cls, given: Any) -> Any:
        """Write down that a profile which needs no face has none, unless the case gives one."""
        if isinstance(given, dict) and given.get("profile") in FACELESS:
            return {"face": NO_FACE, **given}
        return given

    @property
    def acts(self) -> bool:
        """Return True if the temperature changes."""
        return self.profile != "none"

    @property
    def cools_a_face(self) -> bool:
        """Return True if it is cooled from one face, whose drop and depth are scales."""
        return self.acts and self.profile not in FACELESS

    @property
    def has_face(self) -> bool:
        """Return True if depths count from a face."""
        return self.cools_a_face or (self.acts and self.face != NO_FACE)
