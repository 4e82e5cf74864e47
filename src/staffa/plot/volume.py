"""Cracks of a 3-D body in perspective: in the rock, cut away, and alone, from their tips."""

import json
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import Timer
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from staffa.backend.isolation import isolated_python
from staffa.errors import StaffaError
from staffa.geometry.block import SIDES
from staffa.plot.frames import Frame
from staffa.plot.labels import moment
from staffa.plot.rendering import CRACKS, ROCK
from staffa.plot.style import WIDTH, new_figure
from staffa.records.manifest import Manifest
from staffa.records.step import Step

RENDERER = "staffa.plot.rendering"
DEPTHS = "viridis"
PIXELS = 1200  # edge of a rendered view
SHARE = 0.8  # width of a view over that of the picture
MARGIN = 0.05  # white margin of a view over its edge, for the size labels
PATIENCE = 240  # seconds after which the rendering of one view is stopped


@dataclass(frozen=True, kw_only=True)
class View:
    """Rendered image with the positions of the body's size labels.

    Attributes
    ----------
    image : shape (height, width, 3).
    places : position of the label of each axis (pixels), shape (3, 2).
    """

    image: np.ndarray
    places: np.ndarray


def volume_figure(manifest: Manifest, frame: Frame) -> Figure:
    """Draw the rock, its near quarter cut away, and below it the cracks alone.

    Raises
    ------
    StaffaError
        Rendering is not possible here.
    """
    bottom, looks = deepest(manifest, [frame.step]), (ROCK, CRACKS)
    views = [row[0] for row in rendered(manifest, [frame.path], bottom, looks, pixels=PIXELS)]
    heights = [view.image.shape[0] / view.image.shape[1] for view in views]
    figure = new_figure(SHARE * WIDTH * sum(heights) + 1.2)
    panels = figure.subplots(2, 1, height_ratios=heights)
    for axes, view in zip(panels, views, strict=True):
        draw_view(axes, manifest, view)
    known = bool(manifest.cooled_side)
    face, tips = (f", its {manifest.surface} up", ", turned over") if known else ("", "")
    panels[0].set_title(f"{moment(manifest, frame.step)}: the rock{face}", loc="left")
    panels[1].set_title(f"the cracks alone{tips}", loc="left")
    add_depths(figure, panels[-1], manifest.shown.length.of(bottom), depth_label(manifest))
    return figure


def draw_view(axes: Axes, manifest: Manifest, view: View) -> None:
    """Draw an image with the sizes of the body along its edges.

    Parameters
    ----------
    axes : the panel.
    manifest : description of the run.
    view : the image.
    """
    axes.imshow(view.image, interpolation="antialiased")
    axes.set_axis_off()
    for length, (x, y) in zip(manifest.size, view.places, strict=True):
        said = manifest.shown.length.text(length, 3)
        style: Any = {"ha": "center", "va": "center", "fontsize": 8, "color": "#555555"}
        axes.text(x, y, said, **style, in_layout=False)  # within the image


def add_depths(figure: Figure, panels: Any, bottom: float, label: str) -> None:
    """Draw the color scale of the depths below the panels.

    Parameters
    ----------
    figure : the figure.
    panels : the panels.
    bottom : depth at which the colors end.
    label : label of the scale.
    """
    figure.colorbar(
        ScalarMappable(Normalize(0, bottom), DEPTHS), ax=panels, location="bottom", shrink=0.5,
        aspect=40, label=label,
    )  # fmt: skip


def depth_label(manifest: Manifest) -> str:
    """Return the label of a scale of depth."""
    where = manifest.surface if manifest.cooled_side else "top"
    return manifest.shown.length.label(f"depth below the {where}")


def rendered(
    manifest: Manifest,
    files: Sequence[Path],
    bottom: float,
    looks: Sequence[str],
    *,
    pixels: int,
    ready: Callable[[], None] = lambda: None,
) -> list[list[View]]:
    """Render each file of fields in each look; the views of one look are cropped alike.

    VTK ends its process if it finds neither a display nor a software renderer. So a child process
    renders, and only the picture is lost.

    Parameters
    ----------
    manifest : description of the run.
    files : files of fields.
    bottom : depth at which the colors end (m).
    looks : of `rendering.ROCK` and `rendering.CRACKS`.
    pixels : edge of an image before its white margin is cut off.
    ready : called after each view.

    Raises
    ------
    StaffaError
        Rendering is not possible here.
    """
    with tempfile.TemporaryDirectory(prefix="staffa-") as folder:
        result = Path(folder) / "views.npz"
        job = {
            "result": str(result),
            "looks": list(looks),
            "files": [str(file.resolve()) for file in files],
            "lower": manifest.corner,
            "size": manifest.size,
            "face": _face(manifest),
            "turned": bool(manifest.face),
            "deepest": bottom,
            "crack": manifest.threshold,
            "colors": DEPTHS,
            "pixels": pixels,
        }
        said = _in_a_child(json.dumps(job), PATIENCE * len(looks) * len(files), ready)
        if not result.is_file():
            raise StaffaError(
                f"VTK cannot render off screen here ({said}); open the files in fields/ with "
                f"ParaView, or run `staffa report` on a machine with OpenGL"
            )
        with np.load(result) as found:
            images, places = found["images"], found["places"]
    n = len(files)
    rows = range(0, len(images), n)
    return [_cropped(images[start : start + n], places[start : start + n]) for start in rows]


def deepest(manifest: Manifest, steps: Sequence[Step]) -> float:
    """Return the depth (m) at which the colors end: of the deepest tip, or of the body."""
    front = max((step.measures.front for step in steps if step.measures), default=0.0)
    return front or manifest.size[SIDES[3][_face(manifest)][0]]


def _face(manifest: Manifest) -> str:
    """Return the side of a box from which depth is counted."""
    return manifest.cooled_side or "top"


def _cropped(images: np.ndarray, places: np.ndarray) -> list[View]:
    """Cut off the white around all of the images and label positions, which may lie outside."""
    spare = images.shape[1] // 5
    images = np.pad(images, ((0, 0), (spare,) * 2, (spare,) * 2, (0, 0)), constant_values=255)
    places = places + spare
    rows, columns = np.nonzero((images < 250).any(axis=(0, 3)))
    drawn = np.concatenate([np.stack([columns, rows], axis=1), places.reshape(-1, 2)])
    margin = MARGIN * images.shape[1]
    left, top = np.maximum(drawn.min(axis=0) - margin, 0).astype(int)
    right, bottom = (drawn.max(axis=0) + margin).astype(int)
    cut = images[:, top:bottom, left:right]
    pairs = zip(cut, places - [left, top], strict=True)
    return [View(image=image, places=beside) for image, beside in pairs]


def _in_a_child(job: str, patience: float, ready: Callable[[], None]) -> str:
    """Run the renderer on a job, and return its last message."""
    command = isolated_python(module=RENDERER)
    with (
        tempfile.TemporaryFile("w+") as errors,
        subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=errors, text=True
        ) as child,
    ):
        stop = Timer(patience, child.kill)
        stop.start()
        try:
            assert child.stdin is not None and child.stdout is not None
            child.stdin.write(job)
            child.stdin.close()
            for _ in child.stdout:
                ready()
        except BrokenPipeError:
            pass  # it ended before it read its job: what it said tells why
        finally:
            stop.cancel()
        status = child.wait()
        errors.seek(0)
        told = errors.read().strip().splitlines()
    return told[-1] if told else f"exit status {status}"
