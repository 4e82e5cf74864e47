"""Effect of cracks on the produced energy, on finer cells and steps; kept as one small file.

    python -m verification.doublet_cracks.run

runs the ready case `doublet-cracks` as it is and with one change at a time (an hour on one core),
and keeps the numbers that `make verify ONLY=doublet-cracks` looks at. Runs that are in
runs/verification/doublet_cracks are taken as they are.
"""

import json
from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt

from staffa.case.reading.ready_cases import ready_case
from staffa.io.production_rows import paired_production
from staffa.io.run_directory import Run
from verification.common.figures import Check, Figure, Found
from verification.common.runs import ROOT, keep, origin, run_once

NAME = "doublet-cracks"
CASE = f"src/staffa/case/ready/{NAME}.toml"
KEPT = Path(__file__).parent / "kept.json"
PICTURE = ROOT / "docs" / "pictures" / "verify-doublet-cracks.png"
AS_GIVEN = "as given"
DAY = 86400.0  # s
ZERO_CELSIUS = 273.15  # K
COLUMNS = ("days", "T", "T_without", "heat", "heat_without", "crack_area")


def members() -> dict[str, list[str]]:
    """Settings of each run: the case as given, then one change at a time."""
    case = ready_case(NAME)
    assert case.reservoir is not None and case.reservoir.h is not None
    ends = [0.0, *(float(t) for t in case.time.t)]
    half_steps = [f"{t / DAY:g} days" for a, b in pairwise(ends) for t in ((a + b) / 2, b)]
    return {
        AS_GIVEN: [],
        "cells of the reservoir halved": [f"reservoir.h={float(case.reservoir.h) / 2:g} m"],
        "cells of the rock halved": [f"domain.h={float(case.domain.h) / 2:g} m"],
        "steps halved": [f"time.t={json.dumps(half_steps)}"],
        "largest opening doubled": [
            f"reservoir.openings.largest={2 * float(case.reservoir.openings.largest):g} m"
        ],
    }


def run_members() -> dict:
    """Run the members, or take those that are there, and keep their numbers."""
    kept = {}
    for name, settings in members().items():
        run = run_once(CASE, f"doublet_cracks/{name.replace(' ', '-')}", settings)
        kept[name] = origin(run, CASE, settings) | {"rows": rows(run)}
        keep(KEPT, kept)
    return kept


def rows(run: Run) -> list[list[float]]:
    """COLUMNS at the end of each step: production with cracks and without (°C, TJ), area (m²)."""
    assert not any(step.audit.violations for step in run.steps)
    found = []
    for water, bare in paired_production(run.manifest.reservoir, run.steps):
        assert water.cracks is not None
        T = (round(of.T - ZERO_CELSIUS, 2) for of in (water, bare))
        heat = (round(of.heat / 1e12, 5) for of in (water, bare))
        found.append([round(water.time / DAY, 3), *T, *heat, round(water.cracks.area)])
    return found


def last(found: dict) -> dict[str, float]:
    """The numbers of a member at the end, by their columns."""
    return dict(zip(COLUMNS, found["rows"][-1], strict=True))


def difference(found: dict) -> float:
    """Change of the produced energy by cracks (TJ)."""
    return last(found)["heat"] - last(found)["heat_without"]


def doublet_cracks() -> Found:
    """Change of the difference that cracks make, over the difference, for each member."""
    kept = json.loads(KEPT.read_text())
    given = difference(kept[AS_GIVEN])
    figures = [
        Figure(
            what=f"{name}: change of what cracks do to the produced energy, over the latter",
            source=f"less than a third; as given it is {given:+.3f} TJ",
            reference=1 / 3,
            measured=abs(difference(found) / given - 1),
            tolerance=0.0,
            bound="most",
        )
        for name, found in kept.items()
        if name != AS_GIVEN
    ]
    draw(kept)
    return Found(figures=figures, text=f"{table(kept)}\n\n![Production](pictures/{PICTURE.name})")


def table(kept: dict) -> str:
    """A row for each member, then the commands."""
    lines = [
        "| run | energy, TJ | without cracks, TJ | difference, TJ | difference, % | T at the end, "
        "°C | without cracks, °C | area of cracks, m² | s |",
        "|" + " --- |" * 9,
    ]
    for name, found in kept.items():
        end, change = last(found), difference(found)
        lines.append(
            f"| {name} | {end['heat']:.3f} | {end['heat_without']:.3f} | {change:+.3f} | "
            f"{100 * change / end['heat_without']:+.1f} | {end['T']:.1f} | {end['T_without']:.1f} "
            f"| {end['crack_area']:.0f} | {found['seconds']} |"
        )
    said = [f"`{k['command']}`, {k['date']}, commit {k['commit'][:7]}" for k in kept.values()]
    return "\n".join(lines) + "\n\n" + "\n\n".join(said)


def draw(kept: dict) -> None:
    """Temperature of production, and change of the energy by cracks, against time."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 3.8), layout="constrained")
    for number, (name, found) in enumerate(kept.items()):
        days, T, bare, heat, heat_bare, _ = zip(*found["rows"], strict=True)
        left.plot(days, T, f"C{number}-", label=name)
        left.plot(days, bare, f"C{number}--")
        right.plot(days, [a - b for a, b in zip(heat, heat_bare, strict=True)], f"C{number}-")
    left.set(xlabel="t, days", ylabel="temperature of production, °C", title="dashed: no cracks")
    right.set(xlabel="t, days", ylabel="TJ", title="energy with cracks less that without")
    left.legend(frameon=False, fontsize=9)
    figure.savefig(PICTURE, dpi=120)
    plt.close(figure)


CHECKS = {
    NAME: Check(
        title="Two wells, and cracks between them",
        text=(
            "The ready case `doublet-cracks`: four cracks between two wells in granite, which "
            "cooling opens and joins, so that water runs in cracks from well to well. The produced "
            "energy after 160 days with cracks, less that of the same water without what cooling "
            "does to them. One thing is changed at a time, at the same ell and the same spread of "
            "cracks over the cells."
        ),
        measure=doublet_cracks,
        kept="kept.json",
    ),
}


if __name__ == "__main__":
    print(json.dumps(run_members(), indent=1))
