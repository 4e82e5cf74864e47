"""Whether two runs agree, and from when on not: their results side by side."""

from collections.abc import Iterator, Sequence

import numpy as np

from staffa.compare.pair import Pair, Side
from staffa.compare.readings import Reading, readings
from staffa.records.step import Step
from staffa.results.summary import Fact

CLOSE = 0.01  # energies that differ by less agree; the second digit of a mesh is worth no more
ROUND_OFF = 1e-12  # parts of the whole below this are the order in which ranks add up
Steps = tuple[Step, Step]


def agreement(pair: Pair) -> Iterator[Fact]:
    """Do the runs agree, and from when on not: at the times of both, and between them."""
    shared, counts = pair.common(), [len(side.run.steps) for side in pair.sides]
    told = f"{len(shared)} of {counts[0]} and of {counts[1]} steps"
    if shared:
        told += f", {_when(pair, shared[0])} to {_when(pair, shared[-1])}"
    yield Fact(name="common times", text=told)
    if pair.alike and shared:
        yield _energies_agree(pair, shared)
        yield Fact(name="largest differences", text=_largest(pair, shared))
    if pair.alike and len(shared) < max(counts):
        yield from _between(pair)
    found = readings(pair)
    if pair.alike:
        yield from _same_number(pair, shared, found["cracks"])
    yield from _as_deep(pair, shared, found["deepest crack"])


def percent(part: float) -> str:
    """A part of the whole to two digits, 0 for round-off."""
    if part < ROUND_OFF:
        return "0 %"
    return f"{100 * part:.2g} %" if part < 1 else f"{100 * part:.0f} %"


def gap_between_steps(pair: Pair) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) of either run where both know something, and how far apart total energies are.

    Each is interpolated linearly between its steps; the difference is over the larger sum of sizes.
    """
    curves = [
        np.array(
            [
                [pair.at(step), step.energies.total / side.energy, _sizes(side, step)]
                for step in side.run.steps
            ]
        )
        for side in pair.sides
    ]
    begin, end = max(c[0, 0] for c in curves), min(c[-1, 0] for c in curves)
    at = np.unique(np.concatenate([c[:, 0] for c in curves]))
    at = at[(at >= begin) & (at <= end)]
    (one, whole), (other, larger) = (
        [np.interp(at, c[:, 0], column) for column in c.T[1:]] for c in curves
    )
    return at, _over(abs(one - other), np.maximum(whole, larger))


def _sizes(side: Side, step: Step) -> float:
    """|elastic| + |surface| + |loads| + |friction|: a total that loads cannot bring near zero."""
    e = step.energies
    return (abs(e.elastic) + abs(e.surface) + abs(e.loads) + abs(e.friction)) / side.energy


def _over(part: np.ndarray, whole: np.ndarray) -> np.ndarray:
    """A quotient, 0 where there is nothing to divide by."""
    return np.asarray(np.divide(part, whole, out=np.zeros_like(part), where=whole > 0))


def gaps(pair: Pair, shared: Sequence[Steps], energy: Reading) -> np.ndarray:
    """Differences of an energy over the larger sum of sizes of the two, shape (n,)."""
    values = [[value or 0.0 for value in energy.of(pair, steps)] for steps in shared]
    sizes = [[_sizes(*one) for one in zip(pair.sides, steps, strict=True)] for steps in shared]
    return _over(abs(np.diff(values)[:, 0]), np.max(sizes, axis=1))


def _energies_agree(pair: Pair, shared: Sequence[Steps]) -> Fact:
    apart = gaps(pair, shared, readings(pair)["total energy"])
    beyond, most = np.flatnonzero(apart > CLOSE), int(apart.argmax())
    largest = f"at most {percent(apart[most])} apart, {_when(pair, shared[most])}"
    if apart[most] < ROUND_OFF:
        text = "the same, to round-off, at all common times"
    elif not beyond.size:
        text = f"within {percent(CLOSE)} at all common times: {largest}"
    else:
        first = _when(pair, shared[beyond[0]])
        again = "" if beyond.size == len(apart) - beyond[0] else ", later closer again"
        last = f"{percent(apart[-1])} at the last common time"
        text = f"more than {percent(CLOSE)} apart from {first} on{again}; {largest}; {last}"
    return Fact(name="total energy", text=text, alarm=bool(beyond.size))


def _largest(pair: Pair, shared: Sequence[Steps]) -> str:
    """Of each energy, and when."""
    told, loaded = [], any(step.energies.loads for steps in shared for step in steps)
    names = {"elastic": "elastic energy", "surface": "surface energy", "total": "total energy"}
    for short, name in {**names, **({"loads": "energy of loads"} if loaded else {})}.items():
        apart = gaps(pair, shared, readings(pair)[name])
        most = int(apart.argmax())
        told.append(f"{short} {apart[most]:.1e}, {_when(pair, shared[most])}")
    whole = "sum of their sizes" if loaded else "total energy"
    return f"{'; '.join(told)}; over the larger {whole} at that time"


def _between(pair: Pair) -> Iterator[Fact]:
    if pair.clock is None:
        return
    at, apart = gap_between_steps(pair)
    if at.size:
        most = int(apart.argmax())
        largest = f"at most {percent(apart[most])} apart, {pair.moment(at[most])}"
        yield Fact(name="between steps", text=f"total energies, interpolated, {largest}")


def _same_number(pair: Pair, shared: Sequence[Steps], cracks: Reading) -> Iterator[Fact]:
    known = [(cracks.of(pair, steps), steps) for steps in shared]
    known = [(counts, steps) for counts, steps in known if None not in counts]
    differ = [(counts, steps) for counts, steps in known if counts[0] != counts[1]]
    if not known:
        return
    if not differ:
        yield Fact(name="number of cracks", text="the same at all common times")
        return
    (a, b), steps = differ[0]
    (c, d), _ = known[-1]
    first = f"first differs at {_when(pair, steps)}, {a} and {b}"
    text = f"{first}; {c} and {d} at the last common time"
    yield Fact(name="number of cracks", text=text, alarm=True)


def _as_deep(pair: Pair, shared: Sequence[Steps], deepest: Reading) -> Iterator[Fact]:
    depths = [(*deepest.of(pair, steps), steps) for steps in shared]
    known = [(abs(b - a), steps) for a, b, steps in depths if a is not None and b is not None]
    if not known:
        return
    most, steps = max(known, key=lambda found: found[0])
    ell = pair.first.run.manifest.ell / pair.first.length
    unit = f" {pair.length_unit}" if pair.length_unit else ""
    text = f"at most {most:.3g}{unit} apart ({most / ell:.2g} ell), {_when(pair, steps)}"
    if most < ROUND_OFF * ell:
        text = "as deep at all common times"
    yield Fact(name="deepest crack", text=text)


def _when(pair: Pair, steps: Steps) -> str:
    return pair.moment(pair.at(steps[0]))
