"""Energy against tau of two bodies, minimized in three ways; a picture and a table."""

import matplotlib.pyplot as plt
import numpy as np

from staffa.io.run_directory import Run
from verification.common.figures import Check, Figure, Found
from verification.common.runs import READY, ROOT, fresh_run
from verification.common.symmetric_cracks import TWO_CRACKS, even_bands

WAYS = {
    "alone": ("solver.stability=none",),
    "with backtracking": ("solver.backtracking=true", "solver.stability=none"),
    "with stability": ("solver.stability=follow",),
}
# The slab is cooled little more than what starts damage: its first crack is late, and then long.
BODIES = {
    "slab": (
        READY / "slab.toml",
        "domain.size=[3.0,1.0]",
        "domain.h=0.02",
        "damage.ell=0.06",
        "temperature.severity=3.2",
        "temperature.profile=slab",
        "supports.section=fixed",
        "time.tau={start=0.04,stop=0.8,steps=39}",
        "output.at=[0.4]",
    ),
    "pair": (TWO_CRACKS, even_bands(), "time.tau={start=0.08,stop=0.12,steps=21}"),
}
# Which way has something to gain: a jump that is late, and a state that is even.
PARTS = {"slab": "with backtracking", "pair": "with stability"}
TITLES = {"slab": "slab, dT/dT_c = 1.28", "pair": "two cracks of an array, alike"}
PICTURE = ROOT / "docs" / "pictures" / "verify-energies.png"
# Energies that differ by less than this are those of one state, within what minimization leaves.
SAME = 1e-4


def totals(run: Run) -> np.ndarray:
    """Total energy of each step that stands."""
    return np.array([step.energies.total for step in run.steps])


def energies() -> Found:
    """The step at which the two runs part, the lower one there, and its later course."""
    figures, text, runs = [], [], {}
    for body, (case, *settings) in BODIES.items():
        runs[body] = {
            way: fresh_run(case, f"energies-{body}-{way.split()[-1]}", *settings, *more)
            for way, more in WAYS.items()
        }
        for way in tuple(WAYS)[1:]:
            name = f"{TITLES[body]}, {way}"
            expected = PARTS[body] == way
            found = parted(runs[body][way], runs[body]["alone"], name, expected)
            figures += found[0]
            text.append(found[1])
        text.append(table(TITLES[body], runs[body]))
    draw(runs)
    text.append(f"![Energy against tau, minimized in three ways](pictures/{PICTURE.name})")
    return Found(figures=figures, text="\n\n".join(text))


def parted(run: Run, alone: Run, name: str, expected: bool) -> tuple[list[Figure], str]:
    """The rise of the energy where a way first differs, which must be a fall; and in words."""
    change = totals(run) / totals(alone) - 1
    apart = np.flatnonzero(np.abs(change) > SAME)
    if not len(apart):
        missed = Figure(
            what=f"rise over that alone where it first differs: {name}",
            source="it must differ somewhere",
            reference=0.0,
            measured=float("nan"),
            tolerance=0.0,
        )
        said = f"{name}: the same states as by alternate minimization alone."
        return [missed] if expected else [], said
    first, tau = int(apart[0]), [step.tau or 0.0 for step in run.steps]
    figure = Figure(
        what=f"rise over that alone where it first differs, tau = {tau[first]:.3f}: {name}",
        source="no rise",
        reference=0.0,
        measured=float(change[first]),
        tolerance=0.0,
        bound="most",
    )
    returns = sum(step.returned is not None for step in (*run.steps, *run.superseded))
    escapes = sum(step.stability.escapes for step in run.steps if step.stability)
    higher = [f"{t:.3f}" for t, c in zip(tau, change, strict=True) if c > SAME]
    return [figure], (
        f"{name}: it first differs at tau = {tau[first]:.3f}, by {100 * change[first]:.2f} %; "
        f"most at {tau[int(change.argmin())]:.3f}, by {100 * change.min():.2f} %; higher at "
        f"{', '.join(higher) or 'no time'}. Returns: {returns}; left along a mode: {escapes} times."
    )


def table(title: str, runs: dict[str, Run]) -> str:
    """Energy and number of cracks, step by step."""
    lines = [f"| {title}, tau | " + " | ".join(runs) + " |", "| --- |" + " --- |" * len(runs)]
    for steps in zip(*(run.steps for run in runs.values()), strict=True):
        cells = [
            f"{s.energies.total:.5f} ({len(s.measures.tips) if s.measures else 0})" for s in steps
        ]
        lines.append(f"| {steps[0].tau:.3f} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def draw(runs: dict[str, dict[str, Run]]) -> None:
    """Energies, and what each way gains on the first, against tau."""
    figure, axes = plt.subplots(2, len(runs), figsize=(10, 6), sharex="col")
    for (body, ways), column in zip(runs.items(), axes.T, strict=True):
        base = totals(ways["alone"])
        for (way, run), marker in zip(ways.items(), ("o", "s", "x"), strict=True):
            tau = [step.tau for step in run.steps]
            style = {"marker": marker, "markersize": 4, "fillstyle": "none", "linewidth": 1}
            column[0].plot(tau, totals(run), label=way, **style)
            column[1].plot(tau, 100 * (totals(run) / base - 1), **style)
        column[0].set_title(TITLES[body], fontsize=11)
        column[1].set_xlabel("tau")
    axes[0, 0].set_ylabel("total energy")
    axes[1, 0].set_ylabel("over that alone (%)")
    axes[0, 0].legend(frameon=False)
    figure.savefig(PICTURE, dpi=120, bbox_inches="tight")


CHECKS = {
    "energies": Check(
        title="Energy against tau, minimized in three ways",
        text=(
            "Two bodies: a slab cooled little beyond the onset of damage, where the first crack "
            "jumps to a finite length, and two equal cracks of an array. Where a method first "
            "differs from alternate minimization alone, its energy must be lower."
        ),
        measure=energies,
    ),
}
