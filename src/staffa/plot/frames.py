"""Selection of the steps to draw, and their fields as read from disk."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from staffa.io.run_directory import Run
from staffa.io.vtkhdf import VtkMesh, read_vtkhdf
from staffa.records.step import Step

MOST = 5  # panels in one picture, so that cracks can be distinguished


@dataclass(frozen=True, kw_only=True)
class Frame:
    """Fields of one step.

    Attributes
    ----------
    step : record of the step.
    path : its file of fields.
    grid : the mesh, with n points.
    alpha : damage, shape (n,).
    T : temperature change (K), shape (n,).
    """

    step: Step
    path: Path
    grid: VtkMesh
    alpha: np.ndarray
    T: np.ndarray


def read_frames(run: Run, steps: Sequence[Step] | None = None) -> tuple[list[Frame], list[str]]:
    """Read the frames to draw, oldest first, and a message on each unreadable file.

    Parameters
    ----------
    run : the run.
    steps : the steps; None for those that `chosen` selects.
    """
    frames, reasons = [], []
    for step in chosen(run) if steps is None else steps:
        path = run.path / str(step.fields)
        try:
            grid, values = read_vtkhdf(path)
            frames.append(
                Frame(step=step, path=path, grid=grid, alpha=values["alpha"], T=values["T"])
            )
        except (OSError, KeyError, ValueError, IndexError) as error:
            why = "it is not there" if not path.exists() else f"it cannot be read: {error}"
            reasons.append(f"{step.fields} is left out: {why}")
    return frames, reasons


def with_fields(run: Run) -> list[Step]:
    """Return all steps whose fields are on disk."""
    return [step for step in run.steps if step.fields and (run.path / step.fields).exists()]


def chosen(run: Run) -> list[Step]:
    """Return at most five steps with fields: the requested ones and the last, evenly spread."""
    there = with_fields(run) or [step for step in run.steps if step.fields]
    asked = [s for s in there if run.wants(s) or s is there[-1]]
    return evenly_spread(asked if len(asked) > 1 else there)


def evenly_spread[T](steps: Sequence[T], most: int = MOST) -> list[T]:
    """Return at most `most` of the steps, evenly spread; the last stays, the first goes."""
    if len(steps) <= most:
        return list(steps)
    return [steps[i] for i in np.linspace(0, len(steps) - 1, most + 1).round().astype(int)[1:]]
