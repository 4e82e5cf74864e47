"""Keys of the times at which a run is saved."""

from typing import Annotated

from pydantic import Field

from staffa.case.schema.field_types import CaseTable, Integer, PositiveNumber


class CheckpointKeys(CaseTable):
    """Save after a number of steps, or of minutes, whichever comes first."""

    steps: Annotated[Integer, Field(ge=1)] = Field(
        default=1, description="save after this many steps", examples=[1]
    )
    minutes: PositiveNumber = Field(
        default=10.0, description="and after a step at whose end this many minutes have gone"
    )
