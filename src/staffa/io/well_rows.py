"""Rows of production.csv: the numbers of each well at each step, with cracks and without."""

from collections.abc import Iterator, Sequence
from math import nan
from typing import NamedTuple

from staffa.io.production_rows import Production, production
from staffa.records.reservoir_facts import ReservoirFacts
from staffa.records.step import Step


class WellRow(NamedTuple):
    """Well at the end of a step, by docs/how-to/circulation.md; a number is NaN without one."""

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
    T_without: float = nan
    pressure_without: float = nan
    power_without: float = nan
    heat_without: float = nan
    drawdown_without: float = nan
    impedance_without: float = nan
    injectivity_without: float = nan
    area_without: float = nan
    crack_area: float = nan
    crack_volume: float = nan


WITHOUT = tuple(name for name in WellRow._fields if name.endswith("_without"))


def well_rows(facts: ReservoirFacts | None, steps: Sequence[Step]) -> list[WellRow]:
    """Return a row for each step and well; none without a reservoir.

    Parameters
    ----------
    facts : the reservoir of the run.
    steps : kept steps of the run.
    """
    shadow = {found.step: found for found in production(facts, steps, cracks=False)}
    return [
        row for found in production(facts, steps) for row in _rows(found, shadow.get(found.step))
    ]


def _rows(p: Production, without: Production | None) -> Iterator[WellRow]:
    cracks = {"crack_area": p.cracks.area, "crack_volume": p.cracks.volume} if p.cracks else {}
    for name in p.now.wells:
        bare = _numbers(without, name) if without and name in without.now.wells else {}
        told = {key: bare[key.removesuffix("_without")] for key in WITHOUT} if bare else {}
        yield WellRow(step=p.step, time=p.time, well=name, **_numbers(p, name), **told, **cracks)


def _numbers(p: Production, name: str) -> dict[str, float]:
    """Return the numbers of a well by their columns."""
    well = p.now.wells[name]
    return {
        "rate": p.rate_at(name),
        "T": well.T,
        "pressure": well.pressure,
        "power": p.power,
        "heat": p.heat,
        "drawdown": p.drawdown_at(name),
        "recovered": p.recovered,
        "impedance": p.impedance_at(name),
        "injectivity": p.injectivity_at(name),
        "area": p.area_at(name),
        "lost": p.lost,
        "balance": p.balance,
    }
