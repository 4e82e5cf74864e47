"""The results of two runs side by side, at the end and at the times of both, as tables."""

from collections.abc import Iterator
from math import isfinite, isnan
from typing import NamedTuple

import numpy as np

from staffa.compare.agreement import ROUND_OFF, gaps, percent
from staffa.compare.pair import READINGS, Pair, Side, caveats
from staffa.display_units import Unit
from staffa.results.columns import by_depth
from staffa.results.mesh_changes import mesh_changes
from staffa.results.production_table import TIMES, production_numbers
from staffa.results.slab_table import run_arrests
from staffa.results.tables import ABSENT, Cell, Table, columns_of, number

MOST = 8  # rows of the table of common times
TOLD = (
    *("cracks", "spacing", "deepest crack", "crack size", "total energy"),
    "production temperature",
)
WITHOUT = " without cracks"  # ending of the name of a number of the shadow
ANY_SIZE = ("length", "T", "pressure")  # kinds of numbers that do not grow with the body
APART = (
    " Apart: the difference of the total energies over the larger of them, parts below zero "
    "counted by size."
)


class Number(NamedTuple):
    """A number at the end of a run.

    whole: it grows with the body. kelvin: size of its unit (K), if its zero is by convention.
    """

    name: str
    value: float | None
    whole: bool = False
    kelvin: float | None = None


def results(pair: Pair) -> Table:
    """Return the effort of each run, and what it found at its end."""
    rows: list[tuple[Cell, ...]] = []
    for of in (_end, _at_depths, _generations):
        one, other = ({n.name: n for n in of(pair, side)} for side in pair.sides)
        longer, shorter = (one, other) if len(one) >= len(other) else (other, one)
        for name, found in (longer | shorter).items() if shorter else ():
            a, b = (side[name].value if name in side else None for side in (one, other))
            if of is not _at_depths or (name in one and name in other):
                apart = ABSENT if found.whole and not pair.alike else _apart(found, a, b)
                rows.append((name, number(a), number(b), apart))
    return Table(
        title="Results",
        columns=columns_of("at the end", *pair.names, "difference"),
        rows=tuple(rows),
        notes=(
            "Difference: the second run against the first. First crack: the first step with a tip. "
            "Spacing: the mean along the face, of all cracks. Generations and depths are those of "
            "`staffa show`.",
            *caveats(pair),
        ),
    )


def common_times(pair: Pair) -> Table:
    """Return the readings at times that both runs have, evenly spread; no rows without any."""
    title, count = "At common times", len(pair.common)
    if not count:
        return Table(title=title, notes=("The runs have no time in common.",))
    chosen = np.linspace(0, count - 1, min(count, MOST)).round().astype(int)
    read = {name: np.array(pair.both(name))[:, chosen] for name in TOLD if name in pair.units}
    read = {name: values for name, values in read.items() if np.isfinite(values).any()}
    at = pair.times[0][pair.common[chosen, 0]]
    cells = [[number(float(when)) for when in at]]
    cells += [[f"{_text(a)} / {_text(b)}" for a, b in values.T] for values in read.values()]
    names = [_clock(pair), *map(pair.named, read)]
    if pair.alike:
        names.append("apart")
        cells.append([percent(gap) for gap in gaps(pair, "total energy")[chosen]])
    return Table(
        title=title,
        columns=columns_of(*names),
        rows=tuple(zip(*cells, strict=True)),
        notes=(f"Each cell: {pair.names[0]} / {pair.names[1]}.{APART if pair.alike else ''}",),
    )


def _text(value: float) -> str:
    return number(float(value) if np.isfinite(value) else None)


def _end(pair: Pair, side: Side) -> Iterator[Number]:
    """Give the effort of a run, when it ended and first cracked, and its last readings."""
    run, times = side.run, pair.times[pair.sides.index(side)]
    every = run.computed
    yield Number("steps", len(every))
    yield Number("sweeps", sum(step.sweeps for step in every))
    yield Number("computing (s)", sum(step.seconds for step in every))
    yield Number("violations", sum(len(s.audit.violations) for s in every if s.audit))
    yield Number(f"last {_clock(pair)}", float(times[-1]) if pair.clock else None)
    cracked = times[side.readings["cracks"] > 0]
    if pair.clock and cracked.size:
        yield Number(f"first crack, {_clock(pair)}", float(cracked[0]))
    for name in pair.units:
        last = float(side.readings[name][-1])
        if np.isfinite(last):
            value = int(last) if name == "cracks" else last
            kind = READINGS[name][1]
            kelvin = side.water["T"].size if kind == "T" else None
            yield Number(pair.named(name), value, kind not in ANY_SIZE, kelvin)
    yield from _mesh(pair, side)
    yield from _production(pair, side)


def _mesh(pair: Pair, side: Side) -> Iterator[Number]:
    """Give the changes of the mesh, where that of either run follows the cracks."""
    if not any(one.run.manifest.refined for one in pair.sides):
        return
    found = mesh_changes(side.run)
    yield Number("cells of the mesh, start", found.start, True)
    yield Number("cells of the mesh, end", found.end, True)
    yield Number("times that cells were split", found.times)
    yield Number("largest damage in a coarse cell", found.coarse_damage)


def _production(pair: Pair, side: Side) -> Iterator[Number]:
    """Give when the water of a run gets colder, and its pressures, with cracks and without."""
    found = {one.name: one for one in production_numbers(side.run)}
    if not found or pair.clock != "t":
        return
    units = dict.fromkeys(TIMES, Unit(name=pair.time_unit.strip(), size=side.time))
    units |= {"peak pressure": side.water["pressure"], "exchange area": Unit(name="m²")}
    units["pressure difference"] = Unit(name="kPa", size=1e3)
    for name, unit in units.items():
        values = {"": found[name].value, WITHOUT: found[name].without}
        for ending, value in values.items():
            if ending and isnan(value):
                continue
            shown = unit.of(value) if isfinite(value) else None
            yield Number(unit.header(f"{name}{ending}"), shown, name == "exchange area")


def _at_depths(pair: Pair, side: Side) -> Iterator[Number]:
    """Give the cracks at each depth, and of a 3-D body the cells and their spacing."""
    unit, measures = pair.length_unit, side.run.steps[-1].measures
    for section in measures.sections if measures else ():
        yield Number(f"cracks at {section.height / side.length:.6g}{unit}", section.cracks, True)
    for depth, found in by_depth([side.run]).items():
        apart, place = found.spacing.value, f"{depth / side.length:.6g}{unit}"
        yield Number(f"cells at {place}", found.number, True)
        yield Number(f"spacing at {place}", None if apart is None else apart / side.length)


def _generations(pair: Pair, side: Side) -> Iterator[Number]:
    """Give nucleation, the arrests of generations, and what is left."""
    found = run_arrests(side.run)
    if found is None:
        return
    unit = _in_brackets(pair.length_unit)
    for k, end in enumerate((found.nucleation, *found.generations)):
        if end is not None:
            name = f"generation {k}" if k else "nucleation"
            yield Number(f"{name}, cracks", end.cracks, True)
            yield Number(f"{name}, depth{unit}", end.depth / side.length)
            if pair.clock:
                when = end.tau if pair.clock == "tau" else end.time / side.time
                yield Number(f"{name}, {_clock(pair)}", when)
    yield Number("in no generation", found.left, True)
    yield Number("of these growing", found.growing, True)


def _clock(pair: Pair) -> str:
    return f"{pair.clock or 'time'}{_in_brackets(pair.time_unit)}"


def _in_brackets(unit: str) -> str:
    return f" ({unit.strip()})" if unit else ""


def _apart(found: Number, a: float | None, b: float | None) -> str:
    """Return the second number against the first; of temperatures the difference in K."""
    if found.kelvin is None or a is None or b is None:
        return shown_difference(a, b)
    return f"{found.kelvin * (b - a):+.3g} K" if a != b else "0"


def shown_difference(a: float | None, b: float | None) -> str:
    """Return the second number against the first: of counts as such, of others in percent.

    Parameters
    ----------
    a, b : the numbers, None where not known.
    """
    if a is None or b is None:
        return ABSENT
    if abs(b - a) <= ROUND_OFF * abs(a):
        return "0"
    if isinstance(a, int) and isinstance(b, int):
        return f"{b - a:+d}"
    return f"{'+' if b > a else '-'}{percent(abs((b - a) / a))}" if a else ABSENT
