"""Production of a run: the water of each step, of all wells together and of each, in SI units."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf, nan, sqrt
from statistics import NormalDist
from typing import NamedTuple

from staffa.records.circulation import Circulation, WellAccount
from staffa.records.reservoir_facts import ReservoirFacts
from staffa.records.step import Step

# Drawdown at which cold water has come; below it the error of a simulator decides the area.
BREAKTHROUGH = 0.01
LATE = 0.1  # drawdown that is felt
COOLER = 10.0  # K


class WellRow(NamedTuple):
    """Well at the end of a step, as docs/circulation.md defines its numbers; NaN without one."""

    step: int
    time: float
    well: str
    rate: float
    T: float
    pressure: float
    power: float
    heat: float
    drawdown: float
    recovered: float
    impedance: float
    injectivity: float
    area: float
    lost: float
    balance: float


@dataclass(frozen=True, kw_only=True)
class Production:
    """Water of all wells in one step, and since the start; NaN for what is not known.

    Attributes
    ----------
    step : index of the step.
    time : its end (s).
    facts : the reservoir before the first step.
    now : account of the step.
    elapsed : time since the water flows (s).
    heat : heat that the surface got since the start, above that of the injected water (J).
    lost : mass injected and not produced since the start (kg).
    stored : heat that the reservoir gained since the start (J).
    """

    step: int
    time: float
    facts: ReservoirFacts
    now: Circulation
    elapsed: float
    heat: float
    lost: float
    stored: float

    @property
    def power(self) -> float:
        """Heat that the surface gets above that of the injected water, per time (W)."""
        return -sum(well.heat for well in self.now.wells.values()) / self.now.duration

    @property
    def recovered(self) -> float:
        """Heat over that of the body, as it cools to the injected water."""
        whole = self.facts.heat_in_place
        return self.heat / whole if whole else nan

    @property
    def balance(self) -> float:
        """Heat that wells brought since the start minus heat stored, over the latter."""
        return (-self.heat - self.stored) / self.stored if self.stored else nan

    @property
    def producers(self) -> dict[str, WellAccount]:
        """Wells that take water out in this step."""
        return {name: well for name, well in self.now.wells.items() if well.mass < 0}

    @property
    def injectors(self) -> dict[str, WellAccount]:
        """Wells that bring water into the rock in this step."""
        return {name: well for name, well in self.now.wells.items() if well.mass > 0}

    @property
    def T(self) -> float:
        """Temperature of the produced water, mixed (K)."""
        return _mean(self.producers, {name: well.T for name, well in self.producers.items()})

    @property
    def fall(self) -> float:
        """Temperature of the rock at the producers before the first step, minus T (K)."""
        return _mean(self.producers, {name: self.fall_at(name) for name in self.producers})

    @property
    def drawdown(self) -> float:
        """Drawdown of the produced water, mixed."""
        return _mean(self.producers, {name: self.drawdown_at(name) for name in self.producers})

    @property
    def pressure(self) -> float:
        """Highest pressure in a well (Pa)."""
        return max((well.pressure for well in self.now.wells.values()), default=nan)

    @property
    def area(self) -> float:
        """Exchange area of all producers (m^2)."""
        return sum(self.area_at(name) for name in self.producers) if self.producers else nan

    def rate_at(self, name: str) -> float:
        """Return the mean rate of a well into the rock (kg/s)."""
        return self.now.wells[name].mass / self.now.duration

    def fall_at(self, name: str) -> float:
        """Return the fall of a well's temperature from that of the rock there (K)."""
        known = self.facts.wells.get(name)
        return known.T_rock - self.now.wells[name].T if known else nan

    def drawdown_at(self, name: str) -> float:
        """Return the drawdown of a producer: its fall of temperature over the largest possible."""
        known, T_in = self.facts.wells.get(name), self.facts.T_injected
        if name not in self.producers or known is None or T_in is None or known.T_rock == T_in:
            return nan
        return self.fall_at(name) / (known.T_rock - T_in)

    def area_at(self, name: str) -> float:
        """Return the area of one wall of a fracture that would cool a producer's water so (m^2)."""
        rate = -self.rate_at(name) * (2 if self.facts.halved else 1)
        return exchange_area(self.facts, self.drawdown_at(name), rate, self.elapsed)

    def impedance_at(self, name: str) -> float:
        """Return the drop of pressure from the injectors to a producer, over its rate (Pa s/kg)."""
        if name not in self.producers:
            return nan
        pressures = {other: well.pressure for other, well in self.injectors.items()}
        drop = _mean(self.injectors, pressures) - self.now.wells[name].pressure
        return drop / -self.rate_at(name)

    def injectivity_at(self, name: str) -> float:
        """Return the rate of an injector over its pressure above the first one (kg/(s Pa))."""
        known = self.facts.wells.get(name)
        if name not in self.injectors or known is None:
            return nan
        rise = self.now.wells[name].pressure - known.p_rock
        return self.rate_at(name) / rise if rise > 0 else nan


def exchange_area(facts: ReservoirFacts, drawdown: float, rate: float, time: float) -> float:
    """Return the area of one wall of a single fracture that would cool its water so (m^2).

    erfcinv(drawdown) c rate sqrt(kappa t)/k: Lauwerier's formula, solved for the wall; NaN below
    the thermal breakthrough, and for a drawdown of 1 and more.

    Parameters
    ----------
    facts : the reservoir, with rock and water.
    drawdown : drawdown of the water.
    rate : mass rate of the whole fracture (kg/s).
    time : time since the water flows (s).
    """
    if not BREAKTHROUGH <= drawdown < 1:
        return nan
    erfcinv = -NormalDist().inv_cdf(drawdown / 2) / sqrt(2)
    reach = sqrt(facts.conductivity / facts.rho_c * time)
    return erfcinv * facts.water_c * rate * reach / facts.conductivity


def production(facts: ReservoirFacts | None, steps: Sequence[Step]) -> list[Production]:
    """Return the water of each step in which it flows; none without a reservoir.

    Parameters
    ----------
    facts : the reservoir of the run.
    steps : kept steps of the run.
    """
    found: list[Production] = []
    elapsed = heat = lost = stored = 0.0
    for step in steps:
        now = step.heat.circulation if step.heat else None
        if facts is None or now is None or not now.duration > 0:
            continue
        elapsed += now.duration
        heat -= sum(well.heat for well in now.wells.values())
        lost += sum(well.mass for well in now.wells.values())
        stored += now.heat_stored
        found.append(
            Production(
                step=step.index, time=step.time, facts=facts, now=now, elapsed=elapsed, heat=heat,
                lost=lost, stored=stored,
            )
        )  # fmt: skip
    return found


def well_rows(facts: ReservoirFacts | None, steps: Sequence[Step]) -> list[WellRow]:
    """Return a row for each step and well; none without a reservoir.

    Parameters
    ----------
    facts : the reservoir of the run.
    steps : kept steps of the run.
    """
    return [row for all_wells in production(facts, steps) for row in _rows(all_wells)]


def _rows(p: Production) -> Iterator[WellRow]:
    for name, well in p.now.wells.items():
        yield WellRow(
            step=p.step, time=p.time, well=name, rate=p.rate_at(name), T=well.T,
            pressure=well.pressure, power=p.power, heat=p.heat, drawdown=p.drawdown_at(name),
            recovered=p.recovered, impedance=p.impedance_at(name),
            injectivity=p.injectivity_at(name), area=p.area_at(name), lost=p.lost,
            balance=p.balance,
        )  # fmt: skip


def _mean(wells: dict[str, WellAccount], values: dict[str, float]) -> float:
    """Return the mean of values of wells by their mass; NaN without a well."""
    mass = sum(well.mass for well in wells.values())
    return sum(well.mass * values[name] for name, well in wells.items()) / mass if mass else nan


def first_time(found: Sequence[Production], values: Sequence[float], level: float) -> float:
    """Return the first time at which a value is above a level (s), linear between steps.

    Infinite if it never is. The value is 0 at the start; steps without one are passed over.

    Parameters
    ----------
    found : the production of the steps.
    values : a value of each.
    level : the level.
    """
    before = (found[0].time - found[0].now.duration, 0.0) if found else (0.0, 0.0)
    for one, value in zip(found, values, strict=True):
        if value > level:
            start, low = before
            return start + (one.time - start) * (level - low) / (value - low)
        if value <= level:  # NaN is neither
            before = (one.time, value)
    return inf
