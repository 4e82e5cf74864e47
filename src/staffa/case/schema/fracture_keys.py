"""Fractures that water flows in: those of the case, and the openings of all cracks."""

from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag

from staffa.case.schema.field_types import CaseTable, Length, Number, Position
from staffa.units import Quantity

OPENING = Field(description="opening of the fracture", examples=["0.2 mm"])


class FractureSide(CaseTable):
    """A fracture along a side of the body, whose other wall is the mirror image of the body."""

    side: str = Field(description="the side of the body along it", examples=["bottom"])
    opening: Length = OPENING
    height: Length = Field(
        description="height of its cells, the half of which lies beyond the side; the cells beside "
        "them begin as small",
        examples=["0.1 m"],
    )


class FractureLine(CaseTable):
    """A straight fracture of a 2-D reservoir."""

    start: tuple[Position, ...] = Field(description="one end", examples=[["0 m", "5 m"]])
    end: tuple[Position, ...] = Field(description="the other end", examples=[["60 m", "5 m"]])
    opening: Length = OPENING


class FractureDisc(CaseTable):
    """A flat round fracture of a 3-D reservoir."""

    center: tuple[Position, ...] = Field(
        description="middle of the disc", examples=[["30 m", "30 m", "10 m"]]
    )
    radius: Length = Field(description="radius of the disc", examples=["20 m"])
    normal: tuple[Number, ...] = Field(
        description="a direction across the disc, of any length", examples=[[0.0, 0.0, 1.0]]
    )
    opening: Length = OPENING


def _form_of_fracture(value: Any) -> str:
    """Return the kind of a fracture, by its keys."""
    if isinstance(value, dict):
        if "side" in value:
            return "a side"
        return "a disc" if {"center", "radius", "normal"} & set(value) else "a segment"
    if isinstance(value, FractureSide):
        return "a side"
    return "a segment" if isinstance(value, FractureLine) else "a disc"


FractureKeys = Annotated[
    Annotated[FractureSide, Tag("a side")]
    | Annotated[FractureLine, Tag("a segment")]
    | Annotated[FractureDisc, Tag("a disc")],
    Discriminator(_form_of_fracture),
]


class OpeningKeys(CaseTable):
    """Openings of cracks that water flows in."""

    smallest: Length = Field(
        default=Quantity(20 * 1e-6, "20 um"),
        description="opening below which no crack closes, and no fracture along a side",
        examples=["20 um"],
    )
    largest: Length = Field(
        default=Quantity(2e-3, "2 mm"),
        description="opening from which a crack gets no more permeable; at most 5 mm",
        examples=["2 mm"],
    )
    spread: Length | None = Field(
        default=None,
        description="radius over which a crack is spread, at least 2.25 cells of the reservoir "
        "and 2 damage.ell; default: the larger of these",
        examples=["2 m"],
    )
