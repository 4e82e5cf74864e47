"""Shapes of the cells of all kept runs, beside those of Poisson-Voronoi cells and hexagons."""

import json
from math import pi, sqrt

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.spatial import KDTree, Voronoi
from scipy.stats import goodness_of_fit, gumbel_l
from skimage.segmentation import find_boundaries

from staffa.measure.cells import cell_section
from staffa.measure.cells import cells as cells_of
from staffa.measure.patterns import Pattern, pattern
from staffa.records.step import CellSection
from verification.columns.run import KEPT, SIZES, sections, settled, told
from verification.common.figures import Figure, Found

POINTS, SEED = 20_000, 1  # of the sharp Poisson-Voronoi pattern
ACROSS, SIDE_BY_SIDE = 1.6, 20  # of drawn cells: as wide as those of the runs
ENOUGH = 100  # cells inside
# Poisson-Voronoi cells: Okabe, Boots, Sugihara and Chiu (2000). Those of 20,000 have 0.7 %.
KNOWN = {"variance of sides": 1.781, "area CV": 0.529, "part with six sides": 0.295}
SAMPLES = 499  # of the test of a distribution


def voronoi() -> dict[str, float]:
    """Numbers of Poisson-Voronoi cells of the plane, by Qhull; a margin is left out."""
    rng = np.random.default_rng(SEED)
    across = sqrt(POINTS)
    margin = 10.0
    points = rng.random((round((across + 2 * margin) ** 2), 2)) * (across + 2 * margin)
    found = Voronoi(points)
    inside = np.all((points > margin) & (points < margin + across), axis=1)
    areas, perimeters, sides = np.array(
        [
            _polygon(found.vertices[found.regions[found.point_region[i]]])
            for i in np.flatnonzero(inside)
        ]
    ).T
    return {
        "variance of sides": float(sides.var(ddof=1)),
        "area CV": float(areas.std(ddof=1) / areas.mean()),
        "part with six sides": float((sides == 6).mean()),
        "roundness": float((4 * pi * areas / perimeters**2).mean()),
        "its deviation": float((4 * pi * areas / perimeters**2).std(ddof=1)),
    }


def _polygon(corners: np.ndarray) -> tuple[float, float, int]:
    """Area, perimeter and number of sides."""
    after = np.roll(corners, -1, axis=0)
    area = abs(np.sum(corners[:, 0] * after[:, 1] - corners[:, 1] * after[:, 0])) / 2
    return area, float(np.linalg.norm(after - corners, axis=1).sum()), len(corners)


def drawn(points: np.ndarray, pixel: float, ell: float) -> CellSection:
    """Cells around points, cracked as by this ell, and read on pixels as those of a run."""
    pixels = round(SIDE_BY_SIDE * ACROSS / pixel)
    nearest = KDTree(points).query(np.argwhere(np.ones((pixels, pixels))) * pixel)[1]
    ridges = find_boundaries(nearest.reshape(pixels, pixels), mode="thick")
    distance = np.maximum(distance_transform_edt(~ridges) * pixel - pixel / 2, 0)
    alpha = np.clip(1 - distance / (2 * ell), 0, 1) ** 2
    seen = cells_of(alpha, pixel=(pixel, pixel), ell=ell, threshold=0.8)
    return cell_section(seen, depth=0.0, pixel=(pixel, pixel))


def roundness(found: list[CellSection]) -> np.ndarray:
    """4 pi A/P^2 of the cells inside, P as measured on the pixels."""
    areas, perimeters, ends = (
        np.array([x for section in found for x in getattr(section, name)], dtype=float)
        for name in ("areas", "perimeters", "ends")
    )
    inside = ends == 0
    return np.asarray(4 * pi * areas[inside] / perimeters[inside] ** 2)


def hexagonal_points() -> np.ndarray:
    """Middles of regular hexagons of the area of a circle ACROSS wide."""
    p = ACROSS / sqrt(2 * sqrt(3) / pi)
    rows = np.arange(0, SIDE_BY_SIDE * ACROSS, p * sqrt(3) / 2)
    return np.array(
        [(y, x + p / 2 * (n % 2)) for n, y in enumerate(rows)
         for x in np.arange(0, SIDE_BY_SIDE * ACROSS, p)]
    )  # fmt: skip


def shapes() -> Found:
    """Numbers of the pooled cells by depth, and of known patterns."""
    kept = json.loads(KEPT.read_text())
    one = next(iter(kept.values()))
    pixel, ell = one["cells"][0]["pixel"][0], one["ell"]
    rng = np.random.default_rng(SEED)
    anywhere = rng.random((round(SIDE_BY_SIDE**2 * 4 / pi), 2)) * SIDE_BY_SIDE * ACROSS
    pooled = {
        f"depth {depth:g}": [s for size in SIZES for s in sections(kept, size)[depth]]
        for depth in settled(kept)
    }
    read = {
        "Poisson-Voronoi, drawn": [drawn(anywhere, pixel, ell)],
        "regular hexagons, drawn": [drawn(hexagonal_points(), pixel, ell)],
    }
    rows = {name: (pattern(found), roundness(found)) for name, found in (pooled | read).items()}
    sharp = voronoi()
    figures = [_known(name, value, sharp[name]) for name, value in KNOWN.items()]
    figures += _ordered(rows[max(pooled)][0], rows["Poisson-Voronoi, drawn"][0], max(pooled))
    most = max(rows[name][0].interior for name in pooled)
    figures.append(
        Figure(
            what="cells inside at one depth, all runs together",
            source="asked for",
            reference=ENOUGH,
            measured=most,
            tolerance=0,
            bound="least",
        )
    )
    return Found(figures=figures, text=_table(rows, sharp))


def _known(name: str, expected: float, measured: float) -> Figure:
    """A number of Poisson-Voronoi cells, computed here."""
    return Figure(
        what=f"Poisson-Voronoi, {name}",
        source="Okabe, Boots, Sugihara and Chiu (2000)",
        reference=expected,
        measured=measured,
        tolerance=0.03,  # four standard errors
        relative=True,
    )


def _ordered(cells: Pattern, anywhere: Pattern, name: str) -> list[Figure]:
    """Cells of the runs are nearer to hexagons than those around points that lie anywhere."""
    pairs = (
        ("area CV", cells.area_cv, anywhere.area_cv, "most"),
        ("variance of sides", cells.sides_variance, anywhere.sides_variance, "most"),
        ("part with six sides", cells.hexagonality, anywhere.hexagonality, "least"),
    )
    return [
        Figure(
            what=f"{what} at {name} (error {mine.error:.2g})",
            source="nearer to hexagons than Poisson-Voronoi cells that are read the same way",
            reference=other.value,
            measured=mine.value,
            tolerance=0.0,
            bound="most" if bound == "most" else "least",
        )
        for what, mine, other, bound in pairs
        if mine.value is not None and other.value is not None
    ]


def _table(rows: dict[str, tuple[Pattern, np.ndarray]], sharp: dict[str, float]) -> str:
    """All numbers, and how likely the roundness is if it follows a Gumbel law."""
    lines = [
        "| | inside | sides | variance | area CV | six-sided | 4 pi A/P^2 | deviation | Gumbel |",
        "|" + " --- |" * 9,
    ]
    for name, (cells, values) in rows.items():
        numbers = (cells.sides, cells.sides_variance, cells.area_cv, cells.hexagonality)
        error = values.std(ddof=1) / sqrt(len(values))
        shape = (f"{values.mean():.3f} ± {error:.2g}", f"{values.std(ddof=1):.3f}", _gumbel(values))
        lines.append(
            "| " + " | ".join([name, f"{cells.interior}", *map(told, numbers), *shape]) + " |"
        )
    exact = [f"{sharp[n]:.3f}" for n in ("variance of sides", "area CV", "part with six sides")]
    round_ones = [f"{sharp[name]:.3f}" for name in ("roundness", "its deviation")]
    lines.append(
        "| " + " | ".join(["Poisson-Voronoi, sharp", "", "6", *exact, *round_ones, ""]) + " |"
    )
    lines.append("| regular hexagons, sharp | | 6 | 0 | 0 | 1 | 0.907 | 0 | |")
    return "\n".join(lines)


def _gumbel(values: np.ndarray) -> str:
    """Probability of a fit as bad as this one, if the law is that of Gumbel with a tail below."""
    if values.std() < 1e-3 or len(values) > 200:
        return ""
    found = goodness_of_fit(
        gumbel_l, values, statistic="ad", n_mc_samples=SAMPLES, rng=np.random.default_rng(SEED)
    )
    return f"{found.pvalue:.2f}"
