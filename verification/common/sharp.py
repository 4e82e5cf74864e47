"""The sharp-crack reference curves in verification/common/data."""

import csv
from pathlib import Path

import numpy as np

from staffa.physics.doubling import spacing_at

DATA = Path(__file__).parent / "data"
SHARP = "sharp-crack finite elements"
# tau and length at which every other crack of an even array of spacing 0.1285 stops.
DOUBLING = {"fixed": (0.1022, 0.1406), "free": (0.1117, 0.1478)}
# The same where it is tougher by 1 %, ends fixed.
PAIR = (0.100, 0.1356)


def array_growth(section: str) -> tuple[np.ndarray, np.ndarray]:
    """tau and length of the cracks of an even array of spacing 0.1285, before any doubling."""
    with (DATA / "array_growth.csv").open() as file:
        rows = [r for r in csv.DictReader(file) if r["mech"] == section]
    rows = [r for r in rows if r["generation"] == "1"]
    tau, a = np.array([(float(r["tau_erfc_y_over_tau"]), float(r["a"])) for r in rows]).T
    order = np.argsort(tau)
    return tau[order], a[order]


def half_space_spacing(a: float) -> float:
    """Spacing at which cracks of this length would double, in a half-space at severity 54."""
    return float(spacing_at(a, 54.0**-2))


def half_space_doubling(a: float) -> float:
    """The same for any drop: spacing and length over ell0."""
    return float(spacing_at(a, 1.0))


def length_at(section: str, spacing: float, tau: float) -> float:
    """Length of the cracks of an even array, interpolated in spacing and tau."""
    with (DATA / "spacing_and_doubling.csv").open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    rows = [row for row in rows if row["mech"] == section]
    taus = [float(name[2:]) for name in rows[0] if name.startswith("a@")]
    spacings = [float(row["spacing"]) for row in rows]
    lengths = [
        np.interp(tau, taus, [float(row[f"a@{t:.2f}"] or "nan") for t in taus]) for row in rows
    ]
    return float(np.interp(spacing, spacings, lengths))


def first_doubling(section: str, spacing: float) -> tuple[float, float]:
    """tau and length at which every other crack of an even array stops, interpolated in spacing.

    Raises
    ------
    ValueError
        The spacing is outside of what was computed.
    """
    with (DATA / "spacing_and_doubling.csv").open() as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    rows = [row for row in rows if row["mech"] == section and row["tau1_bif"]]
    spacings, tau, a = np.array(
        [[float(row[name]) for name in ("spacing", "tau1_bif", "a1_bif")] for row in rows]
    ).T
    if not spacings[0] <= spacing <= spacings[-1]:
        raise ValueError(f"no doubling is known at spacing {spacing:g}")
    return float(np.interp(spacing, spacings, tau)), float(np.interp(spacing, spacings, a))
