"""A crack driven by the field of a sharp tip that travels: its cost, its speed, its tip."""

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from staffa.measure.tip import THRESHOLDS, tip_distances
from verification.common.figures import Check, Figure, Found
from verification.common.symmetric_cracks import ON_A_SIDE

if TYPE_CHECKING:
    from fem.test_surfing import Ride

# Cells that the tip travels: a crack of AT2, whose profile is wide, is steady only then.
CELLS = {"AT1": 12, "AT2": 24}
THEORY = "mode I field of a sharp crack"
MESHES = (3, 4, 5, 6, 8)  # cells in ell of AT1, to tell what they change
ASKED = (4, 8)  # of these, those with figures


def ridden(law: str, mesh: int) -> "Ride":
    """Return the ride of a crack on cells of ell over `mesh`."""
    from fem.test_surfing import ride

    return ride(law, cells_per_ell=mesh, radius=8, cells=CELLS[law])


def surfing(law: str, mesh: int, found: "Ride") -> list[Figure]:
    """Return the crack's cost and speed, and how far the sharp tip is beyond the damage.

    Parameters
    ----------
    law : the damage law.
    mesh : cells in ell.
    found : the ride on them.
    """
    on, in_use = f"{law}, h = ell/{mesh}", tip_distances(law, h=1 / mesh)
    assert in_use is not None
    cost = found.toughness / found.factor
    rows = [
        (f"energy of a new unit of crack, {on}", THEORY, 1.0, cost, 0.03),
        (f"speed over that of the tip, {on}", THEORY, 1.0, float(found.speed[3]), 0.03),
    ]
    rows += [
        (f"sharp tip beyond alpha = {t:g}, less h/2, over ell, {on}", "in use", used, b, 0.05)
        for t, used, b in zip(THRESHOLDS, in_use.tolist(), found.beyond.tolist(), strict=True)
    ]
    return [
        Figure(what=what, source=source, reference=ref, measured=measured, tolerance=tolerance)
        for what, source, ref, measured, tolerance in rows
    ]


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
    rides = {mesh: ridden("AT1", mesh) for mesh in MESHES}
    figures = [figure for mesh in ASKED for figure in surfing("AT1", mesh, rides[mesh])]
    figures += [*surfing("AT2", 4, ridden("AT2", 4)), *on_a_side()]
    beyond = np.array([rides[mesh].beyond for mesh in MESHES])
    slopes, ends = np.polyfit(1 / np.array(MESHES), beyond, 1)
    lines = [
        "Distance of the sharp tip over ell beyond a damage, less h/2, with AT1. The last lines "
        "are the straight line in h through all meshes: `measure/tip.py` has rounded it.",
        "",
        f"| cells | {' | '.join(f'{t:g}' for t in THRESHOLDS)} |",
        "|" + " --- |" * (len(THRESHOLDS) + 1),
        *(f"| ell/{mesh} | {_row(rides[mesh].beyond)} |" for mesh in MESHES),
        f"| h over ell times | {_row(slopes)} |",
        f"| plus | {_row(ends)} |",
    ]
    return Found(figures=figures, text="\n".join(lines))


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
