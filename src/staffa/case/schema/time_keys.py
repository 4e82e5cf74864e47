"""When a run looks at its body, as keys: a list of times, equal steps, or steps that adapt."""

from typing import Annotated, Any

from pydantic import Discriminator, Field, Tag

from staffa.case.schema.field_types import (
    POSITIVE,
    CaseTable,
    Instant,
    Integer,
    PositiveNumber,
    kind,
)
from staffa.case.schema.json_schema import Rule


def _two_ends(steps: int) -> int:
    if steps < 2:
        raise ValueError("it must be at least 2, since both ends are included; or give a list")
    return steps


Steps = Annotated[Integer, Rule(_two_ends, minimum=2), Field(le=100_000)]


class UniformTau(CaseTable):
    """Equal steps in tau, both ends included."""

    start: PositiveNumber = Field(description="the first", examples=[0.01])
    stop: PositiveNumber = Field(description="the last", examples=[0.4])
    steps: Steps = Field(description="how many, both ends included", examples=[40])


class UniformTime(CaseTable):
    """Equal steps in time, both ends included."""

    start: Instant = Field(description="the first", examples=["1 s"])
    stop: Instant = Field(description="the last", examples=["2 min"])
    steps: Steps = Field(description="how many, both ends included", examples=[40])


ADVANCE, GROWTH = 2.0, 0.25


def _advance() -> Any:
    return Field(
        default=ADVANCE,
        description="how far cracks may run in a step, over damage.ell; a step in which they run "
        "farther is taken again, half as long, unless it is the shortest",
    )


def _growth() -> Any:
    return Field(
        default=GROWTH,
        description="fraction by which sqrt(kappa t) may grow in a step, if anything is cooled",
    )


class AdaptiveTau(CaseTable):
    """Adaptive steps in tau; their length follows cracks and cooling, some end at output.at."""

    start: PositiveNumber = Field(description="the first", examples=[0.01])
    stop: PositiveNumber = Field(description="the last", examples=[0.4])
    shortest: PositiveNumber = Field(description="the shortest step", examples=[0.0005])
    longest: PositiveNumber = Field(description="the longest step", examples=[0.02])
    advance: PositiveNumber = _advance()
    growth: PositiveNumber = _growth()


class AdaptiveTime(CaseTable):
    """Adaptive steps in t; their length follows cracks and cooling, some end at output.at."""

    start: Instant = Field(description="the first", examples=["1 s"])
    stop: Instant = Field(description="the last", examples=["2 min"])
    shortest: Annotated[Instant, POSITIVE] = Field(
        description="the shortest step", examples=["0.1 s"]
    )
    longest: Annotated[Instant, POSITIVE] = Field(description="the longest step", examples=["5 s"])
    advance: PositiveNumber = _advance()
    growth: PositiveNumber = _growth()


def _how_times_are_given(value: Any) -> str | None:
    """Return the kind of times, by the keys, so that only one alternative can complain."""
    if isinstance(value, AdaptiveTau | AdaptiveTime):
        return "adaptive steps"
    adaptive = isinstance(value, dict) and {"shortest", "longest", "advance", "growth"} & set(value)
    return "adaptive steps" if adaptive else kind(value)


Taus = Annotated[
    Annotated[UniformTau, Tag("a table")]
    | Annotated[AdaptiveTau, Tag("adaptive steps")]
    | Annotated[tuple[PositiveNumber, ...], Tag("a list")],
    Discriminator(_how_times_are_given),
]
Times = Annotated[
    Annotated[UniformTime, Tag("a table")]
    | Annotated[AdaptiveTime, Tag("adaptive steps")]
    | Annotated[tuple[Instant, ...], Tag("a list")],
    Discriminator(_how_times_are_given),
]


class TimeKeys(CaseTable):
    """Ends of the steps: give tau or t. Each is a list, or equal steps { start, stop, steps }, or
    adaptive ones { start, stop, shortest, longest, advance, growth }, whose length follows cracks
    and cooling."""

    tau: Taus | None = Field(
        default=None,
        description="2 sqrt(kappa t)/L: T = -dT erfc(y/(tau L)) in a half-space",
        examples=[
            {"start": 0.005, "stop": 0.4, "steps": 40},
            {"start": 0.005, "stop": 0.4, "shortest": 0.0005, "longest": 0.02},
            [0.1, 0.2, 0.4],
        ],
    )
    t: Times | None = Field(
        default=None,
        description="time",
        examples=[
            {"start": "1 s", "stop": "2 min", "steps": 40},
            {"start": "1 s", "stop": "2 min", "shortest": "0.1 s", "longest": "5 s"},
            ["1 s", "2 min"],
        ],
    )
