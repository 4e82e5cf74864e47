"""Given cracks beside a fracture and between two wells: what they do to the production.

make verify ONLY=imposed-cracks needs open-DARTS (`make reservoir`), and takes minutes.
"""

from collections.abc import Sequence

import numpy as np

from staffa.reservoir.interpreter import simulator_python
from staffa.reservoir.permeability import CELLS, Plane
from support.imposed_cracks import (
    ALONG,
    IN_ONE_CELL,
    Produced,
    across,
    channel,
    dead_ends,
    network,
    plan_view,
    produced,
    wall,
)
from support.reservoirs import DAY, YEAR
from verification.common.figures import Check, Figure, Found

DAYS, YEARS = (5.0, 20.0, 40.0, 60.0), tuple(np.arange(1.0, 21.0).tolist())
SHOWN = (5.0, 10.0, 15.0, 20.0)  # years in the table
BREAKTHROUGH = 186.0 + 273.15  # K: a drawdown of 10 %
SIGN = "sign, and part of the size that was expected"
NO_DROP = "no pressure differs along them"
ENDS, NETWORK = "dead ends of {} mm", "network of {} mm"
FINE = ALONG / 2


def walls() -> dict[str, Produced]:
    """Production beside a fracture, by what is in its wall."""
    bare, fine = "no cracks", "no cracks, cells of half the length"
    given: dict[str, tuple[float, Sequence[Plane], float | None]] = {
        bare: (ALONG, [], None),
        ENDS.format(1) + ", each in one row of cells": (ALONG, dead_ends(1e-3), IN_ONE_CELL),
        **{ENDS.format(mm): (ALONG, dead_ends(mm / 1e3), None) for mm in (0.1, 0.3, 1)},
        **{
            f"leaning by 15 degrees: {mm} mm": (ALONG, dead_ends(mm / 1e3, 15.0), None)
            for mm in (0.1, 0.3, 1)
        },
        **{NETWORK.format(mm): (ALONG, network(mm / 1e3), None) for mm in (0.1, 0.3, 1)},
        fine: (FINE, [], None),
        ENDS.format(0.3) + ", half the spread": (FINE, dead_ends(3e-4), CELLS * FINE),
    }
    times, python = [t * DAY for t in DAYS], simulator_python()
    return {
        name: produced(wall(along), cracks, times, python, spread)
        for name, (along, cracks, spread) in given.items()
    }


def plans() -> dict[str, Produced]:
    """Production of two wells, by the crack that is between them."""
    given = {"no crack": [], "from well to well": channel(), "across, at the injector": across()}
    times, python = [t * YEAR for t in YEARS], simulator_python()
    return {name: produced(plan_view(), cracks, times, python) for name, cracks in given.items()}


def beside(found: dict[str, Produced], name: str) -> Produced:
    """The production without cracks on the same cells."""
    bare = [other for other in found if other.startswith("no crack")]
    return found[bare[-1] if "half" in name else bare[0]]


def year_of_breakthrough(one: Produced) -> float:
    """The end of the first year in which the drawdown is above 0.1."""
    return YEARS[int(np.argmax(one.T < BREAKTHROUGH))]


def table(found: dict[str, Produced], times: Sequence[float], shown: Sequence[float]) -> str:
    """Production temperature, its difference to that without cracks, and pressure."""
    unit = "d" if times is DAYS else "y"
    heads = [f"{t:g} {unit}" for t in shown]
    lines = [
        f"| cracks | {' | '.join(heads)} | pressure difference |",
        "| --- |" + " --- |" * (len(heads) + 1),
    ]
    at = [list(times).index(t) for t in shown]
    for name, one in found.items():
        gains = one.T - beside(found, name).T
        cells = [f"{one.T[i] - 273.15:.2f} ({gains[i]:+.3f})" for i in at]
        lines.append(f"| {name} | {' | '.join(cells)} | {one.drop:.4g} Pa |")
    return "\n".join(lines)


def bound(what: str, value: float, reference: float, side: str, source: str = SIGN) -> Figure:
    """A number that has to be beyond another one."""
    assert side in ("least", "most")
    return Figure(
        what=what, source=source, reference=reference, measured=float(value), tolerance=0.0,
        bound="least" if side == "least" else "most",
    )  # fmt: skip


def figures(near: dict[str, Produced], plan: dict[str, Produced]) -> list[Figure]:
    """Return the signs that must hold, and part of their sizes."""
    gains = {name: one.T - beside(near, name).T for name, one in near.items()}
    none, through, line = plan.values()
    ten = YEARS.index(10.0)
    ends = [name for name in near if name.startswith("dead ends")]
    return [
        *(
            bound(f"{name}: largest change (K)", np.abs(gains[name]).max(), 0.01, "most", NO_DROP)
            for name in ends
        ),
        bound("network of 0.3 mm: gain at 60 d (K)", gains[NETWORK.format(0.3)][-1], 3.0, "least"),
        bound(
            "from well to well: year of breakthrough", year_of_breakthrough(through),
            year_of_breakthrough(none) - 1.0, "most",
        ),
        bound(
            "from well to well: pressure difference (Pa)", through.drop, none.drop, "most",
            "that without it",
        ),
        bound("across, at the injector: gain at 10 y (K)", (line.T - none.T)[ten], 1.0, "least"),
    ]  # fmt: skip


def imposed_cracks() -> Found:
    """The signs, and two tables."""
    near, plan = walls(), plans()
    text = (
        "Production temperature in °C, and in brackets what the cracks change (K). Beside a "
        f"fracture:\n\n{table(near, DAYS, DAYS)}\n\nTwo wells in a plan view:\n\n"
        f"{table(plan, YEARS, SHOWN)}\n\nA drawdown of 10 %, by the end of year: "
        + ", ".join(f"{name} {year_of_breakthrough(one):g}" for name, one in plan.items())
        + "."
    )
    return Found(figures=figures(near, plan), text=text)


CHECKS = {
    "imposed-cracks": Check(
        title="Cracks that are given, and the production",
        text=(
            "A fracture of 1 mm, 60 m long, beside tight rock of 200 °C; 0.01 kg/s of water of "
            "60 °C flow in half of it, in a layer of 1 m. Cracks go 8 m into the wall, every 5 m: "
            "dead ends, and the same with cracks along the flow that connect them. Their "
            "permeability is spread over 2.25 cells of 0.5 m, along the crack, where "
            "nothing else is said. And a plan view: a layer of 50 mD, 50 m thick, two wells 300 m "
            "apart, 5 kg/s, and one crack of 0.3 mm. The figures of dead ends tell how much the "
            "spreading alone lets through."
        ),
        measure=imposed_cracks,
    ),
}
