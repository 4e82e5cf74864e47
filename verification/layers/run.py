"""A slab of two layers: whether its cracks stop at the upper one, cross, or turn; kept as one file.

    python -m verification.layers.run

runs the members (a minute each), draws the picture, and keeps what `make verify ONLY=layers` looks
at. Those that are in runs/verification/layered are taken as they are.
"""

import json
from dataclasses import dataclass
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from staffa.io.run_directory import Run
from staffa.plot.cracks import DAMAGE
from verification.common.figures import Check, Figure, Found
from verification.common.raster import Raster, raster
from verification.common.runs import ROOT, keep, origin, run_once

CASE = "verification/layers/case.toml"
KEPT = Path(__file__).parent / "kept.json"
PICTURE = ROOT / "docs" / "pictures" / "verify-layers.png"
# Where the upper layer begins, and the seam under it, as in the case.
SEAM, UPPER = 0.2, 0.28
# What a smeared crack can tell, over ell: a tip is at the layer, has crossed it, runs along it.
AT, ALONG = 1.5, 4.0


@dataclass(frozen=True, kw_only=True)
class Contrast:
    """Stiffness and toughness of the upper layer, and toughness of the seam, over the lower's."""

    E: float = 1.0
    Gc: float = 1.0
    seam: float = 1.0

    @property
    def name(self) -> str:
        """Name of its run."""
        return f"{self.E:g}-{self.Gc:g}-{self.seam:g}"

    @property
    def settings(self) -> tuple[str, ...]:
        """Its settings of the case."""
        return (
            f"regions.upper.E={self.E:g}",
            f"regions.upper.Gc={self.Gc:g}",
            f"regions.seam.Gc={self.seam:g}",
        )


CONTRASTS = (
    *(Contrast(E=E, Gc=Gc) for Gc in (0.25, 1, 4) for E in (0.2, 1, 5)),
    Contrast(Gc=16),
    *(Contrast(E=E, Gc=Gc, seam=0.25) for E, Gc in ((1, 1), (1, 4), (5, 1), (5, 4))),
)


def run_members() -> dict:
    """Run the members, or take those that are there; draw them, and keep what became of cracks."""
    kept, drawn = {}, {}
    for contrast in CONTRASTS:
        run = run_once(CASE, f"layered/{contrast.name}", contrast.settings)
        drawn[contrast] = raster(run)
        kept[contrast.name] = origin(run, CASE, contrast.settings) | outcome(run)
    draw(drawn, kept)
    keep(KEPT, kept)
    return kept


def outcome(run: Run) -> dict:
    """Number of cracks that come to the upper layer and cross it, turn along the seam, turn and
    cross, or stop there; and how many start beyond it."""
    ell, reach = run.manifest.ell, run.manifest.tip_reach or 0.0
    counts = dict.fromkeys(("cross", "turn", "both", "stop", "beyond"), 0)
    deepest = 0.0
    for crack in raster(run).cracks():
        low, tip = crack[:, 1].min(), crack[:, 1].max() + reach
        here = crack[(crack[:, 1] > SEAM - AT * ell) & (crack[:, 1] < UPPER + AT * ell)]
        along = len(here) > 0 and np.ptp(here[:, 0]) > ALONG * ell
        deepest = max(deepest, tip)
        if low > UPPER:
            counts["beyond"] += 1
        elif tip > UPPER + AT * ell:
            counts["both" if along else "cross"] += 1
        elif along or tip > UPPER - AT * ell:
            counts["turn" if along else "stop"] += 1
    return {**counts, "deepest": round(float(deepest), 4)}


def draw(drawn: dict[Contrast, Raster], kept: dict) -> None:
    """The damage of each member at the end, with the layer and the seam."""
    columns = 3
    rows = -(-len(drawn) // columns)
    figure, axes = plt.subplots(
        rows, columns, figsize=(9, 2.6 * rows), layout="constrained", squeeze=False
    )
    for panel in axes.flat:
        panel.set_axis_off()
    for panel, (contrast, found) in zip(axes.flat, drawn.items(), strict=False):
        panel.set_axis_on()
        panel.set_aspect("equal")
        panel.pcolormesh(
            found.x, found.y, found.alpha, cmap=DAMAGE, vmin=0, vmax=1, shading="gouraud"
        )
        panel.axhline(UPPER, color="C0", linewidth=0.8)
        seam = ""
        if contrast.seam != 1:
            panel.axhspan(SEAM, UPPER, color="C1", alpha=0.2, linewidth=0)
            seam = f", seam {contrast.seam:g}"
        said = said_of(kept[contrast.name])
        panel.set_title(f"E {contrast.E:g}, Gc {contrast.Gc:g}{seam}\n{said}", fontsize=9)
        panel.set(xlim=(0, found.x[-1]), ylim=(0, found.y[-1]), xticks=[], yticks=[])
    figure.savefig(PICTURE, dpi=130)
    plt.close(figure)


WORDS = {
    "cross": "cross",
    "turn": "turn",
    "both": "turn and cross",
    "stop": "stop there",
    "beyond": "start beyond",
}


def said_of(k: dict) -> str:
    """The course of the cracks, in words."""
    return ", ".join(f"{k[key]} {word}" for key, word in WORDS.items() if k[key]) or "none"


def layers() -> Found:
    """The expected effect of a contrast, and the table of the measured one."""
    kept = json.loads(KEPT.read_text())
    ell = 0.04  # as in the case
    depth = {name: k["deepest"] for name, k in kept.items()}
    even = depth["1-1-1"]
    turned = {name: k["turn"] + k["both"] for name, k in kept.items()}
    seams = [name for name in kept if not name.endswith("-1")]
    figures = [
        Figure(
            what="deepest crack, upper layer 16 times as tough",
            source="it stops at the layer; tolerance: 1.5 ell",
            reference=UPPER,
            measured=depth["1-16-1"],
            tolerance=AT * ell,
        ),
        *(
            Figure(
                what=f"deepest crack, upper layer {what}",
                source=f"between the face and that in uniform rock, {even:.3f}",
                reference=even / 2,
                measured=depth[name],
                tolerance=even / 2,
            )
            for what, name in (("4 times as tough", "1-4-1"), ("a fifth as stiff", "0.2-1-1"))
        ),
        *(
            Figure(
                what=f"deepest crack, upper layer {what}",
                source=f"between that in uniform rock, {even:.3f}, and the opposite boundary",
                reference=(1 + even) / 2,
                measured=depth[name],
                tolerance=(1 - even) / 2,
            )
            for what, name in (("a quarter as tough", "1-0.25-1"), ("5 times as stiff", "5-1-1"))
        ),
        Figure(
            what="cracks that turn where there is no weak seam",
            source="none does",
            reference=0,
            measured=sum(n for name, n in turned.items() if name not in seams),
            tolerance=0,
        ),
        Figure(
            what=f"of {len(seams)} slabs with a weak seam, those in which cracks turn along it",
            source="all",
            reference=len(seams),
            measured=sum(turned[name] > 0 for name in seams),
            tolerance=0,
        ),
        Figure(
            what="cracks that cross, weak seam under an upper layer 4 times as tough",
            source="none does",
            reference=0,
            measured=kept["1-4-0.25"]["cross"] + kept["1-4-0.25"]["both"],
            tolerance=0,
        ),
    ]
    return Found(figures=figures, text=f"{table(kept)}\n\n![Layers](pictures/{PICTURE.name})")


def table(kept: dict) -> str:
    """A row for each contrast."""
    lines = [
        "| upper E | upper Gc | seam Gc | " + " | ".join(WORDS.values()) + " | deepest |",
        "|" + " --- |" * (4 + len(WORDS)),
    ]
    for name, k in kept.items():
        counts = " | ".join(str(k[key]) for key in WORDS)
        lines.append(f"| {' | '.join(name.split('-'))} | {counts} | {k['deepest']:.3f} |")
    k = kept["1-16-1"]
    said = f"For example `{k['command']}`, {k['date']}, commit {k['commit'][:7]}"
    return "\n".join(lines) + f"\n\n{said}"


CHECKS = {
    "layers": Check(
        title="Cracks that meet another layer",
        text=(
            "`verification/layers/case.toml`: a slab of severity 12, ell = 0.04 = 3 h, at tau = "
            "0.5. From y = 0.28 on there is an upper layer; the table has its E and Gc over those "
            "of the lower one. Below it, from y = 0.2 on, there may be a weak seam. A crack "
            "crosses if its sharp tip is more than 1.5 ell beyond the upper layer's face. It turns "
            "if more than 4 ell of it lie along the face and the seam. Otherwise it stops there if "
            "its tip is within 1.5 ell of the face: also in uniform rock, where it would stop "
            "there anyway."
        ),
        measure=layers,
        kept="kept.json",
    ),
}


if __name__ == "__main__":
    print(json.dumps(run_members(), indent=1))
