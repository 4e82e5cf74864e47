"""Draws every picture that a run has the numbers for, and writes its page."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from matplotlib.figure import Figure

from staffa.errors import StaffaError
from staffa.io.run_directory import Run, write_aside
from staffa.plot.cracks import cracks_figure
from staffa.plot.curves import energies_figure, lengths_figure
from staffa.plot.frames import read_frames
from staffa.plot.style import write_picture
from staffa.plot.volume import volume_figure
from staffa.report.page import page

PICTURES, PAGE = "pictures", "report.html"


@dataclass(frozen=True, kw_only=True)
class Drawn:
    """What is on disk now, and a sentence on each picture, or part of one, that is not."""

    page: Path
    pictures: tuple[Path, ...]
    skipped: tuple[str, ...]


def draw(run: Run) -> Drawn:
    """Write `pictures/*.png` and `report.html` into the run directory, over earlier ones.

    Raises
    ------
    StaffaError
        The run directory cannot be written to.
    """
    figures, skipped = _figures(run)
    pictures = []
    try:
        (run.path / PICTURES).mkdir(exist_ok=True)
        for name, figure in figures.items():
            path = run.path / PICTURES / f"{name}.png"
            try:
                write_picture(path, figure)
                pictures.append(path)
            except StaffaError as error:
                skipped.append(f"{name}: {error}")
        write_aside(run.path / PAGE, page(run, pictures, skipped))
    except OSError as error:
        raise StaffaError(
            f"the report cannot be written into {run.path}: {error.strerror}; copy the run to a "
            f"folder that you may write to"
        ) from None
    return Drawn(page=run.path / PAGE, pictures=tuple(pictures), skipped=tuple(skipped))


def _figures(run: Run) -> tuple[dict[str, Callable[[], Figure]], list[str]]:
    """How to draw each picture, by name, and the reasons for those that cannot be drawn."""
    manifest, steps = run.manifest, run.steps
    if not steps:
        return {}, ["no pictures: no step is finished yet"]
    figures: dict[str, Callable[[], Figure]] = {}
    frames, skipped = read_frames(run)
    if frames:
        figure = cracks_figure if len(manifest.size) == 2 else volume_figure
        figures["cracks"] = partial(figure, manifest, frames)
    else:
        skipped.append("cracks: no step has fields that can be read")
    if len(steps) < 2:
        return figures, [*skipped, "curves: they need two steps"]
    figures["energies"] = partial(energies_figure, manifest, steps)
    if sum(step.measures is not None for step in steps) < 2:
        skipped.append("lengths: fewer than two steps were measured")
    else:
        figures["lengths"] = partial(lengths_figure, manifest, steps)
    return figures, skipped
