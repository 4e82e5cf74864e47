"""The sharp-crack reference curves in verify/data."""

import csv
from pathlib import Path

import numpy as np

DATA = Path(__file__).parent / "data"
SHARP = "sharp-crack finite elements"
# tau and length at which every other crack of an even array of spacing 0.1285 stops.
DOUBLING = {"fixed": (0.1022, 0.1406), "free": (0.1117, 0.1478)}


def array_growth(section: str, generation: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """tau and length of the cracks of an even array of spacing 0.1285."""
    with (DATA / "array_growth.csv").open() as file:
        rows = [r for r in csv.DictReader(file) if r["mech"] == section]
    rows = [r for r in rows if int(r["generation"]) == generation]
    tau, a = np.array([(float(r["tau_erfc_y_over_tau"]), float(r["a"])) for r in rows]).T
    order = np.argsort(tau)
    return tau[order], a[order]
