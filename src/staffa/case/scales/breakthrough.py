"""Thermal breakthrough in closed form: when a share of the drop arrives at the producer."""

from dataclasses import dataclass
from math import pi, sin, tan

import numpy as np
import scipy

from staffa.case.schema.case import Case
from staffa.case.schema.reservoir_keys import WaterKeys, WellKeys
from staffa.case.values.diffusion_time import diffusivity, heat_capacity
from staffa.case.values.property_functions import in_space
from staffa.case.values.reservoir_places import fractured_sides, reservoir_keys, thickness

# Of IAPWS water at 60 to 200 °C and 10 to 40 MPa, within 10 %: rho (kg/m^3) and c (J/(kg K)).
RHO, C = 950.0, 4250.0
DRAWDOWNS = (0.01, 0.1)


@dataclass(frozen=True, kw_only=True)
class Doublet:
    """An injector of known rate and a producer.

    Attributes
    ----------
    injector, producer : the wells.
    rate : mass rate (kg/s); in 2-D per thickness (kg/(s m)).
    distance : distance between them (m).
    """

    injector: WellKeys
    producer: WellKeys
    rate: float
    distance: float


def doublet(case: Case) -> Doublet | None:
    """Return the two wells of a case; None with others, or where the rate is not known."""
    given = reservoir_keys(case).wells
    injectors = [well for well in given if well.injects]
    producers = [well for well in given if not well.injects]
    if len(injectors) != 1 or len(producers) != 1:
        return None
    rates = [well.rate for well in (*injectors, *producers) if well.rate is not None]
    if not rates:
        return None
    (injector,), (producer,) = injectors, producers
    apart = np.array(injector.at, dtype=float) - np.array(producer.at, dtype=float)
    across = thickness(case) if case.dim == 2 else 1.0
    return Doublet(
        injector=injector,
        producer=producer,
        rate=abs(float(rates[0])) / across,
        distance=float(np.linalg.norm(apart)),
    )


def water_heat(case: Case) -> tuple[float, float]:
    """Return density (kg/m^3) and specific heat capacity (J/(kg K)) of the water, about."""
    keys = reservoir_keys(case).water
    return (float(keys.rho), float(keys.c)) if isinstance(keys, WaterKeys) else (RHO, C)


def breakthrough(case: Case) -> tuple[tuple[float, ...], str] | None:
    """Return the times (s) of DRAWDOWNS at the producer, and the closed form that tells them.

    None where none applies.
    """
    wells, keys = doublet(case), reservoir_keys(case)
    if wells is None or case.dim != 2:
        return None
    if len(fractured_sides(case)) == 1 and len(keys.fractures) == 1:
        told = "one fracture between conducting walls (Lauwerier 1955), up to when they are felt"
        return tuple(_of_fracture(case, wells, share) for share in DRAWDOWNS), told
    if keys.fractures or keys.boxes:
        return None
    told = "two wells in an even, unbounded layer, without conduction (Gringarten and Sauty 1975)"
    return tuple(_of_layer(case, wells, share) for share in DRAWDOWNS), told


def _of_fracture(case: Case, wells: Doublet, share: float) -> float:
    """Return t of share = erfc(k z/(2 c q sqrt(kappa t))), q: mass rate along one wall.

    The wall takes all heat of the half of the flow that the case has: c q dT/dz = k dT/dn.
    """
    _, c = water_heat(case)
    kappa = diffusivity(case)
    k = kappa * heat_capacity(case)
    reach = k * wells.distance / (2 * c * wells.rate * float(scipy.special.erfcinv(share)))
    return reach**2 / kappa


def _of_layer(case: Case, wells: Doublet, share: float) -> float:
    """Return t = pi D^2 s/(c q) (1 - phi cot phi)/sin^2 phi, phi = pi share: the streamline that
    leaves the injector at this angle arrives, and all below it have."""
    rho, c = water_heat(case)
    x = case.outline.places.within()
    porosity = x.mean(in_space(reservoir_keys(case).porosity, case.dim)(x.x))
    stored = porosity * rho * c + (1 - porosity) * heat_capacity(case)
    phi = pi * share
    angle = (1 - phi / tan(phi)) / sin(phi) ** 2
    return pi * wells.distance**2 * stored / (c * wells.rate) * angle
