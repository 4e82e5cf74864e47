"""The table [supports]: what holds and moves the sides of a body, as keys."""

from dataclasses import replace
from typing import Annotated, Any, ClassVar, Literal

from pydantic import Discriminator, Field, Tag

from staffa.case.schema.field_types import CaseTable, Instant, Number, Position, SidesTable, kind
from staffa.case.schema.property_keys import FieldFile
from staffa.properties.mesh_field import Counting


class DisplacementHistory(CaseTable):
    """A displacement in time: linear between the given times and constant beyond them."""

    t: tuple[Instant, ...] = Field(description="times, increasing", examples=[[0.0, 1.0]])
    u: tuple[Position, ...] = Field(
        description="the displacement at each of them", examples=[[0.0, 0.1]]
    )


class DisplacementFile(FieldFile):
    """Displacements of a side from a field in a file, constant, or times a factor in time."""

    dimension: ClassVar[str] = "length"
    component: Literal["x", "y", "z"] | None = Field(
        default=None, description="of a vector: which component", examples=["x"]
    )
    t: tuple[Instant, ...] | None = Field(
        default=None, description="times, increasing", examples=[[0.0, 1.0]]
    )
    factor: tuple[Number, ...] | None = Field(
        default=None,
        description="on the field at each of them, linear between them and constant beyond",
        examples=[[0.0, 1.0]],
    )

    def _counting(self) -> Counting:
        axis = None if self.component is None else "xyz".index(self.component)
        return replace(super()._counting(), component=axis)


def _component(axis: str) -> Any:
    return Field(
        default=None,
        description=f"displacement along {axis}: a number, a table of times t and values u, or a "
        "field in a file, also times a table of factors",
        examples=[
            0.1,
            {"t": [0.0, 1.0], "u": [0.0, 0.1]},
            {"file": "u.vtu", "name": "ux", "field_unit": "mm"},
        ],
    )


def _history(value: Any) -> str:
    """Tell which alternative of a displacement is meant."""
    is_file = isinstance(value, FieldFile) or (isinstance(value, dict) and "file" in value)
    return "a file" if is_file else kind(value)


Component = Annotated[
    Annotated[Position, Tag("a value")]
    | Annotated[DisplacementHistory, Tag("a table")]
    | Annotated[DisplacementFile, Tag("a file")],
    Discriminator(_history),
]


class Prescribed(CaseTable):
    """Displacement components prescribed on a side."""

    x: Component | None = _component("x")
    y: Component | None = _component("y")
    z: Component | None = _component("z")


Support = Annotated[
    Annotated[Literal["free", "rollers", "clamped"], Tag("a value")]
    | Annotated[Prescribed, Tag("a table")],
    Discriminator(kind),
]
SUPPORT_EXAMPLE = {"y": {"t": [0.0, 1.0], "u": [0.0, 0.1]}}


def _support(side: str) -> Any:
    return Field(default="free", description=side, examples=[SUPPORT_EXAMPLE])


class SupportKeys(SidesTable):
    """Supports of the body. Each side is "free", "rollers" (no displacement across it), "clamped",
    or moved, like { y = { t = [0.0, 1.0], u = [0.0, 0.1] } } or { x = 0.1 }. The faces of a mesh or
    a shape go by their names. Rigid motions that are left are stopped without any stress."""

    __pydantic_extra__: dict[str, Support]

    left: Support | None = _support("side x = 0")
    right: Support | None = _support("side x = width")
    bottom: Support | None = _support("lower side")
    top: Support | None = _support("upper side")
    front: Support | None = Field(
        default=None, description="side y = 0, 3-D only", examples=["free", SUPPORT_EXAMPLE]
    )
    back: Support | None = Field(
        default=None, description="side y = depth, 3-D only", examples=["free", SUPPORT_EXAMPLE]
    )
    section: Literal["none", "fixed", "stretch", "free"] = Field(
        default="none",
        description="what the rest of a long slab does to this part of it, 2-D: fixed (left and "
        "right stay), stretch (they stay upright, no force: it may shorten), free (no force, no "
        "moment: it may bend too); puts rollers on left and right",
    )
