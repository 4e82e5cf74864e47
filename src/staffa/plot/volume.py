"""Cracks of a 3-D body in perspective: in the rock, cut away, and alone, from their tips."""

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from staffa.backend.child_process import output_of
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
SHARE = 0.8  # of the picture's width that a view takes
MARGIN = 0.02  # of a view's edge that is left white around what is drawn
PATIENCE = 240  # seconds that rendering one view may take before it is given up


def volume_figure(manifest: Manifest, frame: Frame) -> Figure:
    """Draw the rock, its near quarter cut away, and below it the cracks alone.

    Raises
    ------
    StaffaError
        Rendering is not possible here.
    """
    bottom, looks = deepest(manifest, [frame.step]), (ROCK, CRACKS)
    views = [row[0] for row in rendered(manifest, [frame.path], bottom, looks, pixels=PIXELS)]
    heights = [view.shape[0] / view.shape[1] for view in views]
    figure = new_figure(SHARE * WIDTH * sum(heights) + 1.2)
    panels = figure.subplots(2, 1, height_ratios=heights)
    for axes, view in zip(panels, views, strict=True):
        axes.imshow(view, interpolation="antialiased")
        axes.set_axis_off()
    known = bool(manifest.cooled_side)
    face, tips = (f", its {manifest.surface} up", ", turned over") if known else ("", "")
    panels[0].set_title(f"{moment(manifest, frame.step)}: the rock{face}", loc="left")
    panels[1].set_title(f"the cracks alone{tips}", loc="left")
    add_depths(figure, panels[-1], manifest.shown.length.of(bottom), depth_label(manifest))
    return figure


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
) -> list[np.ndarray]:
    """Render views of files of fields; those of one look have one size.

    VTK ends its process where it finds neither a display nor a software renderer, so a child
    renders, and only the picture is lost.

    Parameters
    ----------
    manifest : of the run.
    files : files of fields.
    bottom : depth (m) at which the colors end.
    looks : `rendering.ROCK`, `rendering.CRACKS` or both.
    pixels : edge of an image, before the white around all of a look is cut off.
    ready : called after each view.

    Returns
    -------
    list of ndarray
        The images of each look, shape (files, height, width, 3).

    Raises
    ------
    StaffaError
        Rendering is not possible here.
    """
    with TemporaryDirectory(prefix="staffa-") as folder:
        result = f"{folder}/views.npy"
        job = {
            "result": result,
            "looks": list(looks),
            "files": [str(file.resolve()) for file in files],
            "lower": manifest.corner,
            "size": manifest.size,
            "sizes": [manifest.shown.length.text(length, 3) for length in manifest.size],
            "face": _face(manifest),
            "turned": bool(manifest.face),
            "deepest": bottom,
            "crack": manifest.threshold,
            "colors": DEPTHS,
            "pixels": pixels,
        }
        seconds = PATIENCE * len(looks) * len(files)
        try:
            output_of(
                isolated_python(module=RENDERER),
                seconds=seconds,
                asked=json.dumps(job),
                heard=ready,
            )
        except StaffaError as error:
            raise StaffaError(
                f"VTK cannot render off screen here ({error}); open the files in fields/ with "
                f"ParaView, or run `staffa report` on a machine with OpenGL"
            ) from None
        return [_cropped(images) for images in np.load(result)]


def deepest(manifest: Manifest, steps: Sequence[Step]) -> float:
    """Return the depth (m) at which the colors end: of the deepest tip, or of the body."""
    front = max((step.measures.front for step in steps if step.measures), default=0.0)
    return front or manifest.size[SIDES[3][_face(manifest)][0]]


def _face(manifest: Manifest) -> str:
    """Return the side of a box from which depth is counted."""
    return manifest.cooled_side or "top"


def _cropped(images: np.ndarray) -> np.ndarray:
    """Return images without the white around all of them, but for a margin."""
    drawn = np.argwhere((images < 250).any(axis=(0, 3)))
    margin = round(MARGIN * images.shape[1])
    (top, left), (bottom, right) = drawn.min(axis=0) - margin, drawn.max(axis=0) + margin
    return images[:, max(top, 0) : bottom, max(left, 0) : right]
