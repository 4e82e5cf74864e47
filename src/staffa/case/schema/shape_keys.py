"""The shapes that a case can ask for, as keys, and what they stand for."""

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from staffa.case.schema.field_types import CaseTable, Length, Name, Position
from staffa.geometry.shapes import Bored, Layered, Round, Shape

KINDS = ("plate with hole", "wellbore", "disc", "cylinder", "layers")
RADIUS = "radius of the hole, or of a round body"


class _Bored(CaseTable):
    """Common keys of a plate with a hole and of a block with a bore."""

    size: tuple[Length, ...] = Field(description="extent along each axis", examples=[[2.0, 2.0]])
    radius: Length = Field(description=RADIUS, examples=[0.1])
    center: tuple[Position, Position] | None = Field(
        default=None,
        description="x and y of its middle; that of the body if left out",
        examples=[[1.0, 1.0]],
    )

    def shape(self) -> Shape:
        """Return the shape that the keys describe."""
        size = tuple(float(s) for s in self.size)
        x, y = self.center or (size[0] / 2, size[1] / 2)
        return Bored(size=size, radius=float(self.radius), center=(float(x), float(y)))


class PlateWithHole(_Bored):
    """A rectangle with a round hole: left, right, bottom, top, hole."""

    kind: Literal["plate with hole"]


class Wellbore(_Bored):
    """A box with an upright round bore through it: the sides of a box, and well."""

    kind: Literal["wellbore"]


class RoundPlate(CaseTable):
    """A disc around the origin: side."""

    kind: Literal["disc"]
    radius: Length = Field(description=RADIUS, examples=[1.0])

    def shape(self) -> Shape:
        """Return the shape that the keys describe."""
        return Round(radius=float(self.radius))


class Cylinder(CaseTable):
    """An upright cylinder whose bottom lies around the origin: side, bottom, top."""

    kind: Literal["cylinder"]
    radius: Length = Field(description=RADIUS, examples=[1.0])
    height: Length = Field(description="its height", examples=[2.0])

    def shape(self) -> Shape:
        """Return the shape that the keys describe."""
        return Round(radius=float(self.radius), height=float(self.height))


class Layer(CaseTable):
    """A horizontal layer."""

    region: Name = Field(description="its region, which may come again", examples=["shale"])
    thickness: Length = Field(description="how thick it is", examples=[0.3])


class Layers(CaseTable):
    """A rectangle or a box of horizontal layers: the sides of a block, and a region by layer."""

    kind: Literal["layers"]
    base: tuple[Length, ...] = Field(
        description="extent along x (2-D), or x and y (3-D)", examples=[[2.0]]
    )
    layers: tuple[Layer, ...] = Field(
        max_length=200,  # each is a region, and what is said of regions takes the square of these
        description="from the bottom up",
        examples=[[{"region": "shale", "thickness": 0.3}]],
    )

    def shape(self) -> Shape:
        """Return the shape that the keys describe."""
        layers = tuple((layer.region, float(layer.thickness)) for layer in self.layers)
        return Layered(base=tuple(float(b) for b in self.base), layers=layers)


def _kind(value: Any) -> str | None:
    """Return the kind of a shape after a word, since a key may have the name of a kind."""
    found = value.get("kind") if isinstance(value, dict) else getattr(value, "kind", None)
    return f"kind {found}"


ShapeKeys = Annotated[
    Annotated[PlateWithHole, Tag("kind plate with hole")]
    | Annotated[Wellbore, Tag("kind wellbore")]
    | Annotated[RoundPlate, Tag("kind disc")]
    | Annotated[Cylinder, Tag("kind cylinder")]
    | Annotated[Layers, Tag("kind layers")],
    Discriminator(_kind),
]
