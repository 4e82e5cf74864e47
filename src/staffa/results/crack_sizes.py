"""Sizes of the cracks of a run in words: of the network, by energy and by geometry."""

import csv

from staffa.io.run_directory import Run
from staffa.records.step import Measures
from staffa.results.crack_network import TABLE


def size_name(run: Run) -> str:
    """Return "length" for cracks of a plane, "area" for others."""
    return "length" if run.manifest.plane else "area"


def crack_sizes(run: Run, measures: Measures) -> str:
    """Return the three sizes of the cracks with their names, that to be quoted first.

    Parameters
    ----------
    run : the run.
    measures : measures of its last step.
    """
    unit = run.manifest.shown.crack
    sizes = (
        f"{unit.text(measures.length_surface)} by energy, "
        f"{unit.text(measures.length_geometry)} by geometry"
    )
    known = _of_network(run)
    if known is None:
        return f"{sizes}; quote that of the network, which `staffa report` writes"
    step, size = known
    if not size:
        return f"no crack is traced in the network at step {step}; {sizes}"
    return f"{size:.4g}{unit.behind} of the network at step {step}, to be quoted; {sizes}"


def _of_network(run: Run) -> tuple[int, float] | None:
    """Return the last step of `network.csv` and the size of its network, as that shows it."""
    steps = {step.index for step in run.steps}
    try:
        with (run.path / TABLE).open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        sizes = [key for key in rows[0] if key.startswith(size_name(run))]
        found = [(int(row["step"]), float(row[sizes[0]])) for row in rows]
    except (OSError, ValueError, IndexError, KeyError, TypeError):  # of an earlier version, or none
        return None
    return next((one for one in reversed(found) if one[0] in steps), None)
