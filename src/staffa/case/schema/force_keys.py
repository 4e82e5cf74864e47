"""The table [forces]: what pulls and presses on a body besides cold, as keys."""

from typing import Annotated, Any

from pydantic import Field

from staffa.case.schema.field_types import (
    Acceleration,
    CaseTable,
    CrackVolume,
    Number,
    SidesTable,
    Stress,
    StressGradient,
)
from staffa.case.schema.heat_keys import Even, Given, InTime
from staffa.geometry.block import SIDES

STRESS_EXAMPLES = [
    "-20 MPa",
    {"value": "-20 MPa", "gradient": ["0 MPa/m", "0.02 MPa/m"]},
    {"formula": "-20e6 + 2e4*y"},
]
IN_TIME_EXAMPLES = ["10 MPa", {"t": ["0 s", "10 min"], "value": ["0 MPa", "10 MPa"]}]


class StressWithDepth(Even):
    """A stress that changes evenly along a direction."""

    value: Stress = Field(description="stress at the origin", examples=["-20 MPa"])
    gradient: tuple[StressGradient, ...] = Field(
        description="its change along x, y (2-D) or x, y, z (3-D)",
        examples=[["0 MPa/m", "0.02 MPa/m"]],
    )


StressInSpace = Given[Stress, StressWithDepth]


class StressInTime(InTime):
    """A stress in time."""

    value: tuple[Stress, ...] = Field(
        description="the value at each of them", examples=[["0 MPa", "10 MPa"]]
    )


class VolumeInTime(InTime):
    """A volume in time."""

    value: tuple[CrackVolume, ...] = Field(
        description="the value at each of them", examples=[["0 m^3", "0.2 m^3"]]
    )


StressValue = Given[Stress, StressInTime]
VolumeValue = Given[CrackVolume, VolumeInTime]


def _stress(words: str) -> Any:
    return Field(default=None, description=words, examples=STRESS_EXAMPLES)


class Prestress(CaseTable):
    """The components of a stress, tension positive; what is left out is none."""

    xx: StressInSpace | None = _stress("along x")
    yy: StressInSpace | None = _stress("along y")
    zz: StressInSpace | None = _stress("along z; in 2-D with plane strain only")
    yz: StressInSpace | None = _stress("shear, 3-D only")
    xz: StressInSpace | None = _stress("shear, 3-D only")
    xy: StressInSpace | None = _stress("shear")


def _traction(axis: str) -> Any:
    return Field(
        default=None, description=f"force per area along {axis}", examples=IN_TIME_EXAMPLES
    )


class SideForce(CaseTable):
    """Force per area on a side: a pressure, or components along the axes."""

    pressure: StressValue | None = Field(
        default=None, description="pressure, positive where it presses", examples=IN_TIME_EXAMPLES
    )
    x: StressValue | None = _traction("x")
    y: StressValue | None = _traction("y")
    z: StressValue | None = _traction("z")


def _side(words: str) -> Any:
    return Field(default=None, description=words, examples=[{"pressure": "10 MPa"}, {"x": "2 MPa"}])


class ForceKeys(SidesTable):
    """Forces on the body, besides thermal stress. Stresses count positive in tension, pressures
    where they press. The forces at t = 0, with prestress and weight, are in equilibrium before the
    first step; they may not crack the rock by themselves. On a side acts { pressure =
    "10 MPa" }, or a force per area like { x = "2 MPa" }; the faces of a mesh or a shape go by their
    names. Values of sides and of cracks may be a table in time { t = [...], value = [...] } or a
    { formula = "..." }."""

    __pydantic_extra__: dict[str, SideForce]

    prestress: Prestress | None = Field(
        default=None,
        description="stress of the undeformed body before cooling, what its pores carry included; "
        "each component a value, one with a gradient, or a formula of x, y (and z)",
        examples=[
            {"xx": "-20 MPa", "yy": {"value": "-30 MPa", "gradient": ["0 MPa/m", "0.03 MPa/m"]}}
        ],
    )
    gravity: tuple[Acceleration, ...] | None = Field(
        default=None,
        description="acceleration, acts on material.rho",
        examples=[["0 m/s^2", "-9.81 m/s^2"]],
    )
    left: SideForce | None = _side("side x = 0")
    right: SideForce | None = _side("side x = width")
    bottom: SideForce | None = _side("lower side")
    top: SideForce | None = _side("upper side")
    front: SideForce | None = _side("side y = 0, 3-D only")
    back: SideForce | None = _side("side y = depth, 3-D only")
    pore_pressure: StressInSpace | None = Field(
        default=None,
        description="pressure in the pores, in plane strain or 3-D: likewise; a formula of it may "
        "depend on t too, and its pressure at t = 0 is part of the prestress",
        examples=["10 MPa", {"value": "10 MPa", "gradient": ["0 MPa/m", "-0.01 MPa/m"]}],
    )
    biot: Annotated[Number, Field(ge=0, le=1)] | None = Field(
        default=None,
        description="Biot's coefficient: the part of the pore pressure that counts; default 1",
        examples=[0.8],
    )
    crack_pressure: StressValue | None = Field(
        default=None,
        description="pressure of a fluid in all cracks; its formula may depend on x, y (and z) too",
        examples=IN_TIME_EXAMPLES,
    )
    crack_volume: VolumeValue | None = Field(
        default=None,
        description="or what a fluid in them takes up, its pressure being found: in 2-D per "
        "thickness",
        examples=[{"t": ["0 s", "10 min"], "value": ["0 m^3", "0.2 m^3"]}, {"formula": "1e-4*t"}],
    )

    def by_side(self) -> dict[str, SideForce]:
        """Return the force on each face that has one, by its name."""
        named = (*SIDES[3], *(self.model_extra or {}))
        return {name: self.on(name) for name in named if self.on(name) is not None}
