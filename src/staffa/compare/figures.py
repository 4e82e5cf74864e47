"""Which pictures two runs have in common, and from which of their numbers each is drawn."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from staffa.compare.agreement import gap_between_steps
from staffa.compare.pair import Pair, Side
from staffa.compare.readings import Reading, named, readings
from staffa.plot.frames import Frame, evenly_spread, read_frames
from staffa.plot.labels import TAU, add_tau, tau_label
from staffa.plot.pair_pictures import (
    FEW,
    LONG,
    Curve,
    Panel,
    curves_figure,
    fields_figure,
    volumes_figure,
)
from staffa.records.manifest import Manifest

Figures = dict[str, Callable[[], Figure]]
ENERGIES = ("total energy", "elastic energy", "surface energy", "energy of loads")
GROWTH = ("crack length", "crack area", "deepest crack", "cracks")


def pair_figures(pair: Pair) -> tuple[Figures, list[str]]:
    """How to draw each picture, by name, and the reasons for those that cannot be drawn."""
    figures, skipped = _fields(pair)
    if pair.clock is None:
        return figures, [*skipped, "curves: the runs have no clock in common"]
    if pair.dim is None:
        skipped.append("energies-of-both: those of bodies of two kinds have different units")
    else:
        panels = _panels(pair, ENERGIES)
        if pair.alike:
            at, apart = gap_between_steps(pair)
            curve = at.tolist(), (100 * apart).tolist()
            panels.append(Panel(label="apart (%)", curves=(curve,)))
        figures["energies-of-both"] = _curves(pair, panels)
    growth = _panels(pair, GROWTH if pair.dim else GROWTH[2:])
    if growth:
        figures["growth-of-both"] = _curves(pair, growth)
    else:
        skipped.append("growth-of-both: no step was measured")
    return figures, skipped


def _curves(pair: Pair, panels: list[Panel]) -> Callable[[], Figure]:
    return partial(curves_figure, pair.names, panels, partial(_name_clock, pair))


def _name_clock(pair: Pair, axes: Axes) -> None:
    """Name the axis of time, with tau below it where it is the same of both."""
    manifest = pair.first.run.manifest
    if pair.clock == "tau":
        alike = {side.run.manifest.profile for side in pair.sides} == {manifest.profile}
        axes.set_xlabel(tau_label(manifest) if alike else TAU, parse_math=True)
        return
    axes.set_xlabel(pair.shown.time.label("time"))
    last = pair.first.run.steps[-1]
    if pair.root is not None and last.tau:
        add_tau(axes, pair.shown.time.of(last.time), last.tau, tau_label(manifest))


def _panels(pair: Pair, names: tuple[str, ...]) -> list[Panel]:
    """A panel for each of the readings that both runs have."""
    found, panels = readings(pair), []
    for reading in (found[name] for name in names if name in found):
        first, second = (_curve(pair, side, reading) for side in pair.sides)
        if first[0] and second[0]:
            counts = reading.name == "cracks"
            label = named(reading) if counts or reading.unit else f"{reading.name} (scaled)"
            panels.append(Panel(label=label, curves=(first, second), counts=counts))
    return panels


def _curve(pair: Pair, side: Side, reading: Reading) -> Curve:
    read = ((pair.at(step), reading.value(side, step)) for step in side.run.steps)
    known = [(at, value) for at, value in read if at is not None and value is not None]
    return [at for at, _ in known], [value for _, value in known]


def _fields(pair: Pair) -> tuple[Figures, list[str]]:
    if pair.dim is None:
        return {}, ["cracks-of-both: the bodies are of two kinds"]
    frames, skipped = _frames(pair)
    if not frames:
        return {}, [*skipped, "cracks-of-both: there is no time whose fields both runs kept"]
    manifests = _in_common_units(pair)
    ratio = pair.first.length / pair.second.length
    if pair.dim == 2:
        draw = partial(fields_figure, pair.names, manifests, frames, ratio)
    else:
        draw = partial(volumes_figure, pair.names, manifests, frames)
    return {"cracks-of-both": draw}, skipped


def _in_common_units(pair: Pair) -> list[Manifest]:
    """Ends of both; where both have units, in those of the first run."""
    one, other = (side.run.manifest for side in pair.sides)
    if one.scaled or other.scaled:
        return [one, other]
    return [one, replace(other, units=vars(pair.shown))]


def _frames(pair: Pair) -> tuple[list[tuple[Frame, Frame]], list[str]]:
    """Fields at times that both runs kept, and a sentence on each file that cannot be read."""
    kept = [steps for steps in pair.common() if steps[0].fields and steps[1].fields]
    chosen = evenly_spread(kept)
    width, height = pair.first.run.manifest.size[:2]
    if pair.dim == 2 and width > LONG * height:
        chosen = chosen[-FEW:]  # in one column
    read = [
        read_frames(side.run, [steps[k] for steps in chosen]) for k, side in enumerate(pair.sides)
    ]
    there = [{frame.step.index: frame for frame in frames} for frames, _ in read]
    both = [
        (there[0][one.index], there[1][other.index])
        for one, other in chosen
        if one.index in there[0] and other.index in there[1]
    ]
    told = zip(pair.names, read, strict=True)
    return both, [f"{name}: {reason}" for name, (_, reasons) in told for reason in reasons]
