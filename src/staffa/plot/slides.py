"""Small pictures of damage and temperature at one time, for the time slider of a page."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.colors import Colormap, Normalize
from matplotlib.ticker import MaxNLocator
from scipy.spatial import KDTree

from staffa.plot.cracks import DAMAGE, extent, rim, triangulation
from staffa.plot.frames import Frame
from staffa.plot.mesh_picture import plane
from staffa.plot.style import new_figure, picture_bytes
from staffa.records.manifest import Manifest

WIDTH = 4.4  # inches: letters are legible on a phone, where it is 9 cm wide
TALLEST = 1.5  # height of the panel over the width of the picture, at most
BELOW = 1.0  # inches for labels and color scale
TEMPERATURES = "plasma"
QUALITY = 82  # of WebP: letters stay sharp
LINE = 0.7  # points: width of the line around cracks, over the temperature
RIM = "#555555"
FINEST = 300  # points of a section along its longer axis, at most
BEYOND = 1.5  # edges of a cell from a vertex: farther away there is no body
NEAREST = 4  # vertices whose mean, by distance, a point of a section has
NEAR = 1e-6  # edges of a cell: so near a vertex, its value counts alone
LEVELS = 4  # steps of a color scale, at least
Limits = tuple[float, float]


class SlidePainter:
    """Draws one quantity at several times, in one figure whose axes are laid out once.

    Parameters
    ----------
    manifest : description of the run.
    label : label of the color scale.
    colors : its colors.
    limits : its ends.
    """

    def __init__(
        self, manifest: Manifest, label: str, colors: Colormap | str, limits: Limits
    ) -> None:
        self.manifest = manifest
        self.scale: Any = {"cmap": colors, "norm": Normalize(*limits)}
        across, up = plane(manifest)
        height = (WIDTH - 0.7) * manifest.size[up] / manifest.size[across]
        self.figure = new_figure(min(height, TALLEST * WIDTH) + BELOW, width=WIDTH)
        self.axes = self.figure.subplots()
        _frame_axes(self.axes, manifest)
        self.figure.colorbar(
            ScalarMappable(**self.scale), ax=self.axes, location="bottom", shrink=0.8, aspect=30,
            label=label, ticks=MaxNLocator(LEVELS),
        )  # fmt: skip

    def image(self, frame: Frame, values: np.ndarray, *, around: bool = False) -> bytes:
        """Return a picture of values at one time as a WebP.

        Parameters
        ----------
        frame : the fields.
        values : the values to draw, shape (n,).
        around : True for a line around cracks.
        """
        for drawn in (*self.axes.collections, *self.axes.images):
            drawn.remove()
        draw = _draw_plane if self.manifest.flat else _draw_section
        draw(self.axes, self.manifest, frame, values, around).set(**self.scale)
        image = picture_bytes(self.figure, "webp", quality=QUALITY)
        self.figure.set_layout_engine("none")  # as it is now laid out
        return image


def damage_painter(manifest: Manifest) -> SlidePainter:
    """Return what draws the damage."""
    return SlidePainter(manifest, "damage (1: broken)", DAMAGE, (0.0, 1.0))


def temperature_painter(manifest: Manifest, limits: Limits) -> SlidePainter:
    """Return what draws the temperature.

    Parameters
    ----------
    manifest : description of the run.
    limits : ends of the color scale.
    """
    label, _ = temperatures(manifest, np.zeros(0))
    return SlidePainter(manifest, label, TEMPERATURES, limits)


def temperatures(manifest: Manifest, T: np.ndarray) -> tuple[str, np.ndarray]:
    """Return the label of a scale of temperature, and values in its unit, shape (n,).

    Parameters
    ----------
    manifest : description of the run.
    T : temperature changes (K), shape (n,).
    """
    shown, drop = manifest.shown, manifest.scales.get("dT")
    if manifest.scaled and drop:
        return "change of temperature T/ΔT", T / drop
    if manifest.scaled or manifest.reference is None:
        return shown.difference.label("change of temperature"), shown.difference.of(T)
    return shown.temperature.label("temperature"), shown.temperature.of(manifest.reference + T)


def range_shown(manifest: Manifest, frame: Frame) -> Limits:
    """Return the lowest and the highest temperature of a step, in the unit that is shown."""
    _, values = temperatures(manifest, frame.T)
    return float(values.min()), float(values.max())


def color_limits(ranges: Sequence[Limits]) -> Limits:
    """Return round numbers around all ranges of temperature: later ones seldom change them.

    Parameters
    ----------
    ranges : lowest and highest temperature of each step, one or more.
    """
    low, high = min(low for low, _ in ranges), max(high for _, high in ranges)
    ticks = MaxNLocator(LEVELS).tick_values(low, high)
    return float(ticks[0]), float(ticks[-1])


def section_place(manifest: Manifest) -> str:
    """Return the place of the section that is drawn of a 3-D body, as text; empty in 2-D."""
    if manifest.flat:
        return ""
    (normal,) = {0, 1, 2} - set(plane(manifest))
    return f"section at {'xyz'[normal]} = {manifest.shown.length.text(_middle(manifest)[normal])}"


def _frame_axes(axes: Axes, manifest: Manifest) -> None:
    across, up = plane(manifest)
    ends, unit = extent(manifest), manifest.shown.length
    names = ("r", "z") if manifest.axial else ("xyz"[across], "xyz"[up])
    axes.set(
        xlim=ends[across], ylim=ends[up], aspect="equal",
        xlabel=unit.label(names[0]), ylabel=unit.label(names[1]),
    )  # fmt: skip
    axes.locator_params(nbins=5)
    axes.grid(False)
    for side in axes.spines.values():
        side.set_visible(True)


def _draw_plane(
    axes: Axes, manifest: Manifest, frame: Frame, values: np.ndarray, around: bool
) -> Artist:
    """Draw values of a 2-D body, and around its cracks a line.

    Parameters
    ----------
    axes : the panel.
    manifest : description of the run.
    frame : the fields.
    values : the values to draw, shape (n,).
    around : True for a line around cracks.
    """
    triangles = triangulation(frame.grid, manifest)
    drawn = axes.tripcolor(triangles, values, shading="gouraud")
    axes.add_collection(LineCollection(list(rim(triangles)), colors=RIM, linewidths=0.6))
    if around and frame.alpha.max() > manifest.threshold:
        axes.tricontour(triangles, frame.alpha, [manifest.threshold], colors="w", linewidths=LINE)
    return drawn


def _draw_section(
    axes: Axes, manifest: Manifest, frame: Frame, values: np.ndarray, around: bool
) -> Artist:
    """Draw values in a section through the middle of a 3-D body, means of the nearest vertices.

    Parameters
    ----------
    axes : the panel.
    manifest : description of the run.
    frame : the fields.
    values : the values to draw, shape (n,).
    around : True for a line around cracks.
    """
    inside, sizes = list(plane(manifest)), np.array(manifest.size)
    lines = [
        manifest.corner[axis] + sizes[axis] * np.linspace(0, 1, count)
        for axis, count in zip(inside, _counts(manifest, sizes[inside]), strict=True)
    ]
    points = np.tile(_middle(manifest), (len(lines[1]), len(lines[0]), 1))
    points[..., inside[0]], points[..., inside[1]] = np.meshgrid(*lines)
    apart, nearest = KDTree(frame.grid.points).query(points, k=NEAREST)
    away = apart[..., 0] > BEYOND * manifest.h
    weights = 1 / np.maximum(apart, NEAR * manifest.h) ** 2
    weights /= weights.sum(axis=-1, keepdims=True)
    (left, right), (low, high) = (extent(manifest)[axis] for axis in inside)
    shown, alpha = (
        np.ma.masked_where(away, (weights * field[nearest]).sum(axis=-1))
        for field in (values, frame.alpha)
    )
    drawn = axes.imshow(
        shown, origin="lower", extent=(left, right, low, high), interpolation="bilinear"
    )
    if around and alpha.max() > manifest.threshold:
        x, y = (manifest.shown.length.of(line) for line in lines)
        axes.contour(x, y, alpha, [manifest.threshold], colors="w", linewidths=LINE)
    return drawn


def _counts(manifest: Manifest, sizes: np.ndarray) -> list[int]:
    """Return how many points a section has along each of its axes: about one a cell."""
    edge = max(manifest.h, float(sizes.max()) / FINEST)
    return [max(2, 1 + round(size / edge)) for size in sizes.tolist()]


def _middle(manifest: Manifest) -> np.ndarray:
    """Return the middle of the box around a body (m), shape (3,)."""
    return np.asarray(manifest.corner) + np.asarray(manifest.size) / 2
