"""A crack driven by the field of a sharp tip that travels: its cost, its speed, its tip."""

from collections.abc import Iterable

import numpy as np

from staffa.measure.tip import THRESHOLDS, tip_distances
from verification.common.figures import Check, Figure, Found
from verification.common.symmetric_cracks import ON_A_SIDE

# Cells that the tip travels: a crack of AT2, whose profile is wide, is steady only then.
CELLS = {"AT1": 12, "AT2": 24}
THEORY = "mode I field of a sharp crack"
# Cells in ell, of AT1: figures are of the first two; the others only tell what the cells change.
MESHES = (4, 8, 3, 5, 6)


def surfing(law: str, meshes: tuple[int, ...]) -> list[Figure]:
    """The crack's cost and speed, and how far the sharp tip is beyond the damage."""
    from fem.test_surfing import ride

    figures = []
    for cells_per_ell in meshes:
        found = ride(law, cells_per_ell=cells_per_ell, radius=8, cells=CELLS[law])
        on = f"{law}, h = ell/{cells_per_ell}"
        in_use = tip_distances(law, h=1 / cells_per_ell)
        assert in_use is not None
        rows = [
            (
                f"energy of a new unit of crack, {on}",
                THEORY,
                1.0,
                found.toughness / found.factor,
                0.03,
            ),
            (f"speed over that of the tip, {on}", THEORY, 1.0, float(found.speed[3]), 0.03),
        ]
        rows += [
            (f"sharp tip beyond alpha = {t:g}, less h/2, over ell, {on}", "in use", used, b, 0.05)
            for t, used, b in zip(THRESHOLDS, in_use.tolist(), found.beyond.tolist(), strict=True)
        ]
        figures += [
            Figure(what=what, source=source, reference=ref, measured=measured, tolerance=tolerance)
            for what, source, ref, measured, tolerance in rows
        ]
    return figures


def on_a_side() -> list[Figure]:
    """Measure the cost of a crack on a plane of symmetry, on the cells of cases that have one."""
    from fem.test_surfing import ride

    figures = []
    for case, (cells_per_ell, used) in ON_A_SIDE.items():
        found = ride("AT1", cells_per_ell=cells_per_ell, radius=10, cells=12, on_a_side=used)
        figures.append(
            Figure(
                what=f"energy of a unit of crack on a side over Gc, cells of {case}",
                source="in use",
                reference=used,
                measured=found.toughness,
                tolerance=0.01,
            )
        )
    return figures


def tips() -> Found:
    """Return figures of both laws and of cracks on a side, and the tips on all meshes of AT1."""
    figures = [*surfing("AT1", MESHES[:2]), *surfing("AT2", (4,)), *on_a_side()]
    known = {mesh: distances(figures, mesh) for mesh in MESHES[:2]}
    known |= {mesh: distances(surfing("AT1", (mesh,)), mesh) for mesh in MESHES[2:]}
    over_h = 1 / np.array(sorted(known))
    columns = np.array([known[mesh] for mesh in sorted(known)])
    slopes, ends = np.polyfit(over_h, columns, 1)
    lines = [
        "Distance of the sharp tip over ell beyond a damage, less h/2, with AT1. The last lines "
        "are the straight line in h through all meshes: `measure/tip.py` has rounded it.",
        "",
        f"| cells | {' | '.join(f'{t:g}' for t in THRESHOLDS)} |",
        "|" + " --- |" * (len(THRESHOLDS) + 1),
        *(f"| ell/{mesh} | {_row(known[mesh])} |" for mesh in sorted(known)),
        f"| h over ell times | {_row(slopes)} |",
        f"| plus | {_row(ends)} |",
    ]
    return Found(figures=figures, text="\n".join(lines))


def distances(figures: list[Figure], mesh: int) -> list[float]:
    """Return the distances of the tip on a mesh of AT1, one for each of THRESHOLDS."""
    of = f"AT1, h = ell/{mesh}"
    return [f.measured for f in figures if f.what.startswith("sharp tip") and f.what.endswith(of)]


def _row(values: Iterable[float]) -> str:
    return " | ".join(f"{value:.3f}" for value in values)


CHECKS = {
    "surfing": Check(
        title="A crack that follows a tip",
        text=(
            "The whole edge of a plate is displaced as by a sharp crack whose tip travels, loaded "
            "at Gc. The distance of this tip from the damage calibrates the sharp tip of all other "
            "runs (`measure/tip.py`); nothing else does. Half height of the plate: 8 ell. A crack "
            "on a plane of symmetry breaks cells on both sides of it and costs more: cases with "
            "such cracks take their Gc from here. Cost: over the effective Gc."
        ),
        measure=tips,
    ),
}
