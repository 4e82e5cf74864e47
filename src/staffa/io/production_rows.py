"""Production of a run: the water of each step, with cracks and without, in SI units."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import inf, nan, sqrt
from statistics import NormalDist

from staffa.records.circulation import Circulation, WellAccount
from staffa.records.crack_flow import CrackFlow
from staffa.records.reservoir_facts import ReservoirFacts
from staffa.records.step import Step

# Drawdown at which cold water has come; below it the error of a simulator decides the area.
BREAKTHROUGH = 0.01
LATE = 0.1  # drawdown that is felt
COOLER = 10.0  # K


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
    injected, produced : mass that wells brought into the rock, and took out, since the start (kg).
    stored : heat that the reservoir gained since the start (J).
    """

    step: int
    time: float
    facts: ReservoirFacts
    now: Circulation
    elapsed: float
    heat: float
    injected: float
    produced: float
    stored: float

    @property
    def lost(self) -> float:
        """Mass injected and not produced since the start (kg)."""
        return self.injected - self.produced

    @property
    def cracks(self) -> CrackFlow | None:
        """Cracks that the water flows in; None where they do not change the flow."""
        return self.now.cracks

    @property
    def power(self) -> float:
        """Heat that the surface gets above that of the injected water, mean over the step (W)."""
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
        return _mean(self.producers, lambda name, well: well.T)

    @property
    def fall(self) -> float:
        """Temperature of the rock at the producers before the first step, minus T (K)."""
        return _mean(self.producers, lambda name, well: self.fall_at(name))

    @property
    def drawdown(self) -> float:
        """Drawdown of the produced water, mixed."""
        return _mean(self.producers, lambda name, well: self.drawdown_at(name))

    @property
    def pressure(self) -> float:
        """Highest pressure in a well (Pa)."""
        return max((well.pressure for well in self.now.wells.values()), default=nan)

    @property
    def area(self) -> float:
        """Exchange area of all producers (m^2)."""
        return sum(self.area_at(name) for name in self.producers) if self.producers else nan

    @property
    def drop(self) -> float:
        """Pressure of the injectors minus that of the producers, means by mass (Pa)."""
        return self._injection_pressure - _mean(self.producers, lambda n, well: well.pressure)

    @property
    def impedance(self) -> float:
        """Drop of pressure from injectors to producers over the rate of the latter (Pa s/kg)."""
        rate = -sum(self.rate_at(name) for name in self.producers)
        return self.drop / rate if rate else nan

    @property
    def injectivity(self) -> float:
        """Injectivity of all injectors (kg/(s Pa))."""
        return sum(map(self.injectivity_at, self.injectors)) if self.injectors else nan

    @property
    def _injection_pressure(self) -> float:
        return _mean(self.injectors, lambda name, well: well.pressure)

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
        return (self._injection_pressure - self.now.wells[name].pressure) / -self.rate_at(name)

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


def production(
    facts: ReservoirFacts | None, steps: Sequence[Step], *, cracks: bool = True
) -> list[Production]:
    """Return the water of each step in which it flows; none without a reservoir.

    Parameters
    ----------
    facts : the reservoir of the run.
    steps : kept steps of the run.
    cracks : False for the shadow: the same water without what cooling does to cracks.
    """
    found: list[Production] = []
    elapsed = heat = injected = produced = stored = 0.0
    for step in steps:
        if facts is None or step.heat is None:
            continue
        now = step.heat.circulation if cracks else step.heat.shadow
        if now is None or not now.duration > 0:
            continue
        elapsed += now.duration
        heat -= sum(well.heat for well in now.wells.values())
        injected += sum(max(well.mass, 0.0) for well in now.wells.values())
        produced -= sum(min(well.mass, 0.0) for well in now.wells.values())
        stored += now.heat_stored
        found.append(
            Production(
                step=step.index, time=step.time, facts=facts, now=now, elapsed=elapsed, heat=heat,
                injected=injected, produced=produced, stored=stored,
            )
        )  # fmt: skip
    return found


def paired_production(
    facts: ReservoirFacts | None, steps: Sequence[Step]
) -> list[tuple[Production, Production]]:
    """Return the water of each step that has a shadow: with cracks, and without.

    Parameters
    ----------
    facts : the reservoir of the run.
    steps : kept steps of the run.
    """
    shadow = {found.step: found for found in production(facts, steps, cracks=False)}
    found = production(facts, steps)
    return [(one, shadow[one.step]) for one in found if one.step in shadow]


def _mean(wells: dict[str, WellAccount], value: Callable[[str, WellAccount], float]) -> float:
    """Return the mean of a value of wells by their mass; NaN without a well."""
    mass = sum(well.mass for well in wells.values())
    return (
        sum(well.mass * value(name, well) for name, well in wells.items()) / mass if mass else nan
    )


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
