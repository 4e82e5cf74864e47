"""The table domain.refine: how the mesh follows the cracks, as keys."""

import re
from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag

from staffa.case.schema.field_types import CaseTable, Flag, PositiveNumber
from staffa.case.schema.json_schema import Rule

# Number of h or of ell, at most.
MOST = 1_000_000


def _in(unit: str) -> Rule:
    """Return the rule for a number of h or of ell, as text."""
    pattern = rf"\d+(\.\d+)? {unit}"

    def read(text: str) -> str:
        if not re.fullmatch(pattern, text) or not 0 < multiple(text) <= MOST:
            raise ValueError(
                f'it must be a number of {unit} above 0 and up to {MOST:,}, like "4 {unit}"'
            )
        return text

    return Rule(read, pattern=f"^{pattern}$")


Edges = Annotated[str, _in("h")]
Bands = Annotated[str, _in("ell")]
Share = Annotated[PositiveNumber, Field(le=1)]


class RefineKeys(CaseTable):
    """Settings of a mesh that follows the cracks (docs/how-to/refinement.md)."""

    coarsest: Edges | None = Field(
        default=None,
        description="longest edge of the cells at the start, in h; it is halved until cells are h "
        "long where cracks are; default: a sixteenth of the shortest side of the body",
        examples=["8 h"],
    )
    ahead: Bands = Field(
        default="2 ell",
        description="distance from damage within which cells with their middles there are h long",
        examples=["2 ell"],
    )
    drive: Share = Field(
        default=0.5,
        description="energy that drives the damage, over its threshold, from which on cells are h "
        "long (AT1)",
        examples=[0.5],
    )
    drop: Share = Field(
        default=0.02,
        description="change of temperature over a cell, over the largest change since the start, "
        "from which on the cell is split",
        examples=[0.02],
    )


def _kind(value: Any) -> str:
    return "a table" if isinstance(value, dict | RefineKeys) else "one value"


Refine = Annotated[
    Annotated[Flag, Tag("one value")] | Annotated[RefineKeys, Tag("a table")], Discriminator(_kind)
]


def multiple(text: str) -> float:
    """Return the number before h or ell."""
    return float(text.split()[0])
