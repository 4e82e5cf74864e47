"""Record of the reservoir of a run: its wells, rock and water before the first step."""

from dataclasses import dataclass, field


@dataclass(frozen=True, kw_only=True)
class WellFacts:
    """A well, and the rock around it before the first step.

    Attributes
    ----------
    at
        Position of the middle of its open part (m), shape (3,).
    T_rock
        Temperature of the rock there (K).
    p_rock
        Pressure of the water there (Pa).
    rate
        Given mass rate into the rock (kg/s), negative for production; None where the pressure is
        given.
    pressure
        Given pressure in the well (Pa); None where the rate is given.
    T
        Temperature of injected water (K); None for a producer.
    """

    at: tuple[float, ...]
    T_rock: float
    p_rock: float
    rate: float | None = None
    pressure: float | None = None
    T: float | None = None


@dataclass(frozen=True, kw_only=True)
class FractureFlow:
    """Flow along flat fractures in tight rock, whose production temperature has a closed form.

    Attributes
    ----------
    q
        Volume rate of the whole fracture per width (m^2/s).
    length
        Length of the fracture from inlet to outlet (m).
    half_spacing
        Half the distance between parallel fractures (m); None for a single fracture.
    stored
        Heat capacity of half of the fracture, per area (J/(m^2 K)).
    """

    q: float
    length: float
    half_spacing: float | None = None
    stored: float = 0.0


@dataclass(frozen=True, kw_only=True)
class CrackRule:
    """Rule by which cracks of the rock change the permeability of the reservoir's cells.

    Attributes
    ----------
    smallest
        Lower bound of the opening that water flows in (m).
    largest
        Upper bound of that opening (m).
    spread
        Radius over which cracks are spread (m).
    """

    smallest: float
    largest: float
    spread: float


@dataclass(frozen=True, kw_only=True)
class ReservoirFacts:
    """The reservoir of a run before the first step.

    Attributes
    ----------
    simulator
        Name and version of the simulator.
    thickness
        Thickness of the layer that a 2-D body lies in (m); None in 3-D.
    T
        Mean temperature of the body (K).
    T_injected
        Mean temperature of the injected water (K); None where no well injects water.
    pressure
        Mean pressure of the water in the body (Pa).
    conductivity
        Mean conductivity of the body with its water (W/(m K)).
    rho_c
        Mean heat capacity of the body with its water, per volume (J/(m^3 K)).
    water_rho
        Density of the water in closed forms (kg/m^3).
    water_c
        Specific heat of the water in closed forms (J/(kg K)).
    heat_in_place
        Heat that the body gives away as it cools to `T_injected` (J): rho c V (T - T_injected);
        None without that.
    halved
        True where a fracture along a side of the body is computed by halves: the water of the wells
        is then half of what flows in it.
    wells
        The wells by their names.
    flow
        Flow along fractures, where a closed form of the production temperature applies.
    edges
        Coordinates of the faces of the reservoir's cells along x, y and z (m).
    cracks
        Rule by which cracks change the flow; None where they do not.
    tolerance
        Error of a step of the simulator, over the drop from rock to injected water.
    """

    simulator: str
    thickness: float | None
    T: float
    T_injected: float | None
    pressure: float
    conductivity: float
    rho_c: float
    water_rho: float
    water_c: float
    heat_in_place: float | None
    halved: bool = False
    wells: dict[str, WellFacts] = field(default_factory=dict)
    flow: FractureFlow | None = None
    edges: tuple[tuple[float, ...], ...] = ()
    cracks: CrackRule | None = None
    tolerance: float = 1e-3
