"""The results of two runs side by side, at the end and at the times of both, as tables."""

from collections.abc import Iterator, Sequence

import numpy as np

from staffa.compare.agreement import ROUND_OFF, gaps, percent
from staffa.compare.pair import Pair, Side, caveats
from staffa.compare.readings import named, readings
from staffa.records.step import Step
from staffa.results.columns import by_depth
from staffa.results.ensemble_means import number
from staffa.results.slab_table import ABSENT, Table, run_arrests

MOST = 8  # rows of the table of common times
TOLD = ("cracks", "spacing", "deepest crack", "crack length", "crack area", "total energy")
Row = tuple[str, str, str, str]


def results(pair: Pair) -> Table:
    """What it took, and what each run found at its end."""
    rows: list[Row] = [*_effort(pair), *_onset(pair)]
    last = [side.run.steps[-1] for side in pair.sides]
    for reading in readings(pair).values():
        values = reading.of(pair, (last[0], last[1]))
        if values != (None, None):
            rows.append(_row(pair, named(reading), values, whole=reading.whole))
    return Table(
        header=("at the end", *pair.names, "difference"),
        rows=(*rows, *_crossing(pair, last), *_columns(pair), *_generations(pair)),
        notes=(
            "Difference: the second run against the first. First crack: the first step with a tip. "
            "Spacing: the mean along the face, of all cracks. Generations and depths are those of "
            "`staffa show`.",
            *caveats(pair),
        ),
    )


def common_times(pair: Pair) -> Table:
    """The readings at times that both runs have, evenly spread; no rows without any."""
    shared = pair.common()
    if len(shared) > MOST:
        shared = [shared[i] for i in np.linspace(0, len(shared) - 1, MOST).round().astype(int)]
    read = readings(pair)
    shown = [
        read[name]
        for name in TOLD
        if name in read and any(read[name].of(pair, steps) != (None, None) for steps in shared)
    ]
    apart = ("apart",) if pair.alike else ()
    rows = []
    for steps in shared:
        cells = (" / ".join(map(number, reading.of(pair, steps))) for reading in shown)
        gap = (percent(gaps(pair, [steps], read["total energy"])[0]),) if pair.alike else ()
        rows.append((number(pair.at(steps[0])), *cells, *gap))
    if not rows:
        return Table(header=(), rows=(), notes=("The runs have no time in common.",))
    note = f"Each cell: {pair.names[0]} / {pair.names[1]}."
    if pair.alike:
        note += (
            " Apart: the difference of the total energies over the larger of them, parts below "
            "zero counted by size."
        )
    return Table(
        header=(_clock(pair) if pair.clock else "", *map(named, shown), *apart),
        rows=tuple(rows),
        notes=(note,),
    )


def _effort(pair: Pair) -> Iterator[Row]:
    every = [(*side.run.steps, *side.run.superseded, *side.run.rejected) for side in pair.sides]
    a, b = every
    yield _row(pair, "steps", (len(a), len(b)))
    yield _row(pair, "sweeps", (sum(s.sweeps for s in a), sum(s.sweeps for s in b)))
    seconds = (sum(s.seconds for s in a), sum(s.seconds for s in b))
    yield _row(pair, "computing (s)", seconds)
    failed = [sum(len(s.audit.violations) for s in steps if s.audit) for steps in every]
    yield _row(pair, "violations", (failed[0], failed[1]))


def _onset(pair: Pair) -> Iterator[Row]:
    last = [pair.at(side.run.steps[-1]) for side in pair.sides]
    yield _row(pair, f"last {_clock(pair)}", (last[0], last[1]))
    first = [_first_crack(pair, side) for side in pair.sides]
    if first != [None, None]:
        yield _row(pair, f"first crack, {_clock(pair)}", (first[0], first[1]))


def _first_crack(pair: Pair, side: Side) -> float | None:
    cracked = (step for step in side.run.steps if step.measures and step.measures.tips)
    first = next(cracked, None)
    return None if first is None else pair.at(first)


def _crossing(pair: Pair, last: Sequence[Step]) -> Iterator[Row]:
    """Cracks at each depth at which both runs count them."""
    one, other = (
        {
            float(f"{section.height / side.length:.6g}"): section
            for section in (step.measures.sections if step.measures else ())
        }
        for side, step in zip(pair.sides, last, strict=True)
    )
    unit = f" {pair.length_unit}" if pair.length_unit else ""
    for height in (h for h in one if h in other):
        counts = one[height].cracks, other[height].cracks
        yield _row(pair, f"cracks at {height:.3g}{unit}", counts, whole=True)


def _columns(pair: Pair) -> Iterator[Row]:
    """The number and the spacing of cells at each depth at which both runs of 3-D bodies have
    them."""
    one, other = (
        {
            float(f"{depth / side.length:.6g}"): found
            for depth, found in by_depth([side.run]).items()
        }
        for side in pair.sides
    )
    unit = f" {pair.length_unit}" if pair.length_unit else ""
    for depth in (d for d in one if d in other):
        found = one[depth], other[depth]
        yield _row(
            pair, f"cells at {depth:.3g}{unit}", (found[0].number, found[1].number), whole=True
        )
        spacings = [
            None if known.spacing.value is None else known.spacing.value / side.length
            for known, side in zip(found, pair.sides, strict=True)
        ]
        yield _row(pair, f"spacing at {depth:.3g}{unit}", (spacings[0], spacings[1]))


def _generations(pair: Pair) -> Iterator[Row]:
    """Nucleation, the arrests of generations, and what is left."""
    found = [f for f in (run_arrests(side.run) for side in pair.sides) if f is not None]
    if len(found) < 2:
        return
    unit = f" ({pair.length_unit})" if pair.length_unit else ""
    starts = [(f.nucleation, *f.generations) for f in found]
    for k in range(max(map(len, starts))):
        ends = [s[k] if k < len(s) else None for s in starts]
        name = f"generation {k}" if k else "nucleation"
        counts = [None if e is None else e.cracks for e in ends]
        if counts == [None, None]:
            continue
        yield _row(pair, f"{name}, cracks", (counts[0], counts[1]), whole=True)
        depths = [
            None if e is None else e.depth / side.length
            for e, side in zip(ends, pair.sides, strict=True)
        ]
        yield _row(pair, f"{name}, depth{unit}", (depths[0], depths[1]))
        if pair.clock:
            when = [
                None if e is None else e.tau if pair.clock == "tau" else e.time / pair.first.time
                for e in ends
            ]
            yield _row(pair, f"{name}, {_clock(pair)}", (when[0], when[1]))
    yield _row(pair, "in no generation", (found[0].left, found[1].left), whole=True)
    yield _row(pair, "of these growing", (found[0].growing, found[1].growing), whole=True)


def _clock(pair: Pair) -> str:
    unit = f" ({pair.time_unit})" if pair.time_unit else ""
    return f"{pair.clock or 'time'}{unit}"


def _row(
    pair: Pair, name: str, values: tuple[float | None, float | None], *, whole: bool = False
) -> Row:
    apart = ABSENT if whole and not pair.alike else difference(*values)
    return name, number(values[0]), number(values[1]), apart


def difference(a: float | None, b: float | None) -> str:
    """The second number against the first: of counts as such, of others in percent."""
    if a is None or b is None:
        return ABSENT
    if abs(b - a) <= ROUND_OFF * abs(a):
        return "0"
    if isinstance(a, int) and isinstance(b, int):
        return f"{b - a:+d}"
    return f"{'+' if b > a else '-'}{percent(abs((b - a) / a))}" if a else ABSENT
