"""Curves of a run against time: energies, crack lengths, depths and numbers of cracks."""

from collections.abc import Sequence
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from staffa.display_units import Unit
from staffa.geometry.block import face_axis
from staffa.measure.generations import Arrests, Track, arrests, tracks
from staffa.plot.labels import at as at_clock
from staffa.plot.labels import counts_tau, crack_name, show_clock, since_rest, time_axis_values
from staffa.plot.style import (
    BLACK,
    BLUE,
    GENERATIONS,
    GREEN,
    ORANGE,
    PURPLE,
    count_axis,
    legend_above,
    new_figure,
)
from staffa.records.manifest import Manifest
from staffa.records.step import Measures, Step


def energies_figure(manifest: Manifest, steps: Sequence[Step]) -> Figure:
    """Draw the energies of each step."""
    figure = new_figure(3.4)
    axes = figure.subplots()
    at, energies = time_axis_values(manifest, steps), [step.energies for step in steps]
    of, rest = manifest.shown.energy.of, " since rest" if since_rest(steps) else ""
    marker = "o" if len(steps) < 40 else ""
    style: Any = {"marker": marker, "markersize": 3}
    axes.plot(at, [of(e.total) for e in energies], color=BLACK, label="total", **style)
    axes.plot(at, [of(e.elastic) for e in energies], color=BLUE, label=f"elastic{rest}", **style)
    if any(e.loads for e in energies):
        axes.plot(
            at, [of(e.loads) for e in energies], color=GREEN, label=f"of the loads{rest}", **style
        )
    if any(e.friction for e in energies):
        axes.plot(at, [of(e.friction) for e in energies], color=PURPLE, label="friction", **style)
    axes.plot(at, [of(e.surface) for e in energies], color=ORANGE, label="surface", **style)
    show_clock(axes, manifest, steps)
    axes.set_ylabel(manifest.shown.energy.label("energy"))
    if all(min(e.total, e.elastic, e.loads) >= 0 for e in energies):
        axes.set_ylim(bottom=0)
    legend_above(axes, 3)
    return figure


def lengths_figure(manifest: Manifest, steps: Sequence[Step]) -> Figure:
    """Draw total length, depth of every crack, and cracks on each section, one above the other."""
    seen = [step for step in steps if step.measures is not None]
    measured = [step.measures for step in seen if step.measures is not None]
    counted = bool(measured[0].sections)
    panels = 1 + bool(manifest.cooled_side) + counted
    figure = new_figure(0.9 + 2.1 * panels)
    rows = figure.subplots(panels, 1, squeeze=False, sharex=True)[:, 0]
    at = time_axis_values(manifest, seen)
    _draw_lengths(rows[0], manifest, at, measured)
    if manifest.cooled_side:
        axis = face_axis(manifest.cooled_side, len(manifest.size))
        followed = tracks(seen, axis=axis, sharp=manifest.sharp)
        found = arrests(seen, axis=axis, ell=manifest.ell, sharp=manifest.sharp)
        _draw_depths(rows[1], manifest, at, followed, found, tau=counts_tau(manifest, seen))
    if counted:
        _draw_counts(rows[-1], manifest, at, measured)
    show_clock(rows[-1], manifest, seen)
    return figure


def _draw_lengths(
    axes: Axes, manifest: Manifest, at: Sequence[float], measured: Sequence[Measures]
) -> None:
    unit = manifest.shown.crack
    surface = [unit.of(m.length_surface) for m in measured]
    geometry = [unit.of(m.length_geometry) for m in measured]
    axes.plot(at, surface, color=ORANGE, label="from the surface energy")
    axes.plot(at, geometry, color=BLUE, label="from the geometry", linestyle="--")
    axes.set_ylabel(unit.label(crack_name(manifest)))
    axes.set_ylim(bottom=0)
    legend_above(axes, 2)


def _draw_depths(
    axes: Axes,
    manifest: Manifest,
    at: Sequence[float],
    followed: Sequence[Track],
    found: Arrests,
    *,
    tau: bool,
) -> None:
    """Draw a line for each crack's tip, colored by its generation, and a mark at each arrest.

    `tau` is True if the time axis is tau.
    """
    unit = manifest.shown.length
    rest = sorted(followed, key=lambda track: track.final)
    for generation, color in zip(found.generations, cycle(GENERATIONS), strict=False):
        members, rest = rest[: generation.cracks], rest[generation.cracks :]
        label = f"generation {generation.number}: {_cracks(generation.cracks)}"
        _draw_tracks(axes, unit, at, members, color, label)
        when = at_clock(manifest, generation.time, generation.tau if tau else None)
        axes.plot(
            [when], [unit.of(generation.depth)], linestyle="", marker="D", markersize=6,
            color=color, markeredgecolor="white", zorder=5,
        )  # fmt: skip
    _draw_tracks(
        axes, unit, at, rest, BLACK, f"others: {_cracks(len(rest))}, {found.growing} growing"
    )
    axes.set_ylabel(unit.label("depth of each tip"))
    axes.set_ylim(bottom=0)
    if followed:
        legend_above(axes, min(4, len(found.generations) + 1))


def _draw_tracks(
    axes: Axes, unit: Unit, at: Sequence[float], members: Sequence[Track], color: str, label: str
) -> None:
    for number, track in enumerate(members):
        depths = [np.nan if depth is None else unit.of(depth) for depth in track.depths]
        axes.plot(
            at, depths, color=color, linewidth=1.0, marker=".", markersize=3,
            label=label if number == 0 else None,
        )  # fmt: skip


def _cracks(number: int) -> str:
    return "1 crack" if number == 1 else f"{number} cracks"


def _draw_counts(
    axes: Axes, manifest: Manifest, at: Sequence[float], measured: Sequence[Measures]
) -> None:
    heights, unit = [section.height for section in measured[0].sections], manifest.shown.length
    colors = colormaps["viridis"](np.linspace(0.0, 0.85, len(heights)))
    for number, (height, color) in enumerate(zip(heights, colors, strict=True)):
        width = 1.4 + 0.45 * (len(heights) - 1 - number)  # so that equal counts show one in another
        counts = [m.sections[number].cracks for m in measured]
        axes.step(
            at, counts, where="post", color=color, linewidth=width, label=f"{unit.of(height):.3g}"
        )
    axes.set_ylabel("cracks crossing")
    count_axis(axes)
    legend = legend_above(axes, len(heights))
    legend.set_title(unit.label("at depth"))
    legend.set_alignment("left")
