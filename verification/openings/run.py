"""Openings of the slab's cracks: those that rest close, those that go on open wider.

    python -m verification.openings.run

reads the fields of the run of `verification/uneven` (which that room makes), opens sharp cracks at
the same places, as deep as the run's (a minute), and keeps what `make verify ONLY=openings` looks
at.
"""

import json
from datetime import UTC, datetime
from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from staffa.measure.network import Network
from staffa.results.crack_network import networks
from verification.common.figures import Check, Figure, Found
from verification.common.runs import ROOT, keep, run_once
from verification.common.sharp import SHARP
from verification.slabs.members import CASE
from verification.uneven.run import (
    MEMBERS,
    crack_paths,
    depths,
    kept_lengths,
    running,
    slab_settings,
)
from verification.uneven.sharp_cracks import SHIFT, CrackedBlock, SlabBlock

KEPT = Path(__file__).parent / "kept.json"
PICTURE = ROOT / "docs" / "pictures" / "verify-openings.png"
H = 0.0075  # cells of the sharp cracks' body: openings need fewer than lengths
SHALLOWEST = 3.0  # length in ell from which on the opening of a crack is compared
COMPARED = 0.1  # of an opening: the network of a crack ends within ell/2 of it
TWICE = 0.25  # of "about twice"
RESTING = 2.0  # a crack that rests for this factor of tau has had its time to close


def opened_cracks(network: Network) -> np.ndarray:
    """Return mouth, upper and lower end (m) and mean opening of each crack, shape (cracks, 4).

    The cracks stand in the order of their mouths.

    Parameters
    ----------
    network : the crack network of a step.
    """
    rows = []
    for crack in np.unique(network.cracks):
        mine = network.cracks == crack
        elements, sizes = network.elements[mine], network.sizes[mine]
        points = network.points[np.unique(elements)]
        mouth = points[points[:, 1].argmin()]
        opening = float(sizes @ network.opening[elements].mean(axis=1) / sizes.sum())
        rows.append([mouth[0], mouth[1], points[:, 1].max(), opening])
    return np.array(sorted(rows))


def measured_openings() -> dict:
    """Return the mean openings of the cracks at each step with fields, and of sharp ones there."""
    slab = kept_lengths("triangle").slab
    found, _ = networks(run_once(CASE, MEMBERS["triangle"], slab_settings("triangle")))
    paths = crack_paths(slab)
    order = np.argsort([path.x for path in paths])
    body = CrackedBlock(SlabBlock(width=slab["width"]), [paths[k] for k in order], H)
    steps = []
    for drawn in found:
        step = drawn.step.index
        if np.isnan(depths(slab, step)).any():
            continue
        opened = opened_cracks(drawn.network)
        now = depths(slab, step)
        places = np.array([slab["x"][k][step] for k in range(len(now))])
        matched = np.argsort(np.argsort(first_places(slab)))
        opened = opened[matched]
        assert len(opened) == len(now) and np.abs(opened[:, 0] - places).max() < 0.1
        counts = np.rint(now / H + SHIFT).astype(int)[order]
        jumps = body.jumps(slab["tau"][step]).openings(counts)
        sharp = np.zeros(len(now))
        for k, jump in zip(order, jumps, strict=True):
            y = np.linspace(*opened[k, 1:3], 50)
            deep = np.append(H * np.arange(len(jump)), now[k])
            sharp[k] = np.interp(y, deep, np.append(jump, 0.0)).mean()
        steps.append(
            {
                "step": step,
                "length": (opened[:, 2] - opened[:, 1]).round(4).tolist(),
                "opening": opened[:, 3].round(4).tolist(),
                "sharp": sharp.round(4).tolist(),
            }
        )
    return {"date": datetime.now(UTC).date().isoformat(), "steps": steps}


def first_places(slab: dict) -> np.ndarray:
    """Return the places along the face at which the cracks were first seen, shape (cracks,)."""
    return np.array([next(x for x in places if x is not None) for places in slab["x"]])


def at_rest_since(slab: dict) -> np.ndarray:
    """Return tau of the step from which on each crack is no deeper, shape (cracks,)."""
    last = len(slab["tau"]) - 1
    moving = [running(slab, step) for step in range(last)]
    found = np.full(len(slab["depth"]), slab["tau"][0])
    for step, cracks in enumerate(moving):
        found[cracks] = slab["tau"][step + 1]
    return found


def openings() -> Found:
    """Return openings beside sharp ones, closing of cracks at rest, widening as spacing doubles."""
    slab = kept_lengths("triangle").slab
    kept = json.loads(KEPT.read_text())["steps"]
    figures, rows = [], []
    for row in kept:
        on = going_on(slab, row["step"])
        on = on[np.array(row["length"])[on] >= SHALLOWEST * slab["ell"]]
        if len(on) < 3:
            continue
        measured, sharp = (float(np.array(row[k])[on].mean()) for k in ("opening", "sharp"))
        tau = slab["tau"][row["step"]]
        rows.append((tau, len(on), spacing(slab, row["step"], on), measured, sharp))
        figures.append(
            Figure(
                what=f"mean opening of the {len(on)} cracks that grow at tau = {tau:.2f}",
                source=f"{SHARP}, cracks at the same places, as deep as the run's",
                reference=sharp,
                measured=measured,
                tolerance=COMPARED,
                relative=True,
            )
        )
    figures += [wider(rows, at) for at in (1, 2) if at * 2 * rows[0][2] <= rows[-1][2]]
    figures.append(closing(slab, kept))
    draw(slab, kept)
    picture = f"![Openings against tau](pictures/{PICTURE.name})"
    return Found(figures=figures, text=f"{table(rows)}\n\n{picture}")


def going_on(slab: dict, step: int) -> np.ndarray:
    """Return the cracks that grow at a step; at the last one those that grew to it."""
    return running(slab, min(step, len(slab["tau"]) - 2))


def spacing(slab: dict, step: int, cracks: np.ndarray) -> float:
    """Return the mean distance of these cracks along the face."""
    return float(np.diff(np.sort([slab["x"][k][step] for k in cracks])).mean())


def wider(rows: list[tuple], times: int) -> Figure:
    """Return how much wider cracks are open when their spacing has doubled, once or once more.

    Parameters
    ----------
    rows : tau, number, spacing, opening and sharp opening of the cracks that grow.
    times : 1 for the first doubling of the spacing, 2 for the second.
    """
    distance, opening = np.array([row[2:4] for row in rows]).T
    start = times * distance[0]
    one, two = np.interp([start, 2 * start], distance, opening)
    return Figure(
        what=f"opening of the cracks that grow, spacing {2 * start:.3f}, over that at {start:.3f}",
        source="about twice: Bazant, Ohtsubo and Aoh 1979",
        reference=2.0,
        measured=float(two / one),
        tolerance=TWICE,
        relative=True,
    )


def closing(slab: dict, kept: list[dict]) -> Figure:
    """Return the opening at the end over the largest, of the crack at rest that closed least."""
    since, end = at_rest_since(slab), slab["tau"][-1]
    early = np.flatnonzero(RESTING * since <= end)
    opening = np.array([row["opening"] for row in kept])[:, early]
    return Figure(
        what=f"opening at tau = {end:.2f} over the largest, of {len(early)} cracks at rest since "
        f"half of that or less; the one that closed least",
        source="cracks at rest close: Bazant, Ohtsubo and Aoh 1979; less than a half",
        reference=0.5,
        measured=float((opening[-1] / opening.max(axis=0)).max()),
        tolerance=0.0,
        bound="most",
    )


def table(rows: list[tuple]) -> str:
    """Return a row for each step with fields."""
    lines = [
        "Cracks that grow, longer than 3 ell: mean opening over their length, and over their "
        "spacing.",
        "",
        "| tau | cracks | spacing | opening | sharp | over it | opening over spacing |",
        "|" + " --- |" * 7,
    ]
    for tau, number, distance, opening, sharp in rows:
        lines.append(
            f"| {tau:.2f} | {number} | {distance:.3f} | {opening:.3f} | {sharp:.3f} | "
            f"{opening / sharp - 1:+.1%} | {opening / distance:.2f} |"
        )
    return "\n".join(lines)


def draw(slab: dict, kept: list[dict]) -> None:
    """Draw the opening of each crack against tau, by when it came to rest."""
    figure, axes = plt.subplots(figsize=(7.5, 4.5), layout="constrained")
    tau = [slab["tau"][row["step"]] for row in kept]
    opening, sharp = (np.array([row[k] for row in kept]) for k in ("opening", "sharp"))
    since = at_rest_since(slab)
    ends = (0.0, 0.05, 0.1, 0.2, slab["tau"][-1] + 1)
    for number, (begin, end) in enumerate(pairwise(ends)):
        cracks = np.flatnonzero((since > begin) & (since <= end))
        said = "that still grow" if end > slab["tau"][-1] else f"at rest since tau <= {end:g}"
        label = f"{len(cracks)} cracks {said}"
        axes.plot(tau, opening[:, cracks].mean(axis=1), f"C{number}o-", markersize=4, label=label)
        axes.plot(tau, sharp[:, cracks].mean(axis=1), f"C{number}--")
    axes.set(xlabel="tau", ylabel="mean opening", ylim=(0, None), title="dashed: sharp cracks")
    axes.legend(frameon=False, fontsize=9)
    figure.savefig(PICTURE, dpi=120)
    plt.close(figure)


CHECKS = {
    "openings": Check(
        title="The paper's slab, free ends: openings of cracks",
        text=(
            "The run of `uneven`: mean opening of each crack over its length, in units of L over "
            "the severity's, where E = Gc = beta = 1. References: sharp cracks at the same places "
            "and as deep (`verification/uneven/sharp_cracks.py`, cells of 0.0075), averaged over "
            "the same part of their length; and what Bazant, Ohtsubo and Aoh (Int. J. Fract. 15, "
            "443, 1979) say of cracks of which every other one stops: it closes, and the others "
            "open about twice as wide. The spacing is that of the cracks that grow; time passes as "
            "it doubles, and the cracks get longer. Cracks of less than 3 ell are left out. "
            "Tolerances were chosen after the openings of the run had been seen."
        ),
        measure=openings,
        kept="kept.json",
    ),
}


if __name__ == "__main__":
    keep(KEPT, measured_openings())
