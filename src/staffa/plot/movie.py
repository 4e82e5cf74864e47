"""Animated picture of growing cracks: in 3-D in perspective, in 2-D the damage."""

import io
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from staffa.errors import StaffaError
from staffa.io.own_files import write_aside
from staffa.io.run_directory import Run
from staffa.plot.cracks import cracks_figure
from staffa.plot.frames import read_frames
from staffa.plot.labels import moment
from staffa.plot.rendering import CRACKS, ROCK
from staffa.plot.style import RC, WIDTH, new_figure
from staffa.plot.volume import add_depths, deepest, depth_label, draw_view, rendered
from staffa.records.step import Step

FEWEST, MOST = 3, 40  # frames that a movie has at least, and at most
PIXELS = 560  # edge of a rendered view
DPI = 120  # of a frame, 840 pixels wide
SECONDS, REST = 0.25, 2.0  # duration of a frame, and of the last one
LARGEST = 5_000_000  # bytes; if it is larger, every other frame is removed


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
        drawn = [Image.fromarray(picture) for picture in draw(run, steps, told)]
    if not drawn:
        raise StaffaError("the fields of its steps cannot be read")
    # The last picture has all colors; a palette for each would leave few for the color scale.
    palette = drawn[-1].quantize(dither=Image.Dither.NONE)
    pictures = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in drawn]
    while len(movie := _gif(pictures)) > LARGEST and len(pictures) > 1:
        pictures = pictures[::-2][::-1]  # every other one, with the last
    write_aside(path, movie)


def _gif(pictures: Sequence[Image.Image]) -> bytes:
    first, *others = pictures
    stay = [*[SECONDS] * len(others), REST]
    written = io.BytesIO()
    first.save(
        written, format="GIF", save_all=True, append_images=others,
        duration=[round(1000 * seconds) for seconds in stay], loop=0,
    )  # fmt: skip
    return written.getvalue()


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
    tallest = max(row[0].image.shape[0] / row[0].image.shape[1] for row in rows)
    figure = new_figure(WIDTH / 2 * tallest + 0.95)
    panels = figure.subplots(1, 2)
    add_depths(figure, panels, manifest.shown.length.of(bottom), depth_label(manifest))
    for step, *views in zip(steps, *rows, strict=True):
        for axes, view in zip(panels, views, strict=True):
            axes.clear()
            draw_view(axes, manifest, view)
        panels[0].set_title(moment(manifest, step), loc="left")
        yield _pixels(figure)


def _pixels(figure: Figure) -> np.ndarray:
    """Return a figure as an image, shape (height, width, 3)."""
    figure.set_dpi(DPI)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()
