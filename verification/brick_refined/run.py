"""Columns in a small block on a mesh that follows the cracks, beside a uniform one: kept.

    python -m verification.brick_refined.run

runs both on one rank (some ten minutes), and keeps what `make verify ONLY=brick-refined` looks at.
"""

import json
from pathlib import Path

from staffa.io.run_directory import Run, open_run
from verification.common.figures import Check, Figure, Found
from verification.common.runs import ROOT, Cost, keep, origin, run_with_cost

CASE = "src/staffa/case/ready/brick.toml"
KEPT = Path(__file__).parent / "kept.json"
RUNS = ROOT / "runs" / "verification" / "brick_refined"
SMALL = [
    "domain.size=[1.5,1.5,1.0]",
    "domain.h=0.0416667",  # edges of the cubes, 24 to the depth; ell/3.4
    "domain.cells=tetrahedron",
    "time.tau={start=0.12,stop=0.52,steps=11}",
    "output.at=[0.52]",
]
MEMBERS = {"uniform": SMALL, "refined": [*SMALL, "domain.refine=true"]}
UNIFORM_CELLS = 36 * 36 * 24 * 6


def run_members() -> dict:
    """Run both afresh, and keep their numbers."""
    kept = {}
    for name, asked in MEMBERS.items():
        cost = run_with_cost(ROOT / CASE, RUNS / name, asked)
        kept[name] = digest(name, open_run(RUNS / name), cost)
    keep(KEPT, kept)
    return kept


def digest(name: str, run: Run, cost: Cost) -> dict:
    """The numbers that are kept of a run."""
    taken = [(step, step.measures) for step in run.steps]
    return origin(run, CASE, MEMBERS[name]) | {
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
    kept = json.loads(KEPT.read_text()) if KEPT.exists() else run_members()
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
        for depth, there, here in zip(
            (0.2, 0.3, 0.4), other["cells"][k], one["cells"][k], strict=False
        ):
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
    lines = [
        "| | mesh cells, first step | last step | sweeps | CPU (s) | GiB |",
        "|" + " --- |" * 6,
    ]
    for name, k in kept.items():
        mesh = f"{k['mesh'][0]} | {k['mesh'][-1]}"
        lines.append(f"| {name} | {mesh} | {sum(k['sweeps'])} | {k['cpu']} | {k['memory']:.2f} |")
    return Found(figures=figures, text="\n".join(lines))


CHECKS = {
    "brick-refined": Check(
        title="Columns on a mesh that follows the cracks",
        text=(
            "The ready case `brick`, 1.5 x 1.5 x 1, resolved (ell = 3.4 h), on tetrahedra, up to "
            "tau = 0.52: with `domain.refine = true` and without. Tolerances: 0.5 % of the "
            "energy, 5 % of the area of the cracks (from the surface energy), the same cells."
        ),
        measure=beside_uniform,
        kept="kept.json",
    ),
}


if __name__ == "__main__":
    run_members()
