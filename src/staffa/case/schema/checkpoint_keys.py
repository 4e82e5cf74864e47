"""How often a run is saved, as keys."""

from typing import Annotated

from pydantic import Field

from staffa.case.schema.field_types import CaseTable, Integer, PositiveNumber


class CheckpointKeys(CaseTable):
    """After so many steps, or so many minutes, whichever comes first."""

    steps: Annotated[Integer, Field(ge=1)] = Field(
        default=1, description="save after so many steps", examples=[1]
    )
    minutes: PositiveNumber = Field(
        default=10.0, description="and after a step at whose end so many minutes have gone"
    )
