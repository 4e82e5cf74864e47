"""Sizes of the cracks of a run in words: of the network, by energy and by geometry."""

import csv

from staffa.io.own_files import NETWORK
from staffa.io.run_directory import Run
from staffa.records.step import Measures, Step

APART = 0.1  # part by which network and energy differ where both are to be quoted
LEFT_OUT = (
    "cracks along a side of the body, layers that are broken all over, and damage below the "
    "threshold"
)


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
    kept = [step for step in run.steps if step.fields and (run.path / step.fields).exists()]
    known = _of_network(run)
    if not kept and known is None:
        return f"{sizes}; that of the network is known at steps with fields, and none was reached"
    if known is None or (kept and known[0].index < kept[-1].index):
        return f"{sizes}; quote that of the network, which `staffa report` writes"
    step, size = known
    if step.index < run.steps[-1].index:
        sizes = f"at step {run.steps[-1].index} {sizes}"
    return f"{_to_quote(run, step, size)}; {sizes}"


def _to_quote(run: Run, step: Step, size: float) -> str:
    """Return the size of the network, with that by energy where the two are far apart.

    Parameters
    ----------
    run : the run.
    step : step of the network.
    size : size of the network, as its table shows it.
    """
    unit = run.manifest.shown.crack
    energy = unit.of(step.measures.length_surface) if step.measures else size
    reason = (
        f"the network leaves out {LEFT_OUT}"
        if energy > size
        else "look at the picture of the damage"
    )
    if not size:
        none = f"no crack is traced in the network at step {step.index}"
        return f"{none}: {reason}" if energy else none
    quoted = f"{size:.4g}{unit.behind} of the network at step {step.index}"
    if abs(energy - size) <= APART * size:
        return f"{quoted}, to be quoted"
    if step.index < run.steps[-1].index:  # else it follows
        quoted += f", {energy:.4g}{unit.behind} by energy then"
    return f"{quoted}, {abs(energy - size) / size:.0%} off that by energy: quote both; {reason}"


def _of_network(run: Run) -> tuple[Step, float] | None:
    """Return the last step of `network.csv` and the size of its network, as that shows it."""
    steps = {step.index: step for step in run.steps}
    try:
        with (run.path / NETWORK).open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        sizes = [key for key in rows[0] if key.startswith(size_name(run))]
        found = [(int(row["step"]), float(row[sizes[0]])) for row in rows]
    except (OSError, ValueError, IndexError, KeyError, TypeError):  # of an earlier version, or none
        return None
    return next(((steps[k], size) for k, size in reversed(found) if k in steps), None)
