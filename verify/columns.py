"""Columns in a block cooled from below, and in one twice as wide: run once, kept as one small file.

    python verify/columns.py

runs the members (hours), and keeps what `make verify ONLY=columns` looks at. Those
that are in runs/verify/columns, by hand on more ranks say, are taken as they are.
"""

import json
import shutil
from collections.abc import Iterator, Sequence
from math import hypot, pi, sqrt
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from figures import Figure, Found
from runs import ROOT, keep, origin, run_once

from staffa.io.run_directory import Run
from staffa.measure.patterns import Estimate, Pattern, pattern
from staffa.physics.doubling import spacing_at
from staffa.records import CellSection
from staffa.report.drawing import draw

CASE = "src/staffa/cases/brick.toml"
KEPT = Path(__file__).parent / "columns.json"
SIZES = {"single": (2.5, (1, 2, 3, 4)), "doubled": (5.0, (1, 2))}  # width, seeds
CHANGE = 0.1  # of size and depth that is none
INSIDE = 0.8  # of the depth of the body
PICTURES = ROOT / "docs" / "pictures"
DRAWN = ("verify-columns.png", "verify-columns-sections.png", "verify-columns-size.png")
SHARP = "sharp-crack finite elements, half-space, ell0 for two blocked directions"


def settings(width: float, seed: int) -> list[str]:
    """What a member changes in the case."""
    return [f"domain.size=[{width},{width},1.0]", f"toughness.seed={seed}"]


def run_members() -> dict:
    """Run the members, or take those that are there, and keep the cells of their last state."""
    kept = {}
    for name, (width, seeds) in SIZES.items():
        for seed in seeds:
            run = run_once(CASE, f"columns/{name}-{seed}", settings(width, seed))
            kept[f"{name}-{seed}"] = origin(run, CASE, settings(width, seed)) | digest(run)
    keep(KEPT, kept)
    draw(run, movie=False)  # the last, one of the widest: quiet runs leave no pictures
    for picture, drawn in zip(("cracks.png", "sections.png"), DRAWN, strict=False):
        shutil.copy(run.path / "pictures" / picture, PICTURES / drawn)
    return kept


def digest(run: Run) -> dict:
    """What is kept of a run."""
    step = run.steps[-1]
    assert step.measures is not None
    return {
        "ell0": run.manifest.scales["ell0"],
        "toughness_factor": run.manifest.toughness_factor,
        "sweeps": sum(step.sweeps for step in run.steps),
        "fronts": [round(s.measures.front, 4) for s in run.steps if s.measures is not None],
        "area": round(step.measures.length_surface, 4),
        "violations": [sentence for s in run.steps if s.audit for sentence in s.audit.violations],
        "cells": [
            {
                "depth": section.depth,
                "pixel": [round(edge, 6) for edge in section.pixel],
                "areas": [round(area, 5) for area in section.areas],
                "perimeters": [round(length, 4) for length in section.perimeters],
                "sides": section.sides,
                "ends": section.ends,
                "junctions": section.junctions,
                "cracked": round(section.cracked, 4),
            }
            for section in step.measures.cells
        ],
    }


def sections(kept: dict, size: str) -> dict[float, list[CellSection]]:
    """The sections of all seeds of one size, by depth."""
    found: dict[float, list[CellSection]] = {}
    for name, member in kept.items():
        for section in member["cells"] if name.startswith(size) else ():
            found.setdefault(section["depth"], []).append(CellSection(**section))
    return found


def columns() -> Found:
    """A block and its double; spacing against depth; the deepest cells."""
    kept = json.loads(KEPT.read_text()) if KEPT.exists() else run_members()
    patterns = {
        size: {depth: pattern(found) for depth, found in sections(kept, size).items()}
        for size in SIZES
    }
    both = {
        depth: pattern([*sections(kept, "single")[depth], *sections(kept, "doubled")[depth]])
        for depth in patterns["doubled"]
    }
    ell0 = next(iter(kept.values()))["ell0"]
    draw_sizes(patterns, ell0)
    pictures = "\n".join(f"![Columns](pictures/{name})" for name in DRAWN)
    figures = [*alike(kept, patterns), *growing(both, ell0)]
    return Found(figures=figures, text="\n\n".join([table(both), members(kept), pictures]))


def draw_sizes(patterns: dict[str, dict[float, Pattern]], ell0: float) -> None:
    """Size of the cells against depth, of both sizes of the block."""
    figure, axes = plt.subplots(figsize=(7, 4))
    depths = np.linspace(0.05, 0.65, 50)
    p = spacing_at(depths, ell0)
    label = "parallel cracks, from p(a) to 2 p(a)"
    axes.fill_between(depths, p, 2 * p, color="C0", alpha=0.2, label=label)
    for marker, (size, found) in zip("os", patterns.items(), strict=True):
        at, diameters, errors = zip(*known(found), strict=True)
        axes.errorbar(at, diameters, errors, fmt=f"k{marker}-", capsize=3, label=size)
    axes.set(xlabel="depth", ylabel="diameter of the cells", xlim=(0, 0.65))
    axes.legend(frameon=False, fontsize=9)
    figure.savefig(PICTURES / DRAWN[2], dpi=120, bbox_inches="tight")
    plt.close(figure)


def known(found: dict[float, Pattern]) -> Iterator[tuple[float, float, float]]:
    """Depth, diameter and its standard error, where there is more than one cell."""
    for depth, cells in found.items():
        area = cells.whole_area
        if cells.number > 1 and area.value is not None:
            size = diameter(area.value)
            yield depth, size, size * (area.error or 0.0) / area.value / 2


def diameter(area: float) -> float:
    """Of the circle of this area."""
    return sqrt(4 * area / pi)


def alike(kept: dict, patterns: dict[str, dict[float, Pattern]]) -> Iterator[Figure]:
    """Cell size at equal depth, and depth of penetration, of the block and its double."""
    for depth, doubled in patterns["doubled"].items():
        one, two = patterns["single"][depth].whole_area, doubled.whole_area
        if one.value is None or two.value is None or doubled.interior == 0:
            continue
        error = hypot(*(a.error / a.value for a in (one, two) if a.error and a.value))
        yield Figure(
            what=f"mean area of cells at depth {depth:g}, doubled over single (error {error:.2f})",
            source="the cells are as large, to 10 % or the standard error",
            reference=1.0,
            measured=two.value / one.value,
            tolerance=max(CHANGE, error),
        )
    fronts = {s: [m["fronts"] for n, m in kept.items() if n.startswith(s)] for s in SIZES}
    means = {size: np.mean(values, axis=0) for size, values in fronts.items()}
    highest = np.max([values for found in fronts.values() for values in found], axis=0)
    last = int(np.flatnonzero(highest < INSIDE)[-1])  # before cracks feel the far side
    yield Figure(
        what=f"depth of penetration at step {last}, doubled over single",
        source=f"the same depth; single: {means['single'][last]:.3g}",
        reference=1.0,
        measured=float(means["doubled"][last] / means["single"][last]),
        tolerance=CHANGE,
    )


def growing(found: dict[float, Pattern], ell0: float) -> Iterator[Figure]:
    """Diameter of the cells at each depth, from where cracks stop to where they have stopped."""
    for depth, cells in found.items():
        p, area = float(spacing_at(depth, ell0)), cells.whole_area.value
        if cells.number > 1 and area is not None:
            yield Figure(
                what=f"diameter of cells at depth {depth:g}, over ell0",
                source=f"{SHARP}: from p to 2 p, p = {p / ell0:.3g}",
                reference=1.5 * p / ell0,
                measured=diameter(area) / ell0,
                tolerance=0.5 * p / ell0,
            )


def told(number: Estimate) -> str:
    """A number with its standard error."""
    if number.value is None:
        return "-"
    return f"{number.value:.3g}" + (f" ± {number.error:.2g}" if number.error is not None else "")


def table(found: dict[float, Pattern]) -> str:
    """All members together, by depth, beside patterns that are known."""
    head = ("depth", "cells", "inside", "area", "sides", "variance", "area CV", "six-sided", "T")
    rows: list[Sequence[str]] = [head, ["---"] * len(head)]
    for depth, cells in found.items():
        numbers = (
            *(cells.whole_area, cells.sides, cells.sides_variance, cells.area_cv),
            *(cells.hexagonality, cells.t_share),
        )
        rows.append([f"{depth:g}", f"{cells.number}", f"{cells.interior}", *map(told, numbers)])
    rows.append(["Poisson-Voronoi", "", "", "", "6", "1.78", "0.529", "0.295", ""])
    rows.append(["Giant's Causeway", "", "", "", "5.65", "", "", "", ""])
    lines = "\n".join("| " + " | ".join(row) + " |" for row in rows)
    return f"All members at their last step, pooled by depth:\n\n{lines}"


def members(kept: dict) -> str:
    """Where the numbers come from."""
    head = ("member", "unknowns", "sweeps", "s", "commit", "command", "audit")
    rows = [
        (
            *(name, f"{m['unknowns']:,}", f"{m['sweeps']}", f"{m['seconds']}", m["commit"]),
            *(f"`{m['command']}`", "; ".join(m["violations"]) or "nothing"),
        )
        for name, m in kept.items()
    ]
    lines = (head, ["---"] * len(head), *rows)
    return "\n".join("| " + " | ".join(row) + " |" for row in lines)


if __name__ == "__main__":
    run_members()
