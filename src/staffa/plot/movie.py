"""Animated picture of growing cracks: in 3-D in perspective, in 2-D the damage."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import imageio.v3 as imageio
import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from staffa.errors import StaffaError
from staffa.io.own_files import write_aside
from staffa.io.run_directory import Run
from staffa.plot.cracks import cracks_figure
from staffa.plot.frames import read_frames
from staffa.plot.labels import moment
from staffa.plot.rendering import CRACKS, ROCK
from staffa.plot.style import RC, WIDTH, new_figure
from staffa.plot.volume import add_depths, deepest, depth_label, rendered
from staffa.records.step import Step

FEWEST, MOST = 3, 40  # moments that make a movie, and that it shows at most
PIXELS = 560  # edge of a rendered view
DPI = 120  # of a frame, 840 pixels wide
SECONDS, REST = 0.25, 2.0  # that a frame stays, and the last one
LARGEST = 5_000_000  # bytes; with more, every other frame goes


def write_movie(
    path: Path,
    run: Run,
    steps: Sequence[Step],
    told: Callable[[int, int], None] = lambda done, of: None,
) -> None:
    """Write a GIF of these steps, whose fields are on disk; atomically.

    Parameters
    ----------
    path : the file.
    run : the run.
    steps : the steps to show.
    told : called after each picture with the number done and the number of all.

    Raises
    ------
    StaffaError
        Rendering is not possible here, or no fields can be read.
    """
    draw = _flat if len(run.manifest.size) == 2 else _solid
    with rc_context(RC):
        pictures = list(draw(run, steps, told))
    if not pictures:
        raise StaffaError("the fields of its steps cannot be read")
    while len(movie := _gif(pictures)) > LARGEST and len(pictures) > 1:
        pictures = pictures[::-2][::-1]  # every other one, the last among them
    write_aside(path, movie)


def _gif(pictures: Sequence[np.ndarray]) -> bytes:
    stay = [*[SECONDS] * (len(pictures) - 1), REST]
    return imageio.imwrite(
        "<bytes>", np.stack(pictures), extension=".gif", loop=0,
        duration=[round(1000 * seconds) for seconds in stay],
    )  # fmt: skip


def _flat(run: Run, steps: Sequence[Step], told: Callable[[int, int], None]) -> Iterator[Any]:
    """Yield a panel of damage and isotherms for each step."""
    for number, step in enumerate(steps, start=1):
        for frame in read_frames(run, [step])[0]:
            yield _pixels(cracks_figure(run.manifest, [frame]))
        told(number, len(steps))


def _solid(run: Run, steps: Sequence[Step], told: Callable[[int, int], None]) -> Iterator[Any]:
    """Yield the rock cut away, and beside it the cracks alone, for each step."""
    looks, manifest = (ROCK, CRACKS), run.manifest
    count = iter(range(1, 1 + len(looks) * len(steps)))
    bottom = deepest(manifest, steps)
    rows = rendered(
        manifest,
        [run.path / str(step.fields) for step in steps],
        bottom,
        looks,
        pixels=PIXELS,
        ready=lambda: told(next(count), len(looks) * len(steps)),
    )
    tallest = max(row.shape[1] / row.shape[2] for row in rows)
    figure = new_figure(WIDTH / 2 * tallest + 0.95)
    panels = figure.subplots(1, 2)
    add_depths(figure, panels, manifest.shown.length.of(bottom), depth_label(manifest))
    for step, *views in zip(steps, *rows, strict=True):
        for axes, view in zip(panels, views, strict=True):
            axes.clear()
            axes.imshow(view, interpolation="antialiased")
            axes.set_axis_off()
        panels[0].set_title(moment(manifest, step), loc="left")
        yield _pixels(figure)


def _pixels(figure: Figure) -> np.ndarray:
    """Return a figure as an image, shape (height, width, 3)."""
    figure.set_dpi(DPI)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()
