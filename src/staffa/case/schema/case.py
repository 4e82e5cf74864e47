"""The case file as typed, frozen models: every key, its meaning, its rule, and its default."""

from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from staffa.case.schema.boxes import Box
from staffa.case.schema.checkpoint_keys import CheckpointKeys
from staffa.case.schema.cooling_keys import RESERVOIR, TemperatureKeys
from staffa.case.schema.domain_keys import DomainKeys
from staffa.case.schema.field_types import (
    Author,
    CaseTable,
    Flag,
    Instant,
    Integer,
    Length,
    License,
    Line,
    Number,
    Position,
    PositiveNumber,
    Strength,
    one_of,
)
from staffa.case.schema.force_keys import ForceKeys
from staffa.case.schema.heat_keys import HeatKeys
from staffa.case.schema.material_keys import MaterialKeys, RegionKeys
from staffa.case.schema.probe_keys import ProbeKeys
from staffa.case.schema.reservoir_keys import ReservoirKeys
from staffa.case.schema.support_keys import Prescribed as Prescribed
from staffa.case.schema.support_keys import SupportKeys as SupportKeys
from staffa.case.schema.time_keys import TimeKeys
from staffa.case.schema.tolerances import Better, Change, Residual
from staffa.evolution.output_fields import DEFAULT, FIELDS, NEEDED
from staffa.geometry.outline import Outline
from staffa.physics.damage import KNOWN, SOFTENING
from staffa.physics.split import SPLITS
from staffa.records.step import Stop


class DamageKeys(CaseTable):
    """Model of damage: law, split and regularization length."""

    law: Annotated[str, one_of(KNOWN)] = Field(
        default="AT1",
        description="AT1: elastic up to a strength that ell gives; AT2: the paper's, no threshold; "
        "cohesive: elastic up to damage.strength, whatever ell",
    )
    strength: Strength | None = Field(
        default=None,
        description="cohesive only, needed there: tension that a bar bears without a split",
        examples=["10 MPa"],
    )
    biaxial: Strength | None = Field(
        default=None,
        description="cohesive only: two equal tensions that rock bears; default: by damage.split",
        examples=["9 MPa"],
    )
    compressive: Strength | None = Field(
        default=None,
        description="cohesive only: pressure that a bar of rock bears; default: by damage.split",
        examples=["120 MPa"],
    )
    softening: Annotated[str, one_of(SOFTENING)] | None = Field(
        default=None,
        description="cohesive only: stress over opening; default linear; cornelissen: concrete",
        examples=["linear"],
    )
    split: Annotated[str, one_of(SPLITS)] | None = Field(
        default=None,
        description="how much of its stiffness a crack keeps when it is pressed shut: "
        f"{', '.join(SPLITS)}. Default: none where only cooling acts; no-tension (of anisotropic "
        "rock volumetric-deviatoric) where something may press the rock: [forces], moved sides, "
        "heating, a formula of the temperature, rock that expands unevenly; strength-surface with "
        "damage.biaxial or damage.compressive",
        examples=["no-tension"],
    )
    gamma: Annotated[Number, Field(ge=0)] | None = Field(
        default=None,
        description="star-convex only: what it adds to the bulk modulus against compaction; "
        "default 5",
        examples=[5.0],
    )
    friction: Annotated[Number, Field(ge=0, le=10)] | None = Field(
        default=None,
        description="contact only: Coulomb's coefficient of friction between the faces of cracks; "
        "default 0",
        examples=[0.6],
    )
    ell: Length = Field(
        description="regularization length; AT2: twice the paper's epsilon", examples=[0.03]
    )
    irreversibility: Literal["damage", "crack set"] = Field(
        default="damage",
        description="what cannot heal: all damage, or only the crack set (the paper's choice)",
    )
    crack_set_threshold: Annotated[Number, Field(gt=0, le=1)] = Field(
        default=0.95, description="damage from which a point belongs to the crack set"
    )
    residual_stiffness: Annotated[Number, Field(gt=0, lt=0.1)] = Field(
        default=1e-6, description="fraction of the stiffness left in a crack"
    )
    allow_coarse: Flag = Field(
        default=False, description="run although ell < h, where the mesh steers the cracks"
    )


class Band(Box):
    """A part of the body whose toughness differs."""

    factor: PositiveNumber = Field(description="its toughness over material.Gc", examples=[3.0])


class ToughnessKeys(CaseTable):
    """Heterogeneity of the toughness, a function of position alone."""

    amplitude: Annotated[Number, Field(ge=0, lt=1)] = Field(
        default=0.0, description="coefficient of variation of a seeded random field; 0: uniform"
    )
    correlation_length: Length | None = Field(
        default=None, description="length over which it varies; default 2 ell", examples=[0.06]
    )
    seed: Annotated[Integer, Field(ge=0, lt=2**32)] = Field(
        default=0, description="of the random numbers: the same seed, the same rock"
    )
    bands: tuple[Band, ...] = Field(
        default=(),
        max_length=100,  # they cut the body into boxes, in 3-D by the cube of their number
        description="at most 100 boxes of other toughness, like a raised band on the cooled edge",
        examples=[[{"lower": [0.0, 0.0], "upper": [5.0, 0.02], "factor": 3.0}]],
    )


class Segment(CaseTable):
    """A straight crack of a 2-D body."""

    start: tuple[Position, ...] = Field(description="one end", examples=[[0.5, 0.0]])
    end: tuple[Position, ...] = Field(description="the other end", examples=[[0.5, 0.1]])


class Disc(CaseTable):
    """A flat round crack of a 3-D body."""

    center: tuple[Position, ...] = Field(
        description="middle of the disc", examples=[[0.5, 0.5, 0.0]]
    )
    radius: Length = Field(description="radius of the disc", examples=[0.1])
    normal: tuple[Number, ...] = Field(
        description="a direction across the disc, of any length", examples=[[1.0, 0.0, 0.0]]
    )


class Named(CaseTable):
    """A crack that the mesh has."""

    name: str = Field(
        description="in place of these: the name that it has in the mesh", examples=["fault"]
    )


def _shape(value: Any) -> str | None:
    """Return the kind of a crack, by its keys."""
    if isinstance(value, dict):
        if "name" in value:
            return "a named one"
        return "a disc" if {"center", "radius", "normal"} & set(value) else "a segment"
    if isinstance(value, Segment | Disc | Named):
        return {Segment: "a segment", Disc: "a disc", Named: "a named one"}[type(value)]
    return None


Crack = Annotated[
    Annotated[Segment, Tag("a segment")]
    | Annotated[Disc, Tag("a disc")]
    | Annotated[Named, Tag("a named one")],
    Discriminator(_shape),
]


class OutputKeys(CaseTable):
    """Output of a run: kept fields, checkpoints and probes."""

    at: tuple[Instant, ...] = Field(
        default=(),
        description="times hit exactly, whose fields are kept and drawn; tau or t, as in [time]",
        examples=[[0.1, 0.2, 0.4]],
    )
    steps: Literal["requested", "all"] = Field(
        default="requested",
        description="keep the fields of the requested times and the last step, or of all",
    )
    fields: tuple[Annotated[str, one_of(FIELDS)], ...] = Field(
        default=DEFAULT,
        description=f"which fields are kept for ParaView: of {', '.join(FIELDS)}; "
        f"{' and '.join(NEEDED)} always; see docs/reference/files.md",
        examples=[["u", "alpha", "T", "stress", "energy_density"]],
    )
    checkpoint: CheckpointKeys = Field(
        default=CheckpointKeys(),
        description="when the run is saved for `staffa resume`: after this many steps, and after "
        "a step at whose end this many minutes have gone; see docs/how-to/restarts.md",
        examples=[{"steps": 10, "minutes": 30.0}],
    )
    probes: tuple[ProbeKeys, ...] = Field(
        default=(),
        description="where T, u and damage are read off at every step, into probes.csv: a point, "
        "or a line of equally spaced points from start to end",
        examples=[
            [
                {"name": "well", "point": [0.5, 0.5]},
                {"name": "axis", "start": [0.5, 0.0], "end": [0.5, 1.0], "points": 50},
            ]
        ],
    )


class MeasureKeys(CaseTable):
    """Measurement of the cracks."""

    depths: tuple[Length, ...] = Field(
        default=(),
        description="depths below the cooled face at which cracks are counted (2-D), or the "
        "cells that they cut out (3-D)",
        examples=[[0.1, 0.2, 0.3]],
    )
    threshold: Annotated[Number, Field(gt=0, lt=1)] = Field(
        default=0.8, description="damage above which a point counts as cracked"
    )


class SolverKeys(CaseTable):
    """Minimization of the energy."""

    displacement: Literal["auto", "direct", "iterative"] = Field(
        default="auto",
        description="direct (default in 2-D, and of a small 3-D body with a split), or iterative: "
        "CG with multigrid (3-D default)",
    )
    damage: Literal["tao", "snes"] = Field(
        default="tao",
        description="bound-constrained solver, tao or snes; the other is the fall-back",
    )
    acceleration: Literal["newton", "none"] = Field(
        default="newton",
        description="what each sweep is followed by: a Newton move, or none (plain alternation)",
    )
    guess: Literal["coarser", "none"] = Field(
        default="coarser",
        description="first guess: from a coarser mesh where new loads overwhelm the state (2-D, "
        "ell of 6 h at least), or with domain.refine a try of the step on coarser cells; or none",
    )
    stability: Literal["test", "report", "follow", "none"] = Field(
        default="test",
        description="second-order test of each step: a cheap search for a descent direction, "
        "which is followed; report: exact values, for several factorizations; follow: these, "
        "and unstable states are left; or none (default with damage.friction)",
    )
    backtracking: Flag = Field(
        default=False,
        description="try each step's damage at earlier times, and go back where it is better",
    )
    backtracking_tolerance: Better = Field(
        default=1e-4,
        description="better: lower by this fraction of the energy at least, 0.1 at most",
    )
    change: Change = Field(
        default=Stop.change,
        description="a step ends when a sweep changes the damage by less than this, 0.01 at most",
    )
    residual: Residual = Field(
        default=Stop.residual,
        description="and no force on the damage exceeds this times Gc/(4 c_w ell), the force that "
        "starts a crack; 0.9 at most",
    )
    sweeps: Annotated[Integer, Field(ge=1)] = Field(
        default=Stop.sweeps, description="give up a step after this many sweeps"
    )


class Case(CaseTable):
    """A whole case file."""

    title: Line = Field(default="", description="a line for tables and pictures")
    authors: tuple[Author, ...] = Field(
        default=(),
        description="who made the case, for the research object that a run is "
        "(docs/reference/files.md): names, with an ORCID or a mail address or without",
        examples=[["Ada Lovelace <https://orcid.org/0000-0002-1825-0097>"]],
    )
    license: License = Field(
        default="",
        description="terms of use of the results: an identifier of spdx.org, like CC-BY-4.0, or an "
        "address",
        examples=["CC-BY-4.0"],
    )
    domain: DomainKeys
    material: MaterialKeys = MaterialKeys()
    regions: dict[str, RegionKeys] = Field(
        default_factory=dict,
        description="parts of the body whose rock differs, each a table [regions.NAME]",
        examples=[{"clay": {"lower": [0.0, 0.5], "upper": [5.0, 0.7], "E": 0.5}}],
    )
    damage: DamageKeys
    toughness: ToughnessKeys = ToughnessKeys()
    temperature: TemperatureKeys = TemperatureKeys()
    heat: HeatKeys | None = None
    reservoir: ReservoirKeys | None = None
    forces: ForceKeys | None = None
    supports: SupportKeys = SupportKeys()
    cracks: tuple[Crack, ...] = Field(
        default=(),
        description="cracks that are there from the start, each broken over a layer of cells: "
        "start and end (2-D), or center, radius and normal (3-D), or the name it has in the mesh",
        examples=[[{"start": [0.5, 0.0], "end": [0.5, 0.1]}]],
    )
    time: TimeKeys
    output: OutputKeys = OutputKeys()
    measures: MeasureKeys = MeasureKeys()
    solver: SolverKeys = SolverKeys()

    @property
    def outline(self) -> Outline:
        """Return the body from outside."""
        return self.domain.outline

    @property
    def dim(self) -> int:
        """Return the dimension, 2 or 3."""
        return self.outline.dim

    @property
    def conducts(self) -> bool:
        """Return True if the temperature follows from conductivity and heat capacity, k, rho, c."""
        return self.temperature.profile in ("heat", RESERVOIR)

    @property
    def axial(self) -> bool:
        """Return True if the body is one of revolution, given by its section."""
        return self.domain.symmetry == "axis"

    @property
    def plane_stress(self) -> bool:
        """Return True if the strain across a 2-D body is free."""
        return self.dim == 2 and not self.axial and self.material.plane != "strain"

    @property
    def extents(self) -> int:
        """Return the number of extents of a volume: 2 where it is one per thickness, else 3."""
        return 3 if self.axial else self.dim
