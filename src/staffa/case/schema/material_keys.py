"""The tables [material] and [regions.NAME]: what the rock is, as keys."""

from typing import Annotated, Any, Literal

from pydantic import Field

from staffa.case.schema.field_types import (
    ONE,
    Angle,
    CaseTable,
    Conductivity,
    Diffusivity,
    Direction,
    Expansion,
    Number,
    Position,
    Stress,
    Toughness,
)
from staffa.case.schema.property_keys import OneOrMore
from staffa.case.schema.temperature_keys import (
    ConductivityValue,
    DensityValue,
    ExpansionValue,
    HeatCapacityValue,
    ModulusValue,
    RatioValue,
    ToughnessValue,
)
from staffa.units import EXAMPLES

Moduli = OneOrMore[ModulusValue, ModulusValue]
Ratio = RatioValue[Number]
Ratios = OneOrMore[RatioValue[Annotated[Number, Field(gt=-1, le=0.5)]], Ratio]

RANDOM_E = {"mean": "70 GPa", "variation": 0.2, "length": "5 mm", "seed": 1}
# Which keys say how stiff the rock is, and which along what: a region takes each group as a whole.
ELASTIC = ("E", "nu", "G", "E_axis", "nu_axis", "G_axis", "stiffness")
RATIOS = ("nu", "nu_axis")
ORIENTATION = ("axis", "angle", "axes")


class RockKeys(CaseTable):
    """Properties of rock, of the body and of its regions."""

    E: Moduli | None = Field(
        default=None,
        description="Young's modulus; of an orthotropic rock E1, E2, E3 along its axes",
        examples=["70 GPa", ["60 GPa", "30 GPa", "60 GPa"], RANDOM_E],
    )
    nu: Ratios | None = Field(
        default=None,
        description="Poisson's ratio; of an orthotropic rock nu12, nu23, nu13 (nu12: contraction "
        "along 2 in a pull along 1)",
        examples=[0.2, [0.2, 0.1, 0.2], {"formula": "0.2 + 0.01*y"}],
    )
    G: Moduli | None = Field(
        default=None,
        description="shear moduli G12, G23, G13 of an orthotropic rock; with one list each of E, "
        "nu and G",
        examples=[["15 GPa", "10 GPa", "25 GPa"]],
    )
    E_axis: ModulusValue | None = Field(
        default=None,
        description="Young's modulus across the bedding of a transversely isotropic rock, whose E "
        "and nu are those in the plane of the bedding",
        examples=["30 GPa"],
    )
    nu_axis: Ratio | None = Field(
        default=None,
        description="its Poisson's ratio: contraction along the bedding in a pull across it",
        examples=[0.1],
    )
    G_axis: ModulusValue | None = Field(
        default=None,
        description="its shear modulus between the bedding and the direction across it",
        examples=["15 GPa"],
    )
    stiffness: tuple[tuple[Stress, ...], ...] | None = Field(
        default=None,
        description="any elasticity, in place of E and nu: six rows of six numbers, in the order "
        "11, 22, 33, 23, 13, 12 of stress and of strain (shear doubled) along the rock's axes",
        examples=[
            [
                [1.2, 0.4, 0.4, 0.0, 0.0, 0.0],
                [0.4, 1.2, 0.4, 0.0, 0.0, 0.0],
                [0.4, 0.4, 0.8, 0.0, 0.0, 0.0],
                [0.0, 0.0, 0.0, 0.3, 0.0, 0.0],
                [0.0, 0.0, 0.0, 0.0, 0.3, 0.0],
                [0.0, 0.0, 0.0, 0.0, 0.0, 0.4],
            ]
        ],
    )
    axis: Direction | None = Field(
        default=None,
        description="direction across the bedding; lists of expansion, k and Gc then have two "
        "numbers, along the bedding and across it",
        examples=[[0.0, 1.0]],
    )
    angle: Angle | None = Field(
        default=None,
        description="2-D only: from x to the rock's first axis, in degrees, for lists of E, nu, G, "
        "expansion, k and Gc, and for stiffness; x, y, z are its axes where nothing is said",
        examples=[30.0],
    )
    axes: tuple[Direction, ...] | None = Field(
        default=None,
        description="3-D only: the rock's first two axes, perpendicular; the third follows",
        examples=[[[1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]],
    )
    Gc: OneOrMore[ToughnessValue, Toughness] | None = Field(
        default=None,
        description="toughness, energy per area of crack; a list: of cracks across each of the "
        "rock's axes",
        examples=["10 J/m^2", ["20 J/m^2", "10 J/m^2"], {"formula": "10 + 2*y"}],
    )
    expansion: OneOrMore[ExpansionValue, Expansion] | None = Field(
        default=None,
        description="thermal expansion coefficient (linear); a list: along the rock's axes",
        examples=["9e-6 1/K", ["9e-6 1/K", "6e-6 1/K"]],
    )
    k: OneOrMore[ConductivityValue, Conductivity] | None = Field(
        default=None,
        description="thermal conductivity, with the heat equation or a reservoir; a list: along x, "
        "y (and z in 3-D), or along the rock's axes if it has others",
        examples=[EXAMPLES["conductivity"], ["2.5 W/(m K)", "2 W/(m K)"]],
    )
    rho: DensityValue | None = Field(
        default=None,
        description="density, with the heat equation, a reservoir or gravity",
        examples=[EXAMPLES["density"]],
    )
    c: HeatCapacityValue | None = Field(
        default=None,
        description="specific heat capacity, with the heat equation or a reservoir",
        examples=[EXAMPLES["heat capacity"]],
    )


def _again(name: str, default: Any) -> Any:
    """Return the same key with another default."""
    known = RockKeys.model_fields[name]
    return Field(default=default, description=known.description, examples=known.examples)


class MaterialKeys(RockKeys):
    """The rock. A number may also be a formula of position like { formula = "1 + 0.5*y" }, in SI
    units or scaled as the case is; a random field like { mean = 1.0, variation = 0.2, length = 0.1
    } with distribution (lognormal, normal or weibull), angle or axes, and seed; or a field in a
    file like { file = "rock.vtu", name = "E" }."""

    E: Moduli | None = _again("E", ONE)
    nu: Ratios | None = _again("nu", 0.2)
    Gc: OneOrMore[ToughnessValue, Toughness] | None = _again("Gc", ONE)
    expansion: OneOrMore[ExpansionValue, Expansion] | None = _again("expansion", ONE)
    plane: Literal["stress", "strain"] | None = Field(
        default=None, description="2-D only: plane stress (default) or strain", examples=["stress"]
    )
    kappa: Diffusivity | None = Field(
        default=None,
        description='thermal diffusivity; with temperature.profile = "heat" or "reservoir" it is '
        "k/(rho c)",
        examples=[EXAMPLES["diffusivity"]],
    )


class RegionKeys(RockKeys):
    """A part of the body whose rock differs: a box of a block, under any name, or a region that a
    shape or a mesh names. Keys that are left out are as in [material]: the elasticity as a whole,
    but E and nu singly if no other key of it is given, and the directions as a whole. Where boxes
    overlap, the last one counts."""

    lower: tuple[Position, ...] | None = Field(
        default=None, description="lower corner of its box, in a block", examples=[[0.0, 0.0]]
    )
    upper: tuple[Position, ...] | None = Field(
        default=None, description="upper corner of its box, in a block", examples=[[5.0, 0.2]]
    )


def rock_of(body: MaterialKeys, region: RegionKeys) -> MaterialKeys:
    """Return the rock of a region: its own keys, and the body's for the others.

    The stiffness and the axes are each taken over as a whole or not at all; E and nu of an
    isotropic body one by one.
    """
    own = {name: getattr(region, name) for name in RockKeys.model_fields}
    own = {name: value for name, value in own.items() if value is not None}
    update = dict(own)
    groups = (
        (ORIENTATION,) if is_isotropic(body) and is_isotropic(region) else (ORIENTATION, ELASTIC)
    )
    for group in groups:
        if set(group) & set(own):
            update |= {name: own.get(name) for name in group}
    return body.model_copy(update=update)


def is_isotropic(rock: RockKeys) -> bool:
    """Return whether E and nu alone give the stiffness."""
    others = any(getattr(rock, name) is not None for name in ELASTIC if name not in ("E", "nu"))
    return not (others or isinstance(rock.E, tuple) or isinstance(rock.nu, tuple))
