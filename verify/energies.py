"""Energy against tau of a small slab, minimized in three ways; a picture and a table."""

import matplotlib.pyplot as plt
import numpy as np
from figures import Figure, Found
from runs import ROOT, ready_case

from staffa.io.run_directory import Run

WAYS = {
    "alternate minimization alone": (),
    "with backtracking": ("solver.backtracking=true",),
    "with stability": ("solver.stability=follow",),
}
BODY = ("domain.size=[1.0,1.0]",)
PICTURE = ROOT / "docs" / "pictures" / "verify-energies.png"
# Energies that differ by less than this are those of one state, within what minimization leaves.
SAME = 1e-5


def totals(run: Run) -> np.ndarray:
    """Total energy of each step that stands."""
    return np.array([step.energies.total for step in run.steps])


def energies() -> Found:
    """Where the ways part, which is lower there, and what becomes of it."""
    runs = {
        way: ready_case("slab", f"energies-{way.split()[-1]}", *BODY, *s) for way, s in WAYS.items()
    }
    alone, *others = runs
    tau = [step.tau for step in runs[alone].steps]
    base = totals(runs[alone])
    figures = []
    for way in others:
        change = totals(runs[way]) / base - 1
        apart = np.flatnonzero(np.abs(change) > SAME)
        if len(apart):
            first = int(apart[0])
            figures.append(
                Figure(
                    what=f"rise where it first differs (tau = {tau[first]:.2f}), {way}",
                    source="lower",
                    reference=0.0,
                    measured=max(0.0, float(change[first])),
                    tolerance=0.0,
                )
            )
    draw(runs)
    return Found(figures=figures, text=f"{table(runs)}\n\n![energies](pictures/{PICTURE.name})")


def table(runs: dict[str, Run]) -> str:
    """Energy, cracks and escapes or returns, step by step."""
    lines = ["| tau | " + " | ".join(runs) + " |", "| --- |" + " --- |" * len(runs)]
    for steps in zip(*(run.steps for run in runs.values()), strict=True):
        cells = [
            f"{s.energies.total:.5f}, {len(s.measures.tips) if s.measures else 0} cracks"
            for s in steps
        ]
        lines.append(f"| {steps[0].tau:.2f} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def draw(runs: dict[str, Run]) -> None:
    """Energies, and what each way gains on the first, against tau."""
    figure, (above, below) = plt.subplots(2, 1, figsize=(7, 6), sharex=True)
    first = totals(next(iter(runs.values())))
    for (way, run), marker in zip(runs.items(), "osd", strict=True):
        tau = [step.tau for step in run.steps]
        above.plot(tau, totals(run), marker=marker, markersize=3, label=way)
        below.plot(tau, 100 * (totals(run) / first - 1), marker=marker, markersize=3)
    above.set_ylabel("total energy")
    above.legend(frameon=False)
    below.set_ylabel("over the first (%)")
    below.set_xlabel("tau")
    figure.savefig(PICTURE, dpi=120, bbox_inches="tight")
