"""A crack driven by the field of a sharp tip that travels: its cost, its speed, its tip."""

import sys

from figures import Figure
from runs import ROOT

THEORY = "mode I field of a sharp crack"


def surfing(law: str, radius: float) -> list[Figure]:
    """The crack's cost and speed, and how far the sharp tip is beyond the damage, on two meshes."""
    sys.path.insert(0, str(ROOT / "tests"))
    from staffa.measure.tip import BEYOND, THRESHOLDS
    from test_surfing import ride

    figures = []
    for cells_per_ell in (4, 8):
        found = ride(law, cells_per_ell=cells_per_ell, radius=radius, cells=2 * cells_per_ell)
        on = f"{law}, h = ell/{cells_per_ell}"
        rows = [
            (f"energy of a new unit of crack, {on}", THEORY, 1.0, found.toughness, 0.03),
            (f"speed over that of the tip, {on}", THEORY, 1.0, float(found.speed[3]), 0.03),
        ]
        rows += [
            (f"sharp tip beyond alpha = {t:g}, less h/2, over ell, {on}", "in use", used, b, 0.05)
            for t, used, b in zip(THRESHOLDS, BEYOND[law], found.beyond.tolist(), strict=True)
        ]
        figures += [
            Figure(what=what, source=source, reference=ref, measured=measured, tolerance=tolerance)
            for what, source, ref, measured, tolerance in rows
        ]
    return figures
