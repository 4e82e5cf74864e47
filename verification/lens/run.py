"""Two offset cracks that meet: the lens that they cut, and the shape of their paths.

    python -m verification.lens.run

runs `verification/lens/case.toml` (some minutes on one core), and keeps the network of its cracks.
A run in runs/verification/lens is taken as it is. `make verify ONLY=lens` looks at what is kept.
Not run yet, so `verification/__main__.py` does not name this room.
"""

import json
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from staffa.io.run_directory import Run
from staffa.results.crack_network import networks
from verification.common.figures import Check, Figure, Found
from verification.common.runs import ROOT, keep, origin, run_once

KEPT = Path(__file__).parent / "kept.json"
CASE = "verification/lens/case.toml"
PICTURE = ROOT / "docs" / "pictures" / "verify-lens.png"
SOURCE = "Fender, Lechenault and Daniels 2010, experiments with several materials"
ASPECT = (2.0, 0.3)  # length over width; the abstract gives no error: 15 %
EXPONENT = (0.5, 0.1)  # of the distance between paths; "approximately" a square root
NEAR = 2.0  # distance in ell of two cracks below which their damage overlaps
FAR = 0.9  # part of the width up to which a path is fitted


def traced(run: Run) -> dict:
    """Return points and segments of the network at the last step, and the numbers of the run."""
    drawings, _ = networks(run)
    network = drawings[-1].network
    return origin(run, CASE, []) | {
        "ell": run.manifest.ell,
        "points": network.points[:, :2].round(5).tolist(),
        "segments": network.elements.tolist(),
    }


def loop(segments: np.ndarray) -> np.ndarray:
    """Return the segments that are left when loose ends are cut again and again, shape (n, 2).

    Parameters
    ----------
    segments : points of each segment, shape (m, 2).
    """
    while len(segments):
        ends = np.bincount(segments.ravel())
        whole = (ends[segments] > 1).all(axis=1)
        if whole.all():
            break
        segments = segments[whole]
    return segments


def halves(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return distance and way of the points of a lens's upper and lower side from where each ends.

    The upper crack comes from the left and ends at the right tip of the lens, the lower one the
    other way round. The distance is that across the cracks' first direction, the way is along it.

    Parameters
    ----------
    points : points of the lens, shape (n, 2).
    """
    left, right = points[points[:, 0].argmin()], points[points[:, 0].argmax()]
    chord = right - left
    above = np.cross(chord, points - left) > 0
    upper, lower = points[above], points[~above]
    return (
        np.abs(np.stack([right[0] - upper[:, 0], upper[:, 1] - right[1]], 1)),
        np.abs(np.stack([lower[:, 0] - left[0], left[1] - lower[:, 1]], 1)),
    )


def lens() -> Found:
    """Return the aspect of the lens, and the exponents of both paths."""
    kept = json.loads(KEPT.read_text())
    points, segments = np.array(kept["points"]), np.array(kept["segments"])
    round_ = points[np.unique(loop(segments))]
    if not len(round_):
        missing = Figure(
            what="length of the lens over its width: none was cut",
            source=SOURCE,
            reference=ASPECT[0],
            measured=float("nan"),
            tolerance=ASPECT[1],
        )
        return Found(figures=[missing], text="")
    length, width = size(round_)
    figures = [
        Figure(
            what="length of the lens over its width",
            source=SOURCE,
            reference=ASPECT[0],
            measured=length / width,
            tolerance=ASPECT[1],
        )
    ]
    fits = []
    for name, half in zip(("upper", "lower"), halves(round_), strict=True):
        near = (half[:, 1] > NEAR * kept["ell"]) & (half[:, 1] < FAR * width) & (half[:, 0] > 0)
        slope, log_factor = np.polyfit(*np.log(half[near]).T, 1)
        fits.append((half, slope, np.exp(log_factor)))
        figures.append(
            Figure(
                what=f"{name} crack: exponent of the distance to the other one's line against the "
                "way to where it ends",
                source=f"{SOURCE}: a square root",
                reference=EXPONENT[0],
                measured=float(slope),
                tolerance=EXPONENT[1],
            )
        )
    draw(points, segments, round_, fits)
    said = (
        f"Length {length:.3f}, width {width:.3f}; offset at the start 0.12. `{kept['command']}`, "
        f"{kept['date']}, commit {kept['commit'][:7]}, {kept['seconds']} s."
    )
    return Found(figures=figures, text=f"{said}\n\n![Lens](pictures/{PICTURE.name})")


def size(points: np.ndarray) -> tuple[float, float]:
    """Return the largest distance between two points, and the extent across it.

    Parameters
    ----------
    points : points of the lens, shape (n, 2).
    """
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    one, other = np.unravel_index(apart.argmax(), apart.shape)
    along = (points[other] - points[one]) / apart.max()
    across = np.cross(along, points - points[one])
    return float(apart.max()), float(np.ptp(across))


def draw(points: np.ndarray, segments: np.ndarray, round_: np.ndarray, fits: list) -> None:
    """Draw the network, and both paths as distance against way."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    left.plot(*points[segments].transpose(2, 1, 0), "k-", linewidth=1)
    middle = round_.mean(axis=0)
    reach = np.ptp(round_[:, 0])
    left.set(aspect="equal", xlabel="x", ylabel="y")
    left.set(
        xlim=middle[0] + reach * np.array([-1, 1]), ylim=middle[1] + 0.6 * reach * np.array([-1, 1])
    )
    for number, (half, slope, factor) in enumerate(fits):
        name = ("upper", "lower")[number]
        right.loglog(*half.T, f"C{number}.", markersize=4, label=f"{name} crack")
        way = np.geomspace(0.005, half[:, 0].max(), 50)
        right.loglog(
            way, factor * way**slope, f"C{number}-", linewidth=1, label=f"power {slope:.2f}"
        )
    right.set(xlabel="way to where the crack ends", ylabel="distance to the other's line")
    right.set(ylim=(0.005, None), xlim=(0.003, None))
    right.legend(frameon=False, fontsize=9)
    figure.savefig(PICTURE, dpi=120)
    plt.close(figure)


CHECKS = {
    "lens": Check(
        title="Two offset cracks cut a lens",
        text=(
            "Two parallel cracks, 10 ell apart, come from both ends of a plate between grips, "
            "behind cold fronts. They pass each other, turn, and cut a lens. In experiments with "
            "plates of several materials, pulled slowly, such lenses are twice as long as wide, "
            "and the paths have the shape of a square root (Fender, Lechenault, Daniels, Phys. "
            "Rev. Lett. 105, 125505, 2010, of which we have the abstract alone: it gives no "
            "errors). Length: between the two points of the lens that are farthest apart; width: "
            "across that. Path: the distance of a crack from the line of the other one against "
            "the way to where it ends, from 2 ell to 0.9 of the width. Tolerances were chosen "
            "before the run."
        ),
        measure=lens,
        kept="kept.json",
    ),
}


if __name__ == "__main__":
    keep(KEPT, traced(run_once(CASE, "lens", [])))
