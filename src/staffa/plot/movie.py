"""The cracks growing, as an animated picture: of a 3-D body in perspective, of a 2-D one its damage."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from staffa.errors import StaffaError
from staffa.manifest import Manifest
from staffa.plot.cracks import cracks_figure
from staffa.plot.frames import Frame
from staffa.plot.labels import moment
from staffa.plot.rendering import CRACKS, ROCK
from staffa.plot.style import RC, WIDTH, new_figure
from staffa.plot.volume import add_depths, deepest, depth_label, draw_view, rendered

FEWEST, MOST = 3, 40  # moments that make a movie, and that it shows at most
PIXELS = 560  # edge of a rendered view
DPI = 120  # of a frame, 840 pixels wide
SECONDS, REST = 0.25, 2.0  # that a frame stays, and the last one
LARGEST = 5_000_000  # bytes; with more, every other frame goes
COLORS = 256


def write_movie(
    path: Path,
    manifest: Manifest,
    frames: Sequence[Frame],
    ready: Callable[[int, int], None] = lambda done, of: None,
) -> int:
    """Write a GIF of the moments, whole or not at all, and return the number of its frames.

    ready: called after each with how many are done, and how many there will be.

    Raises
    ------
    StaffaError
        Rendering is not possible here.
    """
    pictures = []
    with rc_context(RC):
        for picture in _pictures(manifest, frames, ready):
            image = Image.fromarray(picture)
            pictures.append(image.quantize(COLORS, dither=Image.Dither.NONE))
    aside = path.with_name(path.name + ".part")
    while True:
        stay = [round(1000 * SECONDS)] * (len(pictures) - 1) + [round(1000 * REST)]
        pictures[0].save(
            aside, format="GIF", save_all=True, append_images=pictures[1:], duration=stay, loop=0
        )
        if aside.stat().st_size <= LARGEST or len(pictures) == 1:
            break
        pictures = pictures[::-2][::-1]
    aside.replace(path)
    return len(pictures)


def _pictures(
    manifest: Manifest, frames: Sequence[Frame], ready: Callable[[int, int], None]
) -> Iterator[np.ndarray]:
    draw = _flat if len(manifest.size) == 2 else _solid
    yield from draw(manifest, frames, ready)


def _flat(
    manifest: Manifest, frames: Sequence[Frame], ready: Callable[[int, int], None]
) -> Iterator[np.ndarray]:
    for number, frame in enumerate(frames):
        yield _pixels(cracks_figure(manifest, [frame]))
        ready(number + 1, len(frames))


def _solid(
    manifest: Manifest, frames: Sequence[Frame], ready: Callable[[int, int], None]
) -> Iterator[np.ndarray]:
    looks, done = (ROCK, CRACKS), 0

    def one_more() -> None:
        nonlocal done
        done += 1
        ready(done, len(looks) * len(frames))

    bottom = deepest(manifest, frames)
    rows = rendered(manifest, frames, bottom, looks, pixels=PIXELS, ready=one_more)
    tallest = max(row[0].image.shape[0] / row[0].image.shape[1] for row in rows)
    figure = new_figure(WIDTH / 2 * tallest + 0.95)
    panels = figure.subplots(1, 2)
    add_depths(figure, panels, bottom, depth_label(manifest))
    for frame, *views in zip(frames, *rows, strict=True):
        for axes, view in zip(panels, views, strict=True):
            axes.clear()
            draw_view(axes, manifest, view)
        panels[0].set_title(moment(manifest, frame.step), loc="left")
        yield _pixels(figure)


def _pixels(figure: Figure) -> np.ndarray:
    """A figure as an image, shape (height, width, 3)."""
    figure.set_dpi(DPI)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[..., :3].copy()
