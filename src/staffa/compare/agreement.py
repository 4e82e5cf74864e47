"""Agreement of two runs: whether there is one, and until when."""

from collections.abc import Iterator, Sequence

import numpy as np

from staffa.compare.pair import Pair
from staffa.results.facts import Fact

CLOSE = 0.01  # energies that differ by less agree; the second digit of a mesh is worth no more
ROUND_OFF = 1e-12  # parts of the whole below this are the order in which ranks add up


def agreement(pair: Pair) -> Iterator[Fact]:
    """Tell whether the runs agree, and until when: at the times of both, and between them."""
    at, counts = pair.times[0][pair.common[:, 0]], [len(times) for times in pair.times]
    told = f"{at.size} of {counts[0]} and of {counts[1]} steps"
    if at.size:
        told += f", {pair.moment(at[0])} to {pair.moment(at[-1])}"
    yield Fact(name="common times", text=told)
    if pair.alike and at.size:
        yield _energies_agree(pair, at)
        yield Fact(name="largest differences", text=_largest(pair, at))
    if pair.alike and at.size < max(counts) and pair.clock:
        between, apart = gap_between_steps(pair)
        if apart.size:
            text = f"total energies, interpolated, {_at_most(pair, between, apart)}"
            yield Fact(name="between steps", text=text)
    if pair.alike:
        yield from _same_number(pair, at)
    yield from _as_deep(pair, at)


def percent(part: float) -> str:
    """Return a part of the whole to two digits, 0 for round-off."""
    if part < ROUND_OFF:
        return "0 %"
    return f"{100 * part:.2g} %" if part < 1 else f"{100 * part:.0f} %"


def gap_between_steps(pair: Pair) -> tuple[np.ndarray, np.ndarray]:
    """Return times (n,) of either run where both know something, and how far energies are apart.

    Each total is interpolated linearly between its steps; the difference is over the larger sum of
    sizes.
    """
    at = np.unique(np.concatenate(pair.times))
    at = at[(at >= max(t[0] for t in pair.times)) & (at <= min(t[-1] for t in pair.times))]
    known = list(zip(pair.times, pair.sides, strict=True))
    totals = [np.interp(at, times, side.readings["total energy"]) for times, side in known]
    sizes = [np.interp(at, times, side.sizes) for times, side in known]
    return at, _apart(totals, sizes)


def gaps(pair: Pair, energy: str) -> np.ndarray:
    """Return differences of an energy at the common times over the larger sum of sizes, (m,)."""
    sizes = [side.sizes[k] for side, k in zip(pair.sides, pair.common.T, strict=True)]
    return _apart(pair.both(energy), sizes)


def _apart(values: Sequence[np.ndarray], sizes: Sequence[np.ndarray]) -> np.ndarray:
    """Return |b - a| over the larger size, 0 where there is nothing to divide by."""
    part, whole = np.abs(values[1] - values[0]), np.maximum(*sizes)
    return np.asarray(np.divide(part, whole, out=np.zeros_like(part), where=whole > 0))


def _at_most(pair: Pair, at: np.ndarray, apart: np.ndarray) -> str:
    most = int(apart.argmax())
    return f"at most {percent(apart[most])} apart, {pair.moment(at[most])}"


def _energies_agree(pair: Pair, at: np.ndarray) -> Fact:
    apart = gaps(pair, "total energy")
    beyond, largest = np.flatnonzero(apart > CLOSE), _at_most(pair, at, apart)
    if apart.max() < ROUND_OFF:
        text = "the same, to round-off, at all common times"
    elif not beyond.size:
        text = f"within {percent(CLOSE)} at all common times: {largest}"
    else:
        again = "" if beyond.size == apart.size - beyond[0] else ", later closer again"
        last = f"{percent(apart[-1])} at the last common time"
        first = f"more than {percent(CLOSE)} apart from {pair.moment(at[beyond[0]])} on{again}"
        text = f"{first}; {largest}; {last}"
    return Fact(name="total energy", text=text, alarm=bool(beyond.size))


def _largest(pair: Pair, at: np.ndarray) -> str:
    """Return the largest difference of each energy, and when."""
    names = {"elastic": "elastic energy", "surface": "surface energy", "total": "total energy"}
    loaded = "energy of loads" in pair.units
    told = []
    for short, name in (names | ({"loads": "energy of loads"} if loaded else {})).items():
        apart = gaps(pair, name)
        most = int(apart.argmax())
        told.append(f"{short} {apart[most]:.1e}, {pair.moment(at[most])}")
    whole = "sum of their sizes" if loaded else "total energy"
    return f"{'; '.join(told)}; over the larger {whole} at that time"


def _same_number(pair: Pair, at: np.ndarray) -> Iterator[Fact]:
    counts = np.array(pair.both("cracks")).T
    known = np.isfinite(counts).all(axis=1)
    if not known.any():
        return
    at, counts = at[known], counts[known].astype(int)
    differ = np.flatnonzero(counts[:, 0] != counts[:, 1])
    text = "the same at all common times"
    if differ.size:
        (a, b), (c, d) = counts[differ[0]], counts[-1]
        text = f"first differs at {pair.moment(at[differ[0]])}, {a} and {b}"
        text += f"; {c} and {d} at the last common time"
    yield Fact(name="number of cracks", text=text, alarm=bool(differ.size))


def _as_deep(pair: Pair, at: np.ndarray) -> Iterator[Fact]:
    apart = np.abs(np.subtract(*pair.both("deepest crack")))
    if not np.isfinite(apart).any():
        return
    most = int(np.nanargmax(apart))
    ell = pair.first.run.manifest.ell / pair.first.length
    text = f"at most {apart[most]:.3g}{pair.length_unit} apart ({apart[most] / ell:.2g} ell), "
    text += pair.moment(at[most])
    if apart[most] < ROUND_OFF * ell:
        text = "as deep at all common times"
    yield Fact(name="deepest crack", text=text)
