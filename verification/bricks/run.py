"""Bricks whose T-junctions turn to Y as cracks grow deeper: run once, kept as one small file.

    python -m verification.bricks.run

runs `verification/bricks/case.toml` (a quarter of an hour on one core), and keeps what `make verify
ONLY=bricks` looks at. A run in runs/verification/bricks is taken as it is.
"""

import json
from itertools import pairwise
from math import ceil
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
TILES, JUNCTIONS = 8, 16  # cells and junctions of the drawn part of the pattern
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
    measures = frames[-1].step.measures
    assert measures is not None
    planes = planes_of(run.manifest, frames[-1], [section.depth for section in measures.cells])
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
                "angle": round(slanted(plane), 1),
            }
        )
    return origin(run, CASE, []) | {"tau": frames[-1].step.tau, "planes": rows}


def unfolded(plane: ColumnPlane) -> tuple[np.ndarray, tuple[float, float]]:
    """Return the damage of TILES whole bricks, which repeats, and the edges of a pixel (m).

    Parameters
    ----------
    plane : a plane of the run, all of whose sides are planes of symmetry.
    """
    half = np.concatenate([plane.damage[::-1], plane.damage], axis=0)
    ends = zip(plane.extent, plane.damage.shape, strict=True)
    one, other = ((high - low) / count for (low, high), count in ends)
    return np.tile(np.concatenate([half, half[:, ::-1]], axis=1), (2, 2)), (one, other)


def slanted(plane: ColumnPlane) -> float:
    """Return the angle (degrees) between the two slanted joints that meet at a junction.

    It is opposite to the upright joint: 180 for a T, 120 for regular hexagons, more than 180 for
    joints that bend the other way; nan where a joint is missing. It follows from the slope of one
    of the two: the other is its image on the plane of symmetry through the junction.

    Parameters
    ----------
    plane : a plane of the run. The upright joint at the left end is in its upper half.
    """
    n, m = plane.damage.shape
    (left, right), (low, high) = plane.extent
    middle = slice(round(MIDDLE[0] * n), round(MIDDLE[1] * n))
    weight = np.maximum(plane.damage[middle] - BROKEN, 0)
    if not weight.sum(axis=1).all():
        return float("nan")
    x = left + (np.arange(n)[middle] + 0.5) * (right - left) / n
    y = weight @ (low + (np.arange(m) + 0.5) * (high - low) / m) / weight.sum(axis=1)
    slope = np.polyfit(x, y, 1)[0]  # downwards, where the junction at the left end has moved up
    return float(180 + 2 * np.degrees(np.arctan(slope)))


def draw(planes: list[ColumnPlane]) -> None:
    """Draw TILES bricks at each depth.

    Parameters
    ----------
    planes : the planes of the run.
    """
    across = ceil(len(planes) / 2)
    figure, axes = plt.subplots(2, across, figsize=(2.1 * across, 7.6), layout="constrained")
    for axis, plane in zip(axes.flat, planes, strict=False):
        whole, pixel = unfolded(plane)
        extent = (0.0, whole.shape[0] * pixel[0], 0.0, whole.shape[1] * pixel[1])
        axis.imshow(whole.T, origin="lower", extent=extent, cmap="Greys", vmin=0, vmax=1)
        axis.set(title=f"depth {plane.depth:g}", xticks=[], yticks=[])
    figure.savefig(PICTURE, dpi=120)
    plt.close(figure)


def bricks() -> Found:
    """Return whether all planes are cut into cells, and the junctions near the face and deep."""
    kept = json.loads(KEPT.read_text())
    rows = kept["planes"]
    whole = [row["cells"] == TILES and len(row["junctions"]) == JUNCTIONS for row in rows]
    steps = [after["angle"] <= before["angle"] + FLAT for before, after in pairwise(rows)]
    deepest = rows[-1]
    at = f"at depth {deepest['depth']:g}"
    figures = [
        Figure(
            what=f"of {len(rows)} planes, those that all joints cut",
            source="those of the case",
            reference=float(len(rows)),
            measured=float(sum(whole)),
            tolerance=0.0,
        ),
        share_of_t(rows[0], f"in the print, at depth {rows[0]['depth']:g}", 1.0),
        share_of_t(deepest, at, 0.0),
        Figure(
            what=f"angle between the slanted joints at a junction {at} (degrees)",
            source=SOURCE,
            reference=120.0,
            measured=deepest["angle"],
            tolerance=ANGLE,
        ),
        Figure(
            what=f"part of the depths at which this angle is at most {FLAT:g} degrees wider than "
            "at the depth before",
            source="junctions turn one way",
            reference=1.0,
            measured=float(np.mean(steps)),
            tolerance=0.0,
        ),
    ]
    lines = [
        "| depth | cells | T | Y | X | angle between the slanted joints |",
        "|" + " --- |" * 6,
    ]
    for row in rows:
        counts = " | ".join(str(row["junctions"].count(kind)) for kind in "TYX")
        lines.append(f"| {row['depth']:g} | {row['cells']} | {counts} | {row['angle']:.0f} |")
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
            "Joints of bricks are printed on the face, with T-junctions. Below the print cracks go "
            "where they will, within the symmetry of the pattern: junctions move up and down, "
            "slanted joints bend, upright ones stay in their planes. By theory and in basalt right "
            "angles tend to 120 degrees (Hofmann, Anderssohn, Bahr, Weiss, Nellesen, Phys. Rev. "
            "Lett. 115, 154301, 2015, of which we have the abstract alone). All sides are planes "
            "of symmetry, so the body stands for an endless pattern and needs no periodic sides. "
            "By symmetry all junctions are images of one. The angle opposite to the upright joint "
            "is 180 degrees in a T and 120 in regular hexagons. A junction whose widest angle is "
            "below 150 counts as a Y (docs/how-to/columns.md). A crack on a plane of symmetry "
            "costs a few percent more than one inside, which we did not correct. Tolerance of the "
            "angle: a quarter of the difference, chosen before this run and after a shorter one, "
            "which had come to 139 degrees 0.32 deep."
        ),
        measure=bricks,
        kept="kept.json",
    ),
}


if __name__ == "__main__":
    keep(KEPT, digest(run_once(CASE, "bricks", [])))
