"""Bricks whose T-junctions turn to Y as cracks grow deeper: run once, kept as one small file.

    python -m verification.bricks.run

runs `verification/bricks/case.toml` (a quarter of an hour on one core), and keeps what `make verify
ONLY=bricks` looks at. A run in runs/verification/bricks is taken as it is.
"""

import json
from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from staffa.io.run_directory import Run
from staffa.measure.cells import cells
from staffa.plot.cell_planes import ColumnPlane
from staffa.plot.frames import read_frames
from staffa.results.sections import planes_of
from verification.common.figures import Check, Figure, Found
from verification.common.runs import ROOT, keep, origin, run_once

CASE = "verification/bricks/case.toml"
KEPT = Path(__file__).parent / "kept.json"
PICTURE = ROOT / "docs" / "pictures" / "verify-bricks.png"
SOURCE = "Hofmann et al. 2015, regular hexagons"
MIDDLE = (0.25, 0.75)  # part of the joint between two junctions whose slope is taken
BROKEN = 0.5  # damage that tells where a joint is
ANGLE = 15.0  # degrees; halfway to those of a T would be 30
FLAT = 2.0  # degrees by which an angle may grow from a depth to the next: pixels


def digest(run: Run) -> dict:
    """Return the numbers that are kept of a run, and draw the planes.

    Parameters
    ----------
    run : the run.
    """
    frames, _ = read_frames(run)
    planes = planes_of(run.manifest, frames[-1])
    draw(planes)
    rows = []
    for plane in planes:
        whole, pixel = unfolded(plane)
        found = cells(
            whole,
            pixel=pixel,
            ell=run.manifest.ell,
            threshold=plane.threshold,
            periodic=(True, True),
        )
        rows.append(
            {
                "depth": plane.depth,
                "cells": found.number,
                "junctions": [str(kind) for kind in found.kinds],
                "widest": round(widest(plane), 1),
            }
        )
    return origin(run, CASE, []) | {"tau": frames[-1].step.tau, "planes": rows}


def unfolded(plane: ColumnPlane) -> tuple[np.ndarray, tuple[float, float]]:
    """Return the damage of eight whole bricks, which repeats, and the edges of a pixel (m).

    Parameters
    ----------
    plane : a plane of the run, all of whose sides are planes of symmetry.
    """
    half = np.concatenate([plane.damage[::-1], plane.damage], axis=0)
    ends = zip(plane.extent, plane.damage.shape, strict=True)
    one, other = ((high - low) / count for (low, high), count in ends)
    return np.tile(np.concatenate([half, half[:, ::-1]], axis=1), (2, 2)), (one, other)


def widest(plane: ColumnPlane) -> float:
    """Return the widest angle at a junction (degrees), by the slope of the joint between two.

    On the plane of symmetry through a junction two such joints meet, one the image of the other:
    180 for a T, 120 for regular hexagons; nan where there is no joint.

    Parameters
    ----------
    plane : a plane of the run.
    """
    n, m = plane.damage.shape
    (left, right), (low, high) = plane.extent
    middle = slice(round(MIDDLE[0] * n), round(MIDDLE[1] * n))
    weight = np.maximum(plane.damage[middle] - BROKEN, 0)
    if not weight.sum(axis=1).all():
        return float("nan")
    x = left + (np.arange(n)[middle] + 0.5) * (right - left) / n
    y = weight @ (low + (np.arange(m) + 0.5) * (high - low) / m) / weight.sum(axis=1)
    slope = np.polyfit(x, y, 1)[0]
    return float(180 - 2 * np.degrees(np.arctan(abs(slope))))


def draw(planes: list[ColumnPlane]) -> None:
    """Draw eight bricks at each depth that has joints.

    Parameters
    ----------
    planes : the planes of the run.
    """
    shown = [plane for plane in planes if plane.cells.number > 1]
    figure, axes = plt.subplots(
        1, len(shown), figsize=(2.1 * len(shown), 3.8), layout="constrained"
    )
    for axis, plane in zip(np.atleast_1d(axes), shown, strict=True):
        whole, pixel = unfolded(plane)
        extent = (0.0, whole.shape[0] * pixel[0], 0.0, whole.shape[1] * pixel[1])
        axis.imshow(whole.T, origin="lower", extent=extent, cmap="Greys", vmin=0, vmax=1)
        axis.set(title=f"depth {plane.depth:g}", xticks=[], yticks=[])
    figure.savefig(PICTURE, dpi=120)
    plt.close(figure)


def bricks() -> Found:
    """Return the junctions at the face and at the greatest depth that all joints reach."""
    kept = json.loads(KEPT.read_text())
    rows = [row for row in kept["planes"] if row["cells"] > 1]
    printed, deepest = rows[0], rows[-1]
    at = f"at depth {deepest['depth']:g}"
    steps = [after["widest"] <= before["widest"] + FLAT for before, after in pairwise(rows)]
    figures = [
        share_of_t(printed, f"in the print, at depth {printed['depth']:g}", 1.0),
        share_of_t(deepest, at, 0.0),
        Figure(
            what=f"widest angle at a junction {at} (degrees)",
            source=SOURCE,
            reference=120.0,
            measured=deepest["widest"],
            tolerance=ANGLE,
        ),
        Figure(
            what="part of the depths at which this angle is no wider than at the depth before",
            source="junctions turn one way",
            reference=1.0,
            measured=float(np.mean(steps)),
            tolerance=0.0,
        ),
    ]
    lines = [
        "| depth | cells | T | Y | X | widest angle at a junction |",
        "|" + " --- |" * 6,
    ]
    for row in rows:
        counts = " | ".join(str(row["junctions"].count(kind)) for kind in "TYX")
        lines.append(f"| {row['depth']:g} | {row['cells']} | {counts} | {row['widest']:.0f} |")
    said = (
        f"`{kept['command']}`, {kept['date']}, commit {kept['commit'][:7]}, "
        f"{kept['unknowns']:,} unknowns, {kept['seconds']} s; at tau = {kept['tau']:g}."
    )
    picture = f"![From bricks to hexagons](pictures/{PICTURE.name})"
    return Found(figures=figures, text="\n\n".join([said, "\n".join(lines), picture]))


def share_of_t(row: dict, where: str, expected: float) -> Figure:
    """Return the part of the junctions of a plane that are a T.

    Parameters
    ----------
    row : what is kept of the plane.
    where : the plane, in words.
    expected : what this part should be.
    """
    kinds = row["junctions"]
    return Figure(
        what=f"part of the junctions {where}, that are a T",
        source="bricks" if expected else SOURCE,
        reference=expected,
        measured=kinds.count("T") / len(kinds) if kinds else float("nan"),
        tolerance=0.0,
    )


CHECKS = {
    "bricks": Check(
        title="From bricks to hexagons",
        text=(
            "Joints of bricks are printed on the face, with T-junctions. Below the print cracks "
            "grow freely. By theory and in basalt their right angles tend to 120 degrees (Hofmann, "
            "Anderssohn, Bahr, Weiss, Nellesen, Phys. Rev. Lett. 115, 154301, 2015, of which we "
            "have the abstract alone). All sides are planes of symmetry of this pattern, so the "
            "body stands for an endless one and needs no periodic sides. A T has an angle of 180 "
            "degrees, a Y of a regular hexagon three of 120. Below 150 a junction counts as a Y "
            "(docs/how-to/columns.md). Tolerance of the angle: a quarter of the difference, chosen "
            "before this run and after a shorter one, which had come to 139 degrees 0.32 deep."
        ),
        measure=bricks,
        kept="kept.json",
    ),
}


if __name__ == "__main__":
    keep(KEPT, digest(run_once(CASE, "bricks", [])))
