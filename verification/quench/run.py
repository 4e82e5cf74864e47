"""Quenched alumina: how far apart cracks are at each depth; run once, kept as a small file.

    python -m verification.quench.run

runs the strip, half an hour, draws the picture, and keeps what `make verify ONLY=quench` looks at.
One that was run by hand, on more ranks say, into runs/verification/quench is taken as it is.
"""

import json
from functools import partial
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from staffa.io.run_directory import Run, open_run
from staffa.measure.generations import tracks
from staffa.plot.cracks import cracks_figure
from staffa.plot.frames import read_frames
from staffa.plot.style import write_picture
from verification.common.figures import Check, Figure, Found
from verification.common.runs import ROOT, as_typed, staffa
from verification.common.sharp import SHARP, half_space_doubling

KEPT = Path(__file__).parent / "kept.json"
CASE = "src/staffa/case/ready/ceramic-strip.toml"
# Wide enough to count: of cracks 1 mm deep there is room for five.
SETTINGS = ('domain.size=["6 mm","5 mm"]',)
PICTURES = ROOT / "docs" / "pictures"
DRAWN = ("verify-quench.png", "verify-quench-spacing.png")
COUNTED = 3  # cracks, from which on a mean spacing is one


def run_strip() -> dict:
    """Run the strip, or take the run that is there; keep what is looked at."""
    where = ROOT / "runs" / "verification" / "quench"
    if not where.exists():
        staffa(ROOT / CASE, where, SETTINGS)
    run = open_run(where)
    assert run.finished
    frames, _ = read_frames(run)
    write_picture(PICTURES / DRAWN[0], partial(cracks_figure, run.manifest, frames))
    kept = digest(run)
    KEPT.write_text(json.dumps(kept, indent=1) + "\n")
    return kept


def digest(run: Run) -> dict:
    """The numbers that are kept of the run; depths are those of sharp tips (m)."""
    m = run.manifest
    followed = tracks(run.steps, axis=1, sharp=m.sharp)
    heats = [step.heat for step in run.steps if step.heat]
    return {
        "command": as_typed(run, CASE, SETTINGS),
        "commit": m.commit,
        "date": m.created[:10],
        "seconds": round(sum(step.seconds for step in run.steps)),
        "unknowns": m.unknowns,
        "ell0": m.scales["ell0"],
        "width": m.size[0],
        "finals": sorted(round(track.final, 7) for track in followed),
        "heat_balance": max(heat.imbalance for heat in heats),
        "heat_seconds": round(sum(heat.seconds for heat in heats), 1),
    }


def quench() -> Found:
    """Spacing of the cracks as deep as each of them, between p(a) and 2 p(a)."""
    kept = json.loads(KEPT.read_text())
    ell0, width = kept["ell0"], kept["width"]
    finals = np.array(kept["finals"])
    figures, points = [], []
    for depth in (10, 20, 40, 80, 120):
        cracks = int((finals >= depth * ell0).sum())
        if cracks < COUNTED:
            continue
        p, spacing = half_space_doubling(depth), width / cracks / ell0
        points.append((depth, spacing))
        figures.append(
            Figure(
                what=f"spacing of the {cracks} cracks as deep as {depth} ell0, over ell0",
                source=f"{SHARP}, half-space: from p to 2 p, p = {p:.3g}",
                reference=1.5 * p,
                measured=spacing,
                tolerance=0.5 * p,
            )
        )
    draw(points, finals / ell0, width / ell0)
    said = f"`{kept['command']}`, {kept['date']}, commit {kept['commit']}, {kept['seconds']} s"
    pictures = "\n".join(f"![Quenched alumina](pictures/{name})" for name in DRAWN)
    return Found(figures=figures, text=f"{said}\n\n{pictures}")


def draw(points: list[tuple[float, float]], finals: np.ndarray, width: float) -> None:
    """Spacing against depth beside the doubling curve and its double."""
    figure, axes = plt.subplots(figsize=(7, 4))
    a = np.geomspace(5, 300, 100)
    p = np.array([half_space_doubling(depth) for depth in a])
    axes.fill_between(a, p, 2 * p, color="C0", alpha=0.2, label="sharp cracks, from p(a) to 2 p(a)")
    depths = np.sort(finals)
    axes.step(
        depths, width / np.arange(len(depths), 0, -1), "k-", where="pre", linewidth=1,
        label="staffa: width over the cracks as deep as a",
    )  # fmt: skip
    axes.plot(*np.array(points).T, "ko", markersize=4, label="compared with them")
    axes.set(
        xscale="log", yscale="log", xlabel="depth a, over ell0", ylabel="spacing, over ell0",
        xlim=(5, 300),
    )  # fmt: skip
    axes.legend(frameon=False, fontsize=9)
    figure.savefig(PICTURES / DRAWN[1], dpi=120, bbox_inches="tight")
    plt.close(figure)


CHECKS = {
    "quench": Check(
        title="Quenched alumina",
        text="A strip of 6 mm of `ceramic-strip`: cracks as deep as each depth, by their sharp "
        "tips, and the spacing at which an even array in a half-space doubles. The quarter of a "
        "plate (`ceramic-quench`) was not run: `staffa check` expects ten hours on one core for "
        "each temperature, with `domain.refine` too. Published work takes two toughnesses, 42.47 "
        "J/m^2, and 24.32 J/m^2, which is K_Ic^2/E at 3 MPa m^1/2 and 370 GPa. The second was not "
        "run either. Tables of measured spacings and depths at the four temperatures were looked "
        "for and not found; only words were: more cracks, longer and closer the hotter the plate.",
        measure=quench,
        kept="kept.json",
    ),
}


if __name__ == "__main__":
    print(json.dumps(run_strip(), indent=1))
