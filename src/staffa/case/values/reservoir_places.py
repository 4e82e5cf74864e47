"""Case -> where its reservoir is: its corners, its fractures, and the place of each well."""

import numpy as np

from staffa.case.schema.case import Case
from staffa.case.schema.fracture_keys import FractureDisc, FractureLine, FractureSide
from staffa.case.schema.reservoir_keys import ReservoirKeys, WellKeys
from staffa.geometry.block import SIDES
from staffa.geometry.places import SAME
from staffa.records.reservoir_facts import CrackRule
from staffa.reservoir.grid import FAR
from staffa.reservoir.permeability import CELLS
from staffa.reservoir.simulator import Fracture

OF_FEEDBACK = ("openings", "coupling", "agreement", "shadow")
ALONG = 21  # sampled places along each axis
BAND = 2.0  # regularization lengths: half of the width of damage


def reservoir_keys(case: Case) -> ReservoirKeys:
    """Return the table [reservoir] of a case that has one."""
    assert case.reservoir is not None
    return case.reservoir


def fractured_sides(case: Case) -> dict[str, FractureSide]:
    """Return the fractures along sides of the body, by the side."""
    given = reservoir_keys(case).fractures
    return {fracture.side: fracture for fracture in given if isinstance(fracture, FractureSide)}


def other_fractures(case: Case) -> tuple[FractureLine | FractureDisc, ...]:
    """Return the fractures that lie in the reservoir: lines or discs."""
    given = reservoir_keys(case).fractures
    return tuple(fracture for fracture in given if not isinstance(fracture, FractureSide))


def side_fractures(case: Case) -> tuple[Fracture, ...]:
    """Return the same as a simulator knows them."""
    return tuple(
        Fracture(
            side=SIDES[case.dim][side],
            opening=float(keys.opening),
            height=float(keys.height),
        )
        for side, keys in fractured_sides(case).items()
    )


def beyond(case: Case) -> dict[tuple[int, int], float]:
    """Return how far the reservoir goes on (m), by axis and end of the side."""
    given = reservoir_keys(case).beyond
    return {SIDES[case.dim][side]: float(length) for side, length in given.items()}


def cell_size(case: Case) -> float:
    """Return the edge of the reservoir's cells in the body (m)."""
    h = reservoir_keys(case).h
    return 2 * float(case.outline.h) if h is None else float(h)


def least_spread(case: Case) -> float:
    """Return the smallest radius (m) over which cracks may be spread: `CELLS` of them and 2 ell."""
    return max(CELLS * cell_size(case), BAND * float(case.damage.ell))


def differing(keys: ReservoirKeys) -> list[str]:
    """Return the names of keys of feedback that are not as they are by default."""
    fields = type(keys).model_fields
    return [
        name
        for name in OF_FEEDBACK
        if getattr(keys, name) != fields[name].get_default(call_default_factory=True)
    ]


def crack_rule(case: Case) -> CrackRule | None:
    """Return the rule by which cracks change the flow; None where they do not."""
    keys = reservoir_keys(case)
    if not keys.feedback:
        return None
    given = keys.openings
    return CrackRule(
        smallest=float(given.smallest),
        largest=float(given.largest),
        spread=least_spread(case) if given.spread is None else float(given.spread),
    )


def thickness(case: Case) -> float:
    """Return the extent across the plane of a 2-D reservoir (m)."""
    return float(reservoir_keys(case).thickness or 1.0)


def bounds(case: Case) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners of the reservoir (m), shape (dim,) each: body, beyond and fractures."""
    lower, upper = np.array(case.outline.lower), np.array(case.outline.upper)
    added = beyond(case)
    for fracture in side_fractures(case):
        added[fracture.side] = added.get(fracture.side, 0.0) + fracture.height / 2
    for (axis, end), length in added.items():
        (upper if end > 0 else lower)[axis] += end * length
    return lower, upper


def is_in_reservoir(case: Case, point: tuple[float, ...]) -> bool:
    """Return True if a point (m) of the body's dimension lies in the reservoir."""
    lower, upper = bounds(case)
    place, slack = np.array(point, dtype=float), SAME * float(np.max(upper - lower))
    return bool(np.all(place >= lower - slack) and np.all(place <= upper + slack))


def reservoir_extent(case: Case) -> str:
    """Return in words from where to where the reservoir goes."""
    low, high = (" ".join(f"{c:.4g}" for c in corner) for corner in bounds(case))
    return f"from ({low}) m to ({high}) m"


def well_place(case: Case, well: WellKeys) -> list[float]:
    """Return the place of a well (m), within the reservoir to the last digit."""
    return [float(c) for c in np.clip(np.array(well.at, dtype=float), *bounds(case))]


def reservoir_cells(case: Case) -> float:
    """Estimate the number of cells of the reservoir; beyond the body they grow."""
    h, counts = cell_size(case), []
    added = beyond(case)
    for axis, size in enumerate(case.outline.size):
        count = max(1.0, np.ceil(size / h))
        for (where, _), length in added.items():
            if where == axis:  # h (g + g^2 + ...) up to the length
                count += np.log1p(length * (FAR - 1) / (FAR * h)) / np.log(FAR)
        counts.append(count)
    for fracture in side_fractures(case):
        counts[fracture.side[0]] += 1
    return float(np.prod(counts))


def sampled(case: Case) -> np.ndarray:
    """Return places all over the reservoir, its corners included (m), shape (3, n)."""
    lower, upper = bounds(case)
    along = [np.linspace(low, high, ALONG) for low, high in zip(lower, upper, strict=True)]
    axes = np.meshgrid(*along, indexing="ij")
    x = np.zeros((3, axes[0].size))
    x[: case.dim] = [axis.ravel() for axis in axes]
    return x
