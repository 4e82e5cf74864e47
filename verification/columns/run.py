"""Columns in a block cooled from below, and in one twice as wide: run once, kept as one small file.

    python -m verification.columns.run

runs the members (hours), and keeps what `make verify ONLY=columns` looks at. Those
that are in runs/verification/columns, by hand on more ranks say, are taken as they are.
"""

import json
import shutil
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from math import hypot, pi, sqrt
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.spatial import KDTree
from skimage.segmentation import find_boundaries

from staffa.case.reading.read import parse_case
from staffa.io.run_directory import Run
from staffa.measure.cells import cell_section
from staffa.measure.cells import cells as cells_of
from staffa.measure.patterns import Estimate, Pattern, pattern
from staffa.physics.doubling import spacing_at
from staffa.records.step import CellSection
from staffa.report.drawing import draw
from verification.common.figures import Check, Figure, Found
from verification.common.runs import ROOT, keep, origin, run_once

CASE = "verification/columns/case.toml"
KEPT = Path(__file__).parent / "kept.json"
SIZES = {"single": (2.5, tuple(range(1, 9))), "doubled": (5.0, tuple(range(1, 7)))}  # width, seeds
SHOWN = "doubled-1"  # the one that the README shows too
SETTLED = 0.95  # of the cells at a depth were there a step before: no cracks are arriving
CHANGE = 0.1  # of size and depth that is none
LEAVE = 0.25  # in place of it at most, where the standard error is larger
INSIDE = 0.8  # of the depth of the body
ENOUGH = 30  # cells that no end of the body cuts
SURE = 3  # standard errors
DEPTHS = 3  # to compare
# Poisson-Voronoi cells to compare with: as wide as those of the block, and how many side by side.
DRAWN_ACROSS, DRAWN_CELLS = (0.8, 1.2), 25
PICTURES = ROOT / "docs" / "pictures"
DRAWN = ("verify-columns.png", "verify-columns-sections.png", "verify-columns-size.png")
SHARP = "sharp-crack finite elements, half-space, ell0 for two blocked directions"


def settings(width: float, seed: int) -> list[str]:
    """The settings of a member."""
    return [f"domain.size=[{width},{width},1.0]", f"toughness.seed={seed}"]


def run_members() -> dict:
    """Run the members, or take those that are there, and keep their cells."""
    kept = {}
    for name, (width, seeds) in SIZES.items():
        for seed in seeds:
            member, asked = f"{name}-{seed}", settings(width, seed)
            run = run_once(CASE, f"columns/{member}", asked)
            kept[member] = origin(run, CASE, asked) | digest(run)
            if member == SHOWN:
                draw(run, movie=False)  # quiet runs leave no pictures
                for picture, drawn in zip(("cracks.png", "sections.png"), DRAWN, strict=False):
                    shutil.copy(run.path / "pictures" / picture, PICTURES / drawn)
    keep(KEPT, kept)
    return kept


def digest(run: Run) -> dict:
    """The numbers that are kept of a run."""
    before, step = run.steps[-2:]  # it ends before a crack runs through to the far face
    assert step.measures is not None and before.measures is not None
    return {
        "nu": float(parse_case(run.case).material.nu),
        "ell0": run.manifest.scales["ell0"],
        "ell": run.manifest.ell,
        "width": run.manifest.size[0],
        "toughness_factor": run.manifest.toughness_factor,
        "sweeps": sum(step.sweeps for step in run.steps),
        "tau": step.tau,
        "fronts": [round(s.measures.front, 4) for s in run.steps if s.measures is not None],
        "area": round(step.measures.length_surface, 4),
        "violations": [sentence for s in run.steps if s.audit for sentence in s.audit.violations],
        "number before": [section.number for section in before.measures.cells],
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
        for record in member["cells"] if name.startswith(size) else ():
            found.setdefault(record["depth"], []).append(CellSection(**record))
    return found


def columns() -> Found:
    """A block and its double; spacing against depth; the deepest cells."""
    kept = json.loads(KEPT.read_text()) if KEPT.exists() else run_members()
    still = settled(kept)
    patterns = {
        size: {depth: pattern(found) for depth, found in sections(kept, size).items()}
        for size in SIZES
    }
    there = {size: {d: found[d] for d in still} for size, found in patterns.items()}
    one = next(iter(kept.values()))
    ell0 = one["ell0"] * one["toughness_factor"]  # cracks cost what they cost on these cells
    cells_ell0 = ell0 * (1 + one["nu"]) / 2  # if both lateral stresses go: docs/how-to/columns.md
    draw_sizes(there, ell0, cells_ell0)
    pictures = "\n".join(f"![Columns](pictures/{name})" for name in DRAWN)
    wide = there["doubled"]  # fewer of its cells are at walls
    figures = [*alike(kept, there), *growing(wide), *spaced(wide, ell0)]
    beside_p = beside(wide, ell0, cells_ell0)
    parts = [
        table(patterns["doubled"], one["tau"], max(still, default=0.0), drawn(kept)),
        beside_p,
        members(kept),
        pictures,
    ]
    return Found(figures=figures, text="\n\n".join(parts))


def settled(kept: dict) -> list[float]:
    """The depths at which cracks have arrived: hardly any cells are newer than a step."""
    depths = [section["depth"] for section in next(iter(kept.values()))["cells"]]
    now = np.sum([[len(s["areas"]) for s in m["cells"]] for m in kept.values()], axis=0)
    before = np.sum([m["number before"] for m in kept.values()], axis=0)
    return [d for d, n, b in zip(depths, now, before, strict=True) if n and b >= SETTLED * n]


def draw_sizes(patterns: dict[str, dict[float, Pattern]], ell0: float, cells_ell0: float) -> None:
    """Spacing, and size of the cells of each size of the block, against depth."""
    figure, axes = plt.subplots(figsize=(7, 4))
    depths = np.linspace(0.05, 0.65, 50)
    p = spacing_at(depths, ell0)
    label = "spacing of parallel cracks, from p(a) to 2 p(a)"
    axes.fill_between(depths, p, 2 * p, color="C0", alpha=0.2, label=label)
    axes.plot(depths, spacing_at(depths, cells_ell0), "C0:", label="p(a) if both stresses go")
    lines = [
        (
            patterns["doubled"],
            "ks-",
            "spacing, doubled: area over length of the cracks",
            lambda cells: cells.spacing,
        ),
        *(
            (patterns[size], f"C1{marker}--", f"diameter, {size}", across)
            for marker, size in zip("o^", SIZES, strict=True)
        ),
    ]
    for found, style, name, number in lines:
        at, values, errors = zip(*known(found, number), strict=True)
        axes.errorbar(at, values, errors, fmt=style, capsize=3, label=name)
    axes.set(xlabel="depth", ylabel="length", xlim=(0, 0.65), ylim=(0, None))
    axes.legend(frameon=False, fontsize=9)
    figure.savefig(PICTURES / DRAWN[2], dpi=120, bbox_inches="tight")
    plt.close(figure)


def known(
    found: dict[float, Pattern], number: Callable[[Pattern], Estimate]
) -> Iterator[tuple[float, float, float]]:
    """Depth, number and its standard error (NaN if not known), where the rock is cut."""
    for depth, cells in cut(found).items():
        estimate = number(cells)
        if estimate.value is not None:
            yield depth, estimate.value, estimate.error or float("nan")


def across(cells: Pattern) -> Estimate:
    """Diameter of the circle of the mean area."""
    area = cells.whole_area
    if area.value is None:
        return area
    size = sqrt(4 * area.value / pi)
    return Estimate(value=size, error=area.error and size * area.error / area.value / 2)


def cut(found: dict[float, Pattern]) -> dict[float, Pattern]:
    """The depths at which the rock is cut into cells, enough of them to know an error."""
    return {
        depth: cells
        for depth, cells in found.items()
        if cells.number >= 2 * cells.sections and cells.whole_area.error is not None
    }


def alike(kept: dict, patterns: dict[str, dict[float, Pattern]]) -> Iterator[Figure]:
    """Size of cells at equal depth, and depth of penetration, of the block and its double."""
    singles, doubles = (cut(patterns[size]) for size in SIZES)
    both = [depth for depth in singles if depth in doubles]
    yield enough("depths at which both sizes of the block are cut into cells", len(both), DEPTHS)
    for depth in both:
        for name, size in (("diameter", across), ("spacing", lambda cells: cells.spacing)):
            one, two = size(singles[depth]), size(doubles[depth])
            assert one.value and one.error and two.value and two.error
            error = hypot(one.error / one.value, two.error / two.value)
            yield Figure(
                what=f"{name} of cells at depth {depth:g}, doubled over single (error {error:.2f})",
                source=f"as large, to 10 % or the standard error (no more than {LEAVE})",
                reference=1.0,
                measured=two.value / one.value,
                tolerance=min(max(CHANGE, error), LEAVE),
            )
    surface = {
        size: np.mean([m["area"] / m["width"] ** 2 for m in members_of(kept, size)])
        for size in SIZES
    }
    yield Figure(
        what="crack area over that of the face, doubled over single",
        source=f"the same; single: {surface['single']:.3g}",
        reference=1.0,
        measured=float(surface["doubled"] / surface["single"]),
        tolerance=CHANGE,
    )
    # The deepest tip below as much of a face: of each four single blocks, and of each doubled one.
    fronts = {s: np.array([m["fronts"] for m in members_of(kept, s)]) for s in SIZES}
    fours = [fronts["single"][n : n + 4].max(axis=0) for n in range(0, len(fronts["single"]), 4)]
    deepest = {"single": np.mean(fours, axis=0), "doubled": fronts["doubled"].mean(axis=0)}
    highest = np.maximum(fronts["single"].max(axis=0), fronts["doubled"].max(axis=0))
    last = int(np.flatnonzero(highest < INSIDE)[-1])  # before the opposite boundary affects cracks
    yield Figure(
        what=f"deepest tip at step {last}, below a doubled block and below four single ones",
        source=f"the same depth; single: {deepest['single'][last]:.3g}",
        reference=1.0,
        measured=float(deepest["doubled"][last] / deepest["single"][last]),
        tolerance=CHANGE,
    )


def growing(both: dict[float, Pattern]) -> Iterator[Figure]:
    """That cells widen with depth, and that there are enough of them."""
    most = max(cells.interior for cells in both.values())
    yield enough("cells that no end of the body cuts, at one depth", most, ENOUGH)
    sizes = [across(cells) for cells in cut(both).values()]
    yield enough("depths at which there are cells", len(sizes), DEPTHS)
    if len(sizes) < DEPTHS:
        return
    steps = [
        deeper.value > size.value - hypot(size.error, deeper.error)
        for size, deeper in pairwise(sizes)
        if size.value and size.error and deeper.value and deeper.error
    ]
    yield Figure(
        what="part of the depths at which cells are as wide as at the depth before, or wider",
        source="cells widen as others close, within standard errors",
        reference=1.0,
        measured=float(np.mean(steps)),
        tolerance=0,
    )
    least, greatest = sizes[0], sizes[-1]
    assert least.value and least.error and greatest.value and greatest.error
    growth = (greatest.value - least.value) / hypot(least.error, greatest.error)
    yield enough(
        f"diameter at the greatest depth over that at the least, "
        f"{greatest.value / least.value:.2f}, over 1 by errors",
        growth,
        SURE,
    )


def enough(what: str, number: float, least: float) -> Figure:
    """That a number is no less than this."""
    return Figure(
        what=what, source="asked for", reference=least, measured=number, tolerance=0, bound="least"
    )


def spaced(both: dict[float, Pattern], ell0: float) -> Iterator[Figure]:
    """Size at each depth, from where cracks stop to where they have stopped.

    Twice: as area of rock over length of crack, which is the spacing of parallel cracks that cost
    as much, and as the diameter of the cells, about how far cracks are from one another.
    """
    for depth, cells in cut(both).items():
        p = float(spacing_at(depth, ell0)) / ell0
        for name, size in (("spacing", cells.spacing), ("diameter", across(cells))):
            if size.value is not None:
                yield Figure(
                    what=f"{name} at depth {depth:g}, over ell0",
                    source=f"{SHARP}: from p to 2 p, p = {p:.3g}",
                    reference=1.5 * p,
                    measured=size.value / ell0,
                    tolerance=0.5 * p,
                )


def beside(both: dict[float, Pattern], ell0: float, cells_ell0: float) -> str:
    """Sizes beside the spacing of parallel cracks, and what columns may be expected to have."""
    head = ("depth", "spacing", "diameter", "p", "2 p", "p, both stresses gone")
    rows: list[Sequence[str]] = [head, ["---"] * len(head)]
    for depth, cells in cut(both).items():
        p, less = float(spacing_at(depth, ell0)), float(spacing_at(depth, cells_ell0))
        sizes = (told(cells.spacing), told(across(cells)))
        rows.append([f"{depth:g}", *sizes, *(f"{x:.3g}" for x in (p, 2 * p, less))])
    lines = "\n".join("| " + " | ".join(row) + " |" for row in rows)
    return (
        "The doubled blocks, beside parallel cracks (ell0 with the effective Gc of these "
        "cells). Two things bring columns closer than parallel cracks. They release both lateral "
        "stresses, for which the right column is the bound (docs/how-to/columns.md). And alternate "
        "minimization alone may pass the loss of stability at which every other crack should "
        "arrest, as alike cracks do (every other crack arrests, above). "
        f"Cells of the least depths are those of nucleation.\n\n{lines}"
    )


def members_of(kept: dict, size: str) -> list[dict]:
    """The members of one size of the block."""
    return [member for name, member in kept.items() if name.startswith(size)]


def drawn(kept: dict) -> dict[str, Pattern]:
    """Cells around points that lie anywhere, cracked as by this ell and read off on this raster."""
    one = next(iter(kept.values()))
    ell, pixel = one["ell"], one["cells"][0]["pixel"][0]
    found = {}
    for size in DRAWN_ACROSS:
        rng = np.random.default_rng(1)
        pixels = round(DRAWN_CELLS * size / pixel)
        points = rng.random((round(DRAWN_CELLS**2 * 4 / pi), 2)) * pixels
        nearest = KDTree(points).query(np.argwhere(np.ones((pixels, pixels))))[1]
        ridges = find_boundaries(nearest.reshape(pixels, pixels), mode="thick")
        distance = np.maximum(distance_transform_edt(~ridges) * pixel - pixel / 2, 0)
        alpha = np.clip(1 - distance / (2 * ell), 0, 1) ** 2
        seen = cells_of(alpha, pixel=(pixel, pixel), ell=ell, threshold=0.8)
        name = f"Poisson-Voronoi, {size:g} across, ell = {ell:g}"
        found[name] = pattern([cell_section(seen, depth=0.0, pixel=(pixel, pixel))])
    return found


def told(number: Estimate) -> str:
    """A number with its standard error."""
    if number.value is None:
        return "-"
    return f"{number.value:.3g}" + (f" ± {number.error:.2g}" if number.error is not None else "")


def table(
    found: dict[float, Pattern], tau: float, deepest: float, known: dict[str, Pattern]
) -> str:
    """The doubled blocks together, by depth, beside patterns that are known."""
    head = ("depth", "cells", "inside", "area", "sides", "variance", "area CV", "six-sided", "T")
    rows: list[Sequence[str]] = [head, ["---"] * len(head)]
    named = {f"{depth:g}": cells for depth, cells in found.items()} | known
    for name, cells_there in named.items():
        numbers = (
            *(cells_there.whole_area, cells_there.sides, cells_there.sides_variance),
            *(cells_there.area_cv, cells_there.hexagonality, cells_there.t_share),
        )
        counts = (f"{cells_there.number}", f"{cells_there.interior}")
        rows.append([name, *counts, *map(told, numbers)])
    rows.append(["Poisson-Voronoi, sharp", "", "", "", "6", "1.78", "0.529", "0.295", ""])
    rows.append(["Giant's Causeway", "", "", "", "5.65", "", "", "", ""])
    lines = "\n".join("| " + " | ".join(row) + " |" for row in rows)
    return (
        f"The doubled blocks at tau = {tau:g}, pooled by depth, beside patterns that are known. "
        f"Cracks have arrived down to {deepest:g}, the deepest section to compare.\n\n{lines}"
    )


def members(kept: dict) -> str:
    """The source of the numbers."""
    head = ("member", "displacement unknowns", "sweeps", "s", "commit", "command", "audit")
    rows = [
        (
            *(
                name,
                f"{m['unknowns'] * 3 // 4:,}",
                f"{m['sweeps']}",
                f"{m['seconds']}",
                m["commit"],
            ),
            *(f"`{m['command']}`", "; ".join(m["violations"]) or "nothing"),
        )
        for name, m in kept.items()
    ]
    lines = (head, ["---"] * len(head), *rows)
    return "\n".join("| " + " | ".join(row) + " |" for row in lines)


CHECKS = {
    "columns": Check(
        title="Columns",
        text=(
            "A block like the ready case `brick`, coarser (ell = 1.8 h), and the same twice as "
            "wide in both directions, several seeds each. Areas are means in which a cell at a "
            "roller counts half, and one in a corner a quarter. The diameter is that of the circle "
            "of this area, the spacing area over "
            "length of the cracks. Both are compared with parallel cracks, at the depths that "
            "cracks have reached. With halves and quarters added up, a single block has one and a "
            "half to three whole cells there, a doubled one eight to fourteen. We assume that "
            "walls count for more in the narrow one, and compare the other with theory. Below they "
            "are held against [a theory of columns](#columns-against-a-theory-of-columns) too."
        ),
        measure=columns,
        kept="kept.json",
    ),
}


if __name__ == "__main__":
    run_members()
