"""A phase diagram of cracks behind a cold front: none, straight, wavy, branched.

    python -m verification.strip.phases [NAME ...]

runs members that are not kept yet, one after the other, like "20-4": Peclet number, and W/ell0 over
the threshold of the sharp crack; without a name, all of MEMBERS. `make verify` runs nothing. To run
one again, delete its entry in verification/strip/kept.json.
"""

import json
import sys
from itertools import pairwise
from math import sqrt
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from staffa.io.run_directory import Run
from staffa.measure.network import polylines
from staffa.results.crack_network import networks
from verification.common.figures import Figure, Found
from verification.common.runs import ROOT, keep, origin, run_once
from verification.strip.sharp_strip import Strip, front

CASE = "verification/strip/phases.toml"
KEPT = Path(__file__).parent / "kept.json"
PICTURE = ROOT / "docs" / "pictures" / "verify-strip.png"
NOTCH, WIDTH = 0.4, 1.0  # as in the case
# Toughness over Gc of the mesh along its finest cells, which the load takes into account.
FACTOR = 1.14
MEMBERS = ("20-0.8", "20-2", "20-4", "20-6", "20-9", "10-0.8", "10-2", "10-4", "10-6")
LINES = 40  # across the strip at which the cracks are looked at


def drop(name: str, thresholds: dict[str, float]) -> float:
    """Return the drop in the bath of a member, which the effective Gc of its mesh raises."""
    peclet, times = name.split("-")
    return round(sqrt(float(times) * thresholds[peclet] * FACTOR), 4)


def run_settings(name: str, dT: float) -> list[str]:
    """Return the setting by which a member differs from the case."""
    peclet = name.split("-")[0]
    return [f'temperature.T="-{dT:.4f}*where(x < t, 1, exp(-{peclet}*(x - t)))"']


def run_members(names: tuple[str, ...]) -> None:
    """Run members that are not kept yet, and keep their numbers."""
    found = json.loads(KEPT.read_text()) if KEPT.exists() else {}
    body = Strip(64)
    thresholds = {p: body.released(front(float(p))).threshold for p in ("10", "20")}
    for name in names:
        if name in found:
            continue
        peclet, dT = name.split("-")[0], drop(name, thresholds)
        settings = run_settings(name, dT)
        run = run_once(CASE, f"strip-phases-{name}", settings)
        load = dT**2 / (run.manifest.toughness_factor * thresholds[peclet])
        found[name] = {"peclet": float(peclet), "load": round(load, 3), **digest(run)}
        found[name] |= origin(run, CASE, settings)
        keep(KEPT, dict(sorted(found.items())))


def digest(run: Run) -> dict:
    """Return what is kept of a run: its lines at the last step, and numbers on them."""
    last = networks(run)[0][-1]
    cracks = last.network
    lines = [cracks.points[line, :2].round(3).tolist() for line in polylines(cracks)]
    return {
        "toughness_factor": run.manifest.toughness_factor,
        "ell": run.manifest.ell,
        "front": last.step.time,
        "lines": lines,
    }


def state(k: dict) -> str:
    """Return the state of a run by the lines of its cracks ahead of the notch.

    none: no crack has grown by 4 ell. branched: at a quarter of the lines across the strip or more,
    two cracks cross. wavy: the crack swings by more than 2 ell to both sides of its middle.
    """
    deepest, crossed, swing = shape(k)
    if deepest < NOTCH + 4 * k["ell"]:
        return "none"
    if crossed >= 0.25:
        return "branched"
    return "wavy" if swing > 2 * k["ell"] else "straight"


def shape(k: dict) -> tuple[float, float, float]:
    """Return the deepest point, the part of lines that several cracks cross, and half the swing."""
    lines = [np.array(line) for line in k["lines"] if len(line) > 1]
    deepest = max(float(line[:, 0].max()) for line in lines)
    y: list[list[float]] = []
    for x in np.linspace(NOTCH + 2 * k["ell"], deepest - k["ell"], LINES):
        y.append([p for line in lines for p in _crossings(line, x)])
    several = float(np.mean([len(at) > 1 for at in y]))
    single = [p for at in y for p in at]
    return deepest, several, (max(single) - min(single)) / 2 if single else 0.0


def _crossings(line: np.ndarray, x: float) -> list[float]:
    """Return where a line crosses a place along the strip."""
    found = []
    for (x0, y0), (x1, y1) in pairwise(line):
        if (x0 - x) * (x1 - x) < 0:
            found.append(float(y0 + (y1 - y0) * (x - x0) / (x1 - x0)))
    return found


def phases() -> Found:
    """The states of the kept runs, and their picture."""
    found = json.loads(KEPT.read_text())
    states = {name: state(k) for name, k in found.items()}
    draw(found, states)
    figures = [_grows(name, k, states[name]) for name, k in found.items()]
    head = "| P | W/ell0 over its threshold | state | lines that several cracks cross | swing/W |"
    rows = [head, "|" + " --- |" * 5]
    for name, k in sorted(found.items(), key=lambda item: (item[1]["peclet"], item[1]["load"])):
        _, several, swing = shape(k)
        rows.append(
            f"| {k['peclet']:g} | {k['load']:.2f} | {states[name]} | {several:.2f} | {swing:.3f} |"
        )
    picture = f"![Cracks behind a cold front by speed and load](pictures/{PICTURE.name})"
    return Found(figures=figures, text="\n".join([*rows, "", picture]))


def _grows(name: str, k: dict, found: str) -> Figure:
    """1 if cracks grow, else 0, beside what the sharp crack does at this load."""
    peclet = name.split("-")[0]
    return Figure(
        what=f"1 if cracks grow, P = {peclet}, W/ell0 {k['load']:.2f} times its threshold",
        source="sharp-crack finite elements",
        reference=float(k["load"] > 1),
        measured=float(found != "none"),
        tolerance=0.0,
    )


def draw(found: dict, states: dict[str, str]) -> None:
    """Draw each member's cracks, a column for each speed, the load growing downwards."""
    speeds = sorted({k["peclet"] for k in found.values()})
    columns = [
        sorted((k["load"], name) for name, k in found.items() if k["peclet"] == p) for p in speeds
    ]
    rows = max(len(column) for column in columns)
    figure, axes = plt.subplots(
        rows,
        len(speeds),
        figsize=(5 * len(speeds), 2.2 * rows),
        layout="constrained",
        squeeze=False,
    )
    for axis in axes.flat:
        axis.set_axis_off()
    for number, column in enumerate(columns):
        for row, (load, name) in enumerate(column):
            axis, k = axes[row, number], found[name]
            axis.set_axis_on()
            for line in k["lines"]:
                axis.plot(*np.array(line).T, color="black", lw=1.5)
            axis.axvline(k["front"], color="#1f77b4", lw=1)
            axis.set(xlim=(0, 2.2), ylim=(0, WIDTH), aspect="equal", xticks=[], yticks=[])
            axis.set_title(f"P = {k['peclet']:g}, {load:.2g} times: {states[name]}", fontsize=10)
    figure.savefig(PICTURE, dpi=120)
    plt.close(figure)


if __name__ == "__main__":
    run_members(tuple(sys.argv[1:]) or MEMBERS)
