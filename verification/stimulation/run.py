"""Energy of the ready case `stimulation` with cracks and without: two meshes, and what opens.

    python -m verification.stimulation.run

runs the members (up to an hour each on one core), and keeps what `make verify ONLY=stimulation`
looks at. Those that are in runs/verification/stimulation, by hand on more ranks say, are taken as
they are.
"""

import json
from itertools import zip_longest
from pathlib import Path

from staffa.io.production_rows import paired_production
from staffa.io.run_directory import Run
from verification.common.figures import Check, Figure, Found
from verification.common.runs import keep, origin, run_once

CASE = "src/staffa/case/ready/stimulation.toml"
KEPT = Path(__file__).parent / "kept.json"
DAY = 86400.0  # s
# Settings of the members, and what is other than in the case.
MEMBERS = {
    "case": ((), "the ready case, which ends after 40 days: the steps of `longer` up to there"),
    "finer": (
        ('domain.h="0.34 m"', 'reservoir.h="0.6 m"'),
        "cells of rock and reservoir 3/4 as long, ell and spread as they are",
    ),
    "longer": (
        ('time.t=["4 days","8 days","15 days","25 days","40 days","60 days"]',),
        "20 days longer; a crack then reaches the top of the body",
    ),
}
SHARE = 1 / 3  # of the largest difference that cracks make, by which a refinement may change it


def run_members() -> dict:
    """Run the members, or take those that are there, and keep their production."""
    kept = {}
    for name, (settings, _) in MEMBERS.items():
        run = run_once(CASE, f"stimulation/{name}", settings)
        kept[name] = origin(run, CASE, settings) | digest(run)
    keep(KEPT, kept)
    return kept


def digest(run: Run) -> dict:
    """The numbers that are kept of a run: at each step with cracks and without."""
    rows = []
    steps = {step.index: step for step in run.steps}
    for one, other in paired_production(run.manifest.reservoir, run.steps):
        measures, cracks = steps[one.step].measures, one.cracks
        assert measures is not None and cracks is not None
        side = cracks.sides["bottom"]
        rows.append(
            {
                "days": round(one.time / DAY, 3),
                "T": [round(p.T, 3) for p in (one, other)],
                "heat": [round(p.heat / 1e9, 5) for p in (one, other)],
                "drop": [round(p.drop, 2) for p in (one, other)],
                "area": round(measures.length_surface, 3),
                "deepest": round(measures.front, 3),
                "water_area": round(cracks.area, 3),
                "water_volume": round(cracks.volume, 6),
                "at_largest": round(cracks.at_largest, 4),
                "plane": [round(1e3 * w, 4) for w in (side.narrowest, side.widest)],
                "plane_at_largest": round(side.at_largest, 4),
            }
        )
    return {"ranks": run.manifest.ranks, "ell": run.manifest.ell, "rows": rows}


def difference(row: dict) -> float:
    """Energy by a step with cracks less that without, over the latter."""
    one, other = row["heat"]
    return float(one / other - 1)


def warmth(row: dict) -> float:
    """Temperature of the water with cracks less that without at a step (K)."""
    one, other = row["T"]
    return float(one - other)


def stimulation() -> Found:
    """Differences that cracks make to energy and temperature, on a finer mesh and in the case."""
    kept = json.loads(KEPT.read_text()) if KEPT.exists() else run_members()
    pairs = list(zip(kept["case"]["rows"], kept["finer"]["rows"], strict=False))
    coldest = min(pairs, key=lambda pair: warmth(pair[0]))
    leanest = min(pairs, key=lambda pair: difference(pair[0]))
    compared = (
        ("energy so far, over that without", difference, leanest),
        ("energy so far, over that without", difference, pairs[-1]),
        ("temperature of the water (K)", warmth, coldest),
        ("temperature of the water (K)", warmth, pairs[-1]),
    )
    figures = [
        Figure(
            what=f"cells 3/4 as long, {row['days']:g} days: difference that cracks and the opening "
            f"plane make to the {what}",
            source="the ready case, to a third of the largest at any time",
            reference=number(row),
            measured=number(fine),
            tolerance=SHARE * max(abs(number(one)) for one, _ in pairs),
        )
        for what, number, (row, fine) in compared
    ]
    return Found(figures=figures, text="\n\n".join([members(kept), course(kept)]))


def members(kept: dict) -> str:
    """A table of the members at their ends."""
    head = (
        "| member | size | energy without | energy with | difference | T at the end | drop of "
        "pressure | cracks | deepest | widest opening of the plane | s | commit |\n|"
        + " --- |"
        * 12
    )
    lines = [head]
    for name, member in kept.items():
        last = member["rows"][-1]
        (heat, heat_without), (T, T_without) = last["heat"], last["T"]
        lines.append(
            f"| {name} | {member['unknowns']} unknowns | {heat_without:.2f} GJ | {heat:.2f} GJ | "
            f"{100 * difference(last):+.2f} % | {T - T_without:+.2f} K | "
            f"{last['drop'][0]:.0f} Pa for {last['drop'][1]:.0f} Pa | {last['area']:.1f} m² | "
            f"{last['deepest']:.1f} m | {last['plane'][1]:.1f} mm | {member['seconds']} on "
            f"{member['ranks']} | {member['commit'][:7]} |"
        )
    said = [f"- {name}: {MEMBERS[name][1]}; `{kept[name]['command'].strip()}`" for name in kept]
    return "\n".join([*lines, "", *said])


def course(kept: dict) -> str:
    """A table of the members against time."""
    lines = [
        "Temperature of the water with cracks, and without in the last column; K of each are those "
        "of the difference, of the same mesh:",
        "",
        f"| days | {' | '.join(kept)} | without, {next(iter(kept))} |",
        "| --- |" + " --- |" * (len(kept) + 1),
    ]
    for same in zip_longest(*(member["rows"] for member in kept.values())):
        told = [
            f"{row['T'][0] - 273.15:.1f} °C ({warmth(row):+.2f} K)" if row else "" for row in same
        ]
        known = next(row for row in same if row)
        without = f"{known['T'][1] - 273.15:.1f} °C"
        lines.append(f"| {known['days']:g} | {' | '.join(told)} | {without} |")
    return "\n".join(lines)


CHECKS = {
    "stimulation": Check(
        title="Columns beside a fracture plane, and the heat",
        text=(
            "A fracture plane between two wells, in 3-D; the water runs through the columns' "
            "cracks too. How much energy comes with them and without, and how much warmer or "
            "colder the water is, on two meshes. The differences hold what the plane's opening "
            "does as well. They are reported as they are."
        ),
        measure=stimulation,
        kept="kept.json",
    ),
}


if __name__ == "__main__":
    run_members()
