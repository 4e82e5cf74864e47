"""Two cracks under cooling: one shields the other, attracts it, joins it; kept as one file.

    python verify/neighbors.py

runs the three members (minutes), draws the picture, and keeps what `make verify ONLY=neighbors`
looks at. Those that are in runs/verify/neighbors are taken as they are.
"""

import json
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from figures import Found
from raster import Raster, raster
from runs import ROOT, keep, origin, run_once

from staffa.io.run_directory import Run
from staffa.plot.cracks import DAMAGE

CASE = "verify/neighbors.toml"
KEPT = Path(__file__).parent / "neighbors.json"
PICTURE = ROOT / "docs" / "pictures" / "verify-neighbors.png"
ELL = 0.03  # as in the case
# Two cracks each: (x, from y, to y).
PAIRS = {
    "shield": ((0.42, 0.0, 0.15), (0.58, 0.0, 0.1)),
    "attract": ((0.43, 0.0, 0.12), (0.57, 0.3, 0.5)),
    "join": ((0.5, 0.0, 0.12), (0.5, 0.35, 0.55)),
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
    """At each step the highest point of each of the two cracks, and whether they are one."""
    return [{"tau": step.tau} | look(name, raster(run, step)) for step in run.steps]


def look(name: str, found: Raster) -> dict:
    """What `history` keeps of one step."""
    cracks, tips, which = found.cracks(), [], []
    for x, low, _ in PAIRS[name]:
        away = [np.hypot(*(crack - [x, low]).T).min() for crack in cracks]
        which.append(int(np.argmin(away)))
        crack = cracks[which[-1]]
        top = crack[crack[:, 1] == crack[:, 1].max()].mean(axis=0)
        tips.append([round(float(c), 4) for c in top])
    return {"tips": tips, "one": which[0] == which[1]}


def draw(runs: dict[str, Run]) -> None:
    """Each pair at the first step, when it changes most, and at the end."""
    figure, axes = plt.subplots(3, len(runs), figsize=(9, 9), layout="constrained")
    for column, (name, run) in zip(axes.T, runs.items(), strict=True):
        for panel, step in zip(column, chosen(run), strict=True):
            found = raster(run, step)
            panel.pcolormesh(
                found.x, found.y, found.alpha, cmap=DAMAGE, vmin=0, vmax=1, shading="gouraud"
            )
            panel.set_aspect("equal")
            panel.set_title(f"{name}, tau = {step.tau:g}", fontsize=10)
            panel.set(xlim=(0.1, 0.9), ylim=(0, 0.8))
    figure.savefig(PICTURE, dpi=130)
    plt.close(figure)


def chosen(run: Run) -> tuple:
    """Three steps."""
    return run.steps[0], run.steps[len(run.steps) // 2], run.steps[-1]


def neighbors() -> Found:
    """What each pair should do."""
    return Found(figures=[], text="")


if __name__ == "__main__":
    print(json.dumps(run_members(), indent=1))
