"""Keys of probes, which read the fields at every step: points, and lines of points."""

from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag

from staffa.case.schema.field_types import CaseTable, Integer, Name, Position

MOST = 1000  # points of a line: each is a row a step


class Spot(CaseTable):
    """One point of the body."""

    name: Name = Field(description="what the point is called in probes.csv", examples=["well"])
    point: tuple[Position, ...] = Field(description="where it is", examples=[[0.5, 0.5]])


class Line(CaseTable):
    """Points at equal distances on a straight line."""

    name: Name = Field(description="what the line is called in probes.csv", examples=["axis"])
    start: tuple[Position, ...] = Field(description="its first point", examples=[[0.5, 0.0]])
    end: tuple[Position, ...] = Field(description="its last point", examples=[[0.5, 1.0]])
    points: Annotated[Integer, Field(ge=2, le=MOST)] = Field(
        default=50, description="how many, ends included"
    )


def _shape(value: Any) -> str:
    """Return the kind of a probe, by its keys."""
    if isinstance(value, dict):
        return "a line" if {"start", "end", "points"} & set(value) else "a spot"
    return "a line" if isinstance(value, Line) else "a spot"


ProbeKeys = Annotated[
    Annotated[Spot, Tag("a spot")] | Annotated[Line, Tag("a line")], Discriminator(_shape)
]
