"""Pictures of two runs: curves on one clock, cracks beside each other and their difference."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from itertools import zip_longest

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from scipy.spatial import KDTree

from staffa.compare.agreement import gap_between_steps
from staffa.compare.pair import Pair
from staffa.plot.cracks import (
    add_legend,
    draw_panel,
    entitle,
    temperature_drop,
    triangulation,
)
from staffa.plot.frames import Frame, evenly_spread, read_frames
from staffa.plot.labels import TAU, moment, show_clock, tau_label
from staffa.plot.rendering import CRACKS
from staffa.plot.style import BLACK, BLUE, ORANGE, WIDTH, count_axis, legend_above, new_figure
from staffa.plot.volume import add_depths, deepest, rendered
from staffa.records.manifest import Manifest

COLORS = (BLUE, ORANGE)
WIDTHS = (3.0, 1.2)  # so that equal curves show one in the other
DIFFERENCE = "RdBu_r"
FAINT = 1e-3  # the colors of a difference end no earlier, so that round-off stays pale
FEW = 3  # moments of bodies that are long or 3-D
PIXELS = 700  # edge of a view of one
LONG = 4.0  # width over height of a body whose panels stand in one column
LONGEST = 18  # characters of a name above a panel
Figures = dict[str, Callable[[], Figure]]
Frames = Sequence[tuple[Frame, Frame]]
DRAWN = ("total energy", "elastic energy", "surface energy", "energy of loads")
GROWTH = ("crack size", "deepest crack", "cracks")
AMID = ("production temperature", "highest pressure")  # their changes are far above zero
PRODUCED = ("production temperature", "produced power", "highest pressure")


def pair_figures(pair: Pair) -> tuple[Figures, list[str]]:
    """Return functions that draw the pictures, by name, and reasons for those that are missing."""
    figures, skipped = _fields(pair)
    if pair.clock is None:
        return figures, [*skipped, "curves: the runs have no clock in common"]
    energies, growth = ([n for n in names if pair.knows(n)] for names in (DRAWN, GROWTH))
    if pair.dim is None:
        skipped.append("energies-of-both: those of bodies of two kinds have different units")
    else:
        figures["energies-of-both"] = partial(curves_figure, pair, energies, gap=pair.alike)
    if growth:
        figures["growth-of-both"] = partial(curves_figure, pair, growth)
    else:
        skipped.append("growth-of-both: no step was measured")
    if produced := [name for name in PRODUCED if pair.knows(name)]:
        figures["production-of-both"] = partial(curves_figure, pair, produced)
    return figures, skipped


def curves_figure(pair: Pair, names: Sequence[str], *, gap: bool = False) -> Figure:
    """Draw one panel a reading, a color for each run; what belongs to both is black.

    Parameters
    ----------
    pair : the two runs.
    names : of the readings.
    gap : with a panel of how far the total energies are apart.
    """
    figure = new_figure(0.9 + 1.7 * (len(names) + gap))
    rows = figure.subplots(len(names) + gap, 1, squeeze=False, sharex=True)[:, 0]
    for axes, name in zip(rows, names, strict=False):
        for times, side, color, width in zip(pair.times, pair.sides, COLORS, WIDTHS, strict=True):
            known = np.isfinite(values := side.readings[name])
            axes.plot(
                times[known], values[known], color=color, linewidth=width, label=side.name,
                drawstyle="steps-post" if name == "cracks" else "default",
                marker="o" if known.sum() == 1 else "",
            )  # fmt: skip
        scaled = "" if name == "cracks" or pair.units[name] else " (scaled)"
        axes.set_ylabel(pair.named(name) + scaled)
    if gap:
        at, apart = gap_between_steps(pair)
        rows[-1].plot(at, 100 * apart, color=BLACK, linewidth=WIDTHS[-1])
        rows[-1].set_ylabel("apart (%)")
    for axes, name in zip_longest(rows, names):
        axes.yaxis.set_major_locator(MaxNLocator(4))
        if axes.dataLim.ymin >= 0 and name not in AMID:
            axes.set_ylim(bottom=0)
        if axes.get_ylabel() == "cracks":
            count_axis(axes, ticks=4)
    manifest = pair.first.run.manifest
    if pair.clock == "t":
        show_clock(rows[-1], manifest, pair.first.run.steps if pair.root else ())
    else:
        alike = manifest.profile == pair.second.run.manifest.profile
        rows[-1].set_xlabel(tau_label(manifest) if alike else TAU, parse_math=True)
    legend_above(rows[0], 2)
    return figure


def _fields(pair: Pair) -> tuple[Figures, list[str]]:
    if pair.dim is None:
        return {}, ["cracks-of-both: the bodies are of two kinds"]
    frames, skipped = _frames(pair)
    if not frames:
        return {}, [*skipped, "cracks-of-both: there is no time whose fields both runs kept"]
    one, other = (side.run.manifest for side in pair.sides)
    if not (one.scaled or other.scaled):
        other = replace(other, units=vars(pair.shown))  # where both have units, in those of one
    draw = partial(volumes_figure, pair.names, (one, other), frames)
    if pair.dim == 2:
        ratio = pair.first.length / pair.second.length
        draw = partial(fields_figure, pair.names, (one, other), frames, ratio)
    return {"cracks-of-both": draw}, skipped


def _frames(pair: Pair) -> tuple[list[tuple[Frame, Frame]], list[str]]:
    """Return fields at times that both runs kept, and a sentence on each unreadable file."""
    one, other = (side.run.steps for side in pair.sides)
    there = [(one[i], other[k]) for i, k in pair.common if one[i].fields and other[k].fields]
    chosen = evenly_spread(there)
    width, height = pair.first.run.manifest.size[:2]
    if pair.dim == 2 and width > LONG * height:
        chosen = chosen[-FEW:]  # in one column
    read: list[tuple[Frame, Frame]] = []
    skipped: list[str] = []
    for both in chosen:
        (a, why), (b, why_not) = (
            read_frames(s.run, [step]) for s, step in zip(pair.sides, both, strict=True)
        )
        read += zip(a, b, strict=False)
        names = (pair.first.name,) * len(why) + (pair.second.name,) * len(why_not)
        skipped += [f"{name}: {said}" for name, said in zip(names, why + why_not, strict=True)]
    return read, skipped


def fields_figure(
    names: Sequence[str], manifests: Sequence[Manifest], frames: Frames, ratio: float = 1.0
) -> Figure:
    """Draw the damage of both 2-D bodies at each time, and where the points agree the difference.

    Parameters
    ----------
    names, manifests : of the runs.
    frames : fields of both at each time.
    ratio : see `difference`.
    """
    apart = [damage_difference(*both, ratio) for both in frames]
    known = [float(np.abs(gap).max()) for gap in apart if gap is not None]
    across, largest = (3 if known else 2), max([FAINT, *known])
    figure, grid = _panels(manifests[0], len(frames), across)
    for line, both, gap in zip(grid, frames, apart, strict=True):
        for axes, name, manifest, frame in zip(line, names, manifests, both, strict=False):
            dT = temperature_drop(manifest, [frame])
            draw_panel(axes, manifest, frame, triangulation(frame.grid, manifest), dT)
            entitle(axes, f"{_short(name)}, {moment(manifest, frame.step)}", manifest)
        if gap is not None:
            frame = replace(both[0], alpha=gap, T=np.zeros_like(gap))
            draw_panel(line[2], manifests[0], frame, triangulation(frame.grid, manifests[0]), 1.0)
            line[2].collections[0].set(cmap=DIFFERENCE, clim=(-largest, largest))
            entitle(line[2], f"difference, at most {abs(gap).max():.2g}", manifests[0])
        elif known:
            line[2].set_axis_off()
    first = [both[0] for both in frames]
    add_legend(figure, manifests[0], first, temperature_drop(manifests[0], first))
    if known:
        figure.colorbar(
            ScalarMappable(Normalize(-largest, largest), DIFFERENCE), ax=grid, location="bottom",
            shrink=0.5, aspect=40,
            label=f"damage of {_short(names[1])} minus that of {_short(names[0])}",
        )  # fmt: skip
    return figure


def _panels(manifest: Manifest, times: int, across: int) -> tuple[Figure, np.ndarray]:
    """Return a figure and its panels, shape (times, across), their outer axes named."""
    width, height = manifest.size
    columns = 1 if width > LONG * height else across
    panel = (WIDTH - 0.7) / columns * height / width + 0.36
    rows = across * times // columns
    figure = new_figure(rows * panel + 1.4, gap=0.05)
    grid = figure.subplots(rows, columns, squeeze=False).reshape(times, across)
    names, label = ("r", "z") if manifest.axial else ("x", "y"), manifest.shown.length.label
    for axes in grid[:, 0]:
        axes.set_ylabel(label(names[1]))
    for axes in grid[-1]:
        axes.set_xlabel(label(names[0]))
    return figure, grid


def damage_difference(one: Frame, other: Frame, ratio: float = 1.0) -> np.ndarray | None:
    """Return the damage of the second minus that of the first at the points of the first, (n,).

    None if these are not the points of both; a mesh has its points in another order on another
    number of ranks.

    Parameters
    ----------
    one, other : fields of the first and of the second.
    ratio : the unit of length of the first over that of the second.
    """
    a, b = one.grid.points, ratio * other.grid.points
    near = 2e-6 * float(np.ptp(a, axis=0).max())  # far below any edge, far above rounding
    _, there = KDTree(b).query(a, distance_upper_bound=near)  # their number where none is near
    if a.shape != b.shape or (there == len(b)).any():
        return None
    found: np.ndarray = other.alpha[there] - one.alpha
    return found


def volumes_figure(names: Sequence[str], manifests: Sequence[Manifest], frames: Frames) -> Figure:
    """Draw the last three moments of both 3-D bodies from a corner, cracks colored by depth.

    Parameters
    ----------
    names, manifests : of the runs.
    frames : fields of both at each time.

    Raises
    ------
    StaffaError
        Rendering is not possible here.
    """
    runs = list(zip(names, manifests, zip(*frames[-FEW:], strict=True), strict=True))
    bottom = max(deepest(m, [f.step for f in mine]) / m.L for _, m, mine in runs)
    figure = new_figure(2 * WIDTH / FEW + 1.4)
    panels = figure.subplots(2, len(runs[0][2]), squeeze=False)
    for row, (name, manifest, mine) in zip(panels, runs, strict=True):
        files = [frame.path for frame in mine]
        (views,) = rendered(manifest, files, bottom * manifest.L, (CRACKS,), pixels=PIXELS)
        for axes, view, frame in zip(row, views, mine, strict=True):
            axes.imshow(view)
            axes.set_axis_off()
            axes.set_title(f"{_short(name)}, {moment(manifest, frame.step)}", loc="left")
    add_depths(figure, panels, bottom, "depth over L")
    return figure


def _short(name: str) -> str:
    return name if len(name) <= LONGEST else f"…{name[1 - LONGEST :]}"
