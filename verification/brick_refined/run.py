"""Columns on a mesh that follows the cracks: a small block, beside a uniform mesh, and a wide one.

    python -m verification.brick_refined.run [wide]

runs the small ones afresh on one rank (ten minutes), or the wide one on two (an hour and more), and
keeps what `make verify ONLY=brick-refined` looks at.
"""

import json
import sys
from pathlib import Path

from staffa.io.run_directory import Run, open_run
from verification.common.figures import Check, Figure, Found
from verification.common.runs import ROOT, Cost, keep, origin, run_with_cost

CASE = "src/staffa/case/ready/brick.toml"
KEPT = Path(__file__).parent / "kept.json"
RUNS = ROOT / "runs" / "verification" / "brick_refined"
SMALL = [
    "damage.ell=0.14",
    "domain.size=[1.5,1.5,1.0]",
    "domain.h=0.0416667",  # edges of the cubes, 24 to the depth; ell/3.4
    "domain.cells=tetrahedron",
    "time.tau={start=0.12,stop=0.52,steps=11}",
    "output.at=[0.52]",
]
MEMBERS = {"uniform": SMALL, "refined": [*SMALL, 'domain.refine={coarsest="4 h"}']}
UNIFORM_CELLS = 36 * 36 * 24 * 6
WIDE = [
    "domain.size=[5.0,5.0,1.0]",
    "damage.ell=0.14",
    "domain.h=0.0466667",  # ell/3
    "domain.cells=tetrahedron",
    'domain.refine={coarsest="4 h"}',
]
DEPTHS = (0.2, 0.3, 0.4, 0.5, 0.6)  # of the case
MINUTES = 25  # asked for, on two cores


def run_members() -> None:
    """Run both small ones afresh, and keep their numbers."""
    kept = json.loads(KEPT.read_text())
    for name, asked in MEMBERS.items():
        cost = run_with_cost(ROOT / CASE, RUNS / name, asked)
        kept[name] = digest(name, open_run(RUNS / name), cost)
    keep(KEPT, kept)


def run_wide() -> None:
    """Run the wide one afresh on two ranks, and keep its numbers."""
    cost = run_with_cost(ROOT / CASE, RUNS / "wide", WIDE, ranks=2)
    keep(KEPT, json.loads(KEPT.read_text()) | {"wide": wide(open_run(RUNS / "wide"), cost.cpu)})


def wide(run: Run, cpu: float) -> dict:
    """The numbers that are kept of the wide run, with the CPU time of both ranks (s)."""
    taken = [step.measures for step in run.steps if step.measures]
    return origin(run, CASE, WIDE) | {
        "ell": run.manifest.ell,
        "cpu": round(cpu),
        "asked": len(run.manifest.times),
        "tau": [step.tau for step in run.steps],
        "totals": [step.energies.total for step in run.steps],
        "sweeps": [step.sweeps for step in run.steps],
        "mesh": [step.mesh.cells for step in run.steps if step.mesh],
        "cells": [[len(section.areas) for section in m.cells] for m in taken],
    }


def digest(name: str, run: Run, cost: Cost) -> dict:
    """The numbers that are kept of a run."""
    taken = [(step, step.measures) for step in run.steps]
    return origin(run, CASE, MEMBERS[name]) | {
        "ell": run.manifest.ell,
        "cpu": round(cost.cpu),
        "memory": round(cost.memory, 3),
        "tau": [step.tau for step, _ in taken],
        "totals": [step.energies.total for step, _ in taken],
        "sweeps": [step.sweeps for step, _ in taken],
        "mesh": [step.mesh.cells if step.mesh else UNIFORM_CELLS for step, _ in taken],
        "cells": [[len(s.areas) for s in m.cells] for _, m in taken if m],
        "areas": [m.length_surface for _, m in taken if m],
    }


def beside_uniform() -> Found:
    """Energy, crack area and cells at each step, beside those of the uniform mesh."""
    kept = json.loads(KEPT.read_text())
    one, other = kept["refined"], kept["uniform"]
    figures = []
    for k, tau in enumerate(other["tau"]):
        at = f"at tau = {tau:.2f}"
        pairs = (("totals", f"total energy {at}", 5e-3), ("areas", f"crack area {at}", 0.05))
        for key, what, tolerance in pairs:
            figures.append(
                Figure(
                    what=what,
                    source="uniform tetrahedra",
                    reference=other[key][k],
                    measured=one[key][k],
                    tolerance=tolerance,
                    relative=True,
                )
            )
        for depth, there, here in zip(DEPTHS[:3], other["cells"][k], one["cells"][k], strict=False):
            if there > 1 or here > 1:
                figures.append(
                    Figure(
                        what=f"cells at depth {depth:g} {at}",
                        source="uniform tetrahedra",
                        reference=there,
                        measured=here,
                        tolerance=0.0,
                    )
                )
    block = kept["wide"]
    steps = f"{len(block['tau'])} of {block['asked']} steps"
    figures.append(
        Figure(
            what="5 x 5 x 1, ell = 0.14, h = ell/3: minutes of CPU time of each of two ranks, "
            f"{steps}",
            source="asked for",
            reference=MINUTES,
            measured=round(block["cpu"] / 2 / 60, 1),
            tolerance=0.0,
            bound="most",
        )
    )
    lines = [
        "| | mesh cells, first step | last step | sweeps | CPU (s) | GiB |",
        "|" + " --- |" * 6,
    ]
    for name in MEMBERS:
        k = kept[name]
        mesh = f"{k['mesh'][0]} | {k['mesh'][-1]}"
        lines.append(f"| {name} | {mesh} | {sum(k['sweeps'])} | {k['cpu']} | {k['memory']:.2f} |")
    mesh = f"{block['mesh'][0]} | {block['mesh'][-1]}"
    lines.append(f"| 5 x 5 x 1 | {mesh} | {sum(block['sweeps'])} | {block['cpu']} | |")
    numbers = ", ".join(
        f"{number} at {d:g}" for d, number in zip(DEPTHS, block["cells"][-1], strict=True)
    )
    said = f"Cells of the block of 5 x 5 x 1 by depth at tau = {block['tau'][-1]:.2f}: {numbers}."
    return Found(figures=figures, text="\n".join([*lines, "", said]))


CHECKS = {
    "brick-refined": Check(
        title="Columns on a mesh that follows the cracks",
        text=(
            "The ready case `brick`, 1.5 x 1.5 x 1, resolved (ell = 3.4 h), on tetrahedra, up to "
            'tau = 0.52: with `domain.refine.coarsest = "4 h"` and without. Tolerances: 0.5 % of '
            "the energy, 5 % of the area of the cracks (from the surface energy), the same cells. "
            "Then the time of a wide block, on two ranks beside other work: ranks that wait for "
            "each other count as CPU time, so a quiet machine takes less."
        ),
        measure=beside_uniform,
        kept="kept.json",
    ),
}


if __name__ == "__main__":
    run_wide() if sys.argv[1:] == ["wide"] else run_members()
