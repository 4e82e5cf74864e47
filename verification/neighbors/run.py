"""Two cracks under cooling: one shields the other, attracts it, joins it; kept as one file.

    python -m verification.neighbors.run

runs the members (a minute each), draws the picture, and keeps what `make verify ONLY=neighbors`
looks at. Those that are in runs/verification/neighbors are taken as they are.
"""

import json
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from staffa.io.run_directory import Run
from staffa.plot.cracks import DAMAGE
from staffa.records.step import Step
from verification.common.figures import Check, Figure, Found
from verification.common.raster import Raster, raster
from verification.common.runs import ROOT, keep, origin, run_once

CASE = "verification/neighbors/case.toml"
KEPT = Path(__file__).parent / "kept.json"
PICTURE = ROOT / "docs" / "pictures" / "verify-neighbors.png"
ELL = 0.03  # as in the case
H = 0.01
# Cracks of each: (x, from y, to y).
PAIRS = {
    "alone": ((0.25, 0.0, 0.15),),
    "shield": ((0.125, 0.0, 0.15), (0.375, 0.0, 0.12)),
    "attract": ((0.18, 0.0, 0.15), (0.32, 0.35, 0.6)),
    "join": ((0.25, 0.0, 0.15), (0.25, 0.35, 0.6)),
}


def settings(name: str) -> list[str]:
    """The cracks of a member, as the case has them."""
    cracks = (f"{{start=[{x},{low}],end=[{x},{high}]}}" for x, low, high in PAIRS[name])
    return [f"cracks=[{','.join(cracks)}]"]


def run_members() -> dict:
    """Run the members, or take those that are there; draw them, and keep what became of them."""
    runs = {name: run_once(CASE, f"neighbors/{name}", settings(name)) for name in PAIRS}
    draw(runs)
    kept = {
        name: origin(run, CASE, settings(name)) | {"steps": history(name, run)}
        for name, run in runs.items()
    }
    keep(KEPT, kept)
    return kept


def history(name: str, run: Run) -> list[dict]:
    """At each step the highest point of each crack that was given, and whether two are one."""
    return [{"tau": step.tau} | look(name, raster(run, step)) for step in run.steps]


def look(name: str, found: Raster) -> dict:
    """The record of one step in `history`."""
    cracks, tips, which = found.cracks(), [], []
    for x, low, _ in PAIRS[name]:
        away = [np.hypot(*(crack - [x, low]).T).min() for crack in cracks]
        which.append(int(np.argmin(away)))
        crack = cracks[which[-1]]
        top = crack[crack[:, 1] == crack[:, 1].max()].mean(axis=0)
        tips.append([round(float(c), 4) for c in top])
    return {"tips": tips, "one": len(set(which)) < len(which)}


def draw(runs: dict[str, Run]) -> None:
    """Each at the first step, before two meet or half way, and at the end."""
    figure, axes = plt.subplots(3, len(runs), figsize=(8, 10), layout="constrained")
    for column, (name, run) in zip(axes.T, runs.items(), strict=True):
        for panel, step in zip(column, chosen(name, run), strict=True):
            found = raster(run, step)
            panel.pcolormesh(
                found.x, found.y, found.alpha, cmap=DAMAGE, vmin=0, vmax=1, shading="gouraud"
            )
            panel.set_aspect("equal")
            panel.set_title(f"{name}, tau = {step.tau:.2f}", fontsize=10)
            panel.set(xticks=(0, 0.25, 0.5))
    figure.savefig(PICTURE, dpi=110)
    plt.close(figure)


def chosen(name: str, run: Run) -> tuple[Step, Step, Step]:
    """The steps that are drawn."""
    two = [step for step in run.steps if not look(name, raster(run, step))["one"]]
    between = two[-1] if len(two) < len(run.steps) else two[len(two) // 2]
    return run.steps[0], between, run.steps[-1]


def neighbors() -> Found:
    """The expected course of each pair, beside the crack that is alone."""
    kept = json.loads(KEPT.read_text())
    steps = {name: k["steps"] for name, k in kept.items()}
    meet = {name: next((s["tau"] for s in steps[name] if s["one"]), np.inf) for name in PAIRS}
    before = [s for s in steps["attract"] if not s["one"]][-1]
    start, other = (crack[0] for crack in PAIRS["attract"])
    end = {name: np.array(steps[name][-1]["tips"]) for name in ("alone", "shield")}
    (_, _, longer), (_, _, shorter) = PAIRS["shield"]
    joined = next(k for k, s in enumerate(steps["join"]) if s["one"])
    alone = steps["alone"][joined]["tips"][0][1]
    gap_over = PAIRS["join"][1][1]
    figures = [
        Figure(
            what="alone: how far the tip is off its line at the end",
            source="it goes straight on; tolerance: h",
            reference=0.0,
            measured=abs(end["alone"][0, 0] - PAIRS["alone"][0][0]),
            tolerance=H,
        ),
        Figure(
            what="shield: growth of the shorter crack",
            source="none; tolerance: ell",
            reference=0.0,
            measured=end["shield"][1, 1] - shorter,
            tolerance=ELL,
        ),
        Figure(
            what="shield: growth of the longer crack",
            source="to beyond a spacing of them; tolerance: up to the opposite boundary",
            reference=(1.0 - longer + 0.25) / 2,
            measured=end["shield"][0, 1] - longer,
            tolerance=(1.0 - longer - 0.25) / 2,
        ),
        Figure(
            what="attract: how far the tip has turned to the other, last step before they meet",
            source="some of the way there, more than h",
            reference=(other - start + H) / 2,
            measured=before["tips"][0][0] - start,
            tolerance=(other - start - H) / 2,
        ),
        Figure(
            what="attract and join: pairs that are one crack in the end",
            source="both",
            reference=2,
            measured=sum(steps[name][-1]["one"] for name in ("attract", "join")),
            tolerance=0,
        ),
        Figure(
            what="join: depth of the crack that is alone, when the other has reached its neighbor",
            source=f"less than the neighbor's {gap_over:g}, which it is drawn to",
            reference=gap_over / 2,
            measured=alone,
            tolerance=gap_over / 2 - H,
        ),
    ]
    words = "; ".join(f"{name} at tau = {meet[name]:.2f}" for name in ("join", "attract"))
    said = "\n\n".join(
        f"{name}: `{k['command']}`, {k['date']}, commit {k['commit'][:7]}"
        for name, k in kept.items()
    )
    return Found(
        figures=figures,
        text=f"They meet: {words}.\n\n{said}\n\n![Neighbors](pictures/{PICTURE.name})",
    )


CHECKS = {
    "neighbors": Check(
        title="Two cracks under cooling",
        text=(
            "`verification/neighbors/case.toml`: a body of 0.5 x 1 cooled from below, severity 6, "
            "ell = 0.03 = 3 h. Four cases: one crack alone from the cooled face; one beside "
            "another that is a little shorter; one below another that is not in line with it; one "
            "below another that is."
        ),
        measure=neighbors,
        kept="kept.json",
    ),
}


if __name__ == "__main__":
    print(json.dumps(run_members(), indent=1))
