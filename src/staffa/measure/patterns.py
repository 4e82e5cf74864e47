"""Statistics of the polygonal cells of one plane, or of several similar ones, with their errors.

docs/how-to/columns.md has the formulas, and their values for known patterns.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import sqrt
from warnings import catch_warnings

import numpy as np
from scipy.stats import bootstrap

from staffa.measure.borders import Junction
from staffa.records.step import CellSection

# Errors are the spread among this number of samples drawn from the cells, always the same ones.
# They are known to 1/sqrt(2 SAMPLES), 2 %.
SAMPLES = 1000
SEED = 0
FEWEST = 5  # cells from which an error is estimated
HEXAGON = 6


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """Number with its standard error.

    Attributes
    ----------
    value : the number; None if there are too few cells.
    error : its standard error; None if there are too few cells.
    """

    value: float | None
    error: float | None


@dataclass(frozen=True, kw_only=True)
class Pattern:
    """Statistics of polygonal cells.

    Interior cells touch no end of the body.

    Attributes
    ----------
    sections : number of planes that were pooled.
    number : number of all cells.
    interior : number of interior cells.
    histogram : number of interior cells by their number of sides.
    junctions : number of junctions of each type.
    area : mean area of interior cells (m^2).
    diameter : mean of sqrt(4 area/pi) of interior cells (m).
    area_cv : standard deviation over mean of the areas of interior cells.
    sides : mean number of sides of interior cells.
    sides_variance : variance of the number of sides of interior cells.
    hexagonality : part of the interior cells that have six sides.
    disorder : mean of (sides - 6)^2 of interior cells.
    whole_area : mean area of all cells (m^2); a cell at an end of the body counts half, one in a
        corner a quarter.
    spacing : area over the length of the cracks in it (m).
    t_share : part of the T and Y junctions that are a T.
    """

    sections: int
    number: int
    interior: int
    histogram: dict[int, int]
    junctions: dict[str, int]
    area: Estimate
    diameter: Estimate
    area_cv: Estimate
    sides: Estimate
    sides_variance: Estimate
    hexagonality: Estimate
    disorder: Estimate
    whole_area: Estimate
    spacing: Estimate
    t_share: Estimate


def pattern(sections: Sequence[CellSection]) -> Pattern:
    """Return the statistics of the cells of all planes, each cell taken as drawn independently."""
    areas, perimeters, sides, ends = (
        np.array([value for section in sections for value in getattr(section, name)], dtype=float)
        for name in ("areas", "perimeters", "sides", "ends")
    )
    inside = ends == 0
    six = int((sides[inside] == HEXAGON).sum())
    junctions = Counter[str]()
    for section in sections:
        junctions.update(section.junctions)
    return Pattern(
        sections=len(sections),
        number=len(areas),
        interior=int(inside.sum()),
        histogram=dict(sorted(Counter(sides[inside].astype(int).tolist()).items())),
        junctions={str(kind): junctions[kind] for kind in Junction},
        **_estimates(INTERIOR, _of_interior, areas[inside], sides[inside]),
        hexagonality=_share(six, int(inside.sum()) - six),
        **_estimates(ALL, _of_all, areas, perimeters, 0.5**ends),
        t_share=_share(junctions[Junction.T], junctions[Junction.Y]),
    )


INTERIOR = ("area", "diameter", "area_cv", "sides", "sides_variance", "disorder")
ALL = ("whole_area", "spacing")


def _of_interior(areas: np.ndarray, sides: np.ndarray, axis: int = -1) -> np.ndarray:
    """Return the numbers of INTERIOR, stacked; the last axis of both arrays is the cell."""
    numbers = (
        areas.mean(axis=axis),
        np.sqrt(4 * areas / np.pi).mean(axis=axis),
        areas.std(axis=axis, ddof=1) / areas.mean(axis=axis),
        sides.mean(axis=axis),
        sides.var(axis=axis, ddof=1),
        ((sides - HEXAGON) ** 2).mean(axis=axis),
    )
    return np.stack(numbers)


def _of_all(
    areas: np.ndarray, perimeters: np.ndarray, shares: np.ndarray, axis: int = -1
) -> np.ndarray:
    """Return the numbers of ALL, stacked; a perimeter counts half, since two cells share it."""
    whole = areas.sum(axis=axis)
    return np.stack([whole / shares.sum(axis=axis), 2 * whole / perimeters.sum(axis=axis)])


def _estimates(
    names: tuple[str, ...], numbers: Callable[..., np.ndarray], *of: np.ndarray
) -> dict[str, Estimate]:
    """Return each number and its standard error by the bootstrap (Efron, Ann. Stat. 7, 1979)."""
    n = len(of[0])
    if n == 0:
        return dict.fromkeys(names, Estimate(value=None, error=None))
    # A number that is not defined, such as the variance of one cell, becomes None.
    with catch_warnings(action="ignore", category=RuntimeWarning):
        values = numbers(*of)
        errors = np.full(len(names), np.nan)
        if n >= FEWEST:
            drawn = bootstrap(
                of,
                numbers,
                paired=True,
                vectorized=True,
                n_resamples=SAMPLES,
                method="percentile",
                rng=np.random.default_rng(SEED),
            )
            errors = drawn.standard_error * sqrt(n / (n - 1))
            errors[errors == 0] = np.nan  # all cells are alike: the spread of others is not known
    return {
        name: Estimate(value=_known(value), error=_known(error))
        for name, value, error in zip(names, values, errors, strict=True)
    }


def _known(number: float) -> float | None:
    return float(number) if np.isfinite(number) else None


def _share(these: int, others: int) -> Estimate:
    """Return a part and its standard error (Agresti and Coull, Am. Stat. 52, 1998).

    The error is not zero if all are alike.
    """
    n = these + others
    if not n:
        return Estimate(value=None, error=None)
    part = (these + 2) / (n + 4)
    error = sqrt(part * (1 - part) / (n + 4)) if n >= FEWEST else None
    return Estimate(value=these / n, error=error)
