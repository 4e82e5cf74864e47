"""The cost of a run in 3-D: laws fitted to runs of several sizes, and a forecast of a larger one.

With N displacement unknowns on R ranks, a sweep takes seconds = c (N/R)^p R^s, and all ranks
together hold bytes = a R + b N. p: how a rank's time grows with its share (1: in proportion).
s: what more ranks cost at the same share (0: nothing, ideal weak scaling).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

# Of how many runs like the predicted one the interval should hold the time.
CONFIDENCE = 0.9


@dataclass(frozen=True, kw_only=True)
class Law:
    """log(seconds of a sweep) = log_c + p log(N/R) + s log(R), and bytes = a R + b N.

    covariance: of (log_c, p, s), of shape (3, 3); scatter: of log(seconds) about the law; freedom:
    runs less coefficients; memory_scatter: of bytes about the law, as a fraction.
    """

    log_c: float
    p: float
    s: float
    covariance: tuple[tuple[float, ...], ...]
    scatter: float
    freedom: int
    bytes_a_rank: float
    bytes_an_unknown: float
    memory_scatter: float


@dataclass(frozen=True, kw_only=True)
class Cost:
    """The cost of a run: hours and core_hours, each within a factor; GB on all ranks together."""

    sweeps: float
    seconds_a_sweep: float
    hours: float
    core_hours: float
    factor: float
    GB: float


def law(runs: Sequence[dict]) -> Law:
    """The laws that fit these runs best, by least squares.

    Parameters
    ----------
    runs : with keys unknowns, ranks, seconds (of all sweeps), sweeps, peak_bytes.

    Raises
    ------
    ValueError
        There are too few runs to tell the coefficients and their errors.
    """
    N, R = (np.array([run[key] for run in runs], dtype=float) for key in ("unknowns", "ranks"))
    if len(runs) < 4 or len(set(R)) < 2 or len(set(N)) < 2:
        raise ValueError("a cost law needs four runs, of two sizes and on two numbers of ranks")
    y = np.log([run["seconds"] / run["sweeps"] for run in runs])
    terms = _terms(N, R)
    best, *_ = np.linalg.lstsq(terms, y, rcond=None)
    freedom = len(runs) - terms.shape[1]
    scatter = float(np.sqrt(((y - terms @ best) ** 2).sum() / freedom))
    covariance = scatter**2 * np.linalg.inv(terms.T @ terms)
    held = np.array([run["peak_bytes"] for run in runs], dtype=float)
    # Weighed so that each run counts by its relative error: the largest alone would decide.
    weighed = np.column_stack([R, N]) / held[:, None]
    memory, *_ = np.linalg.lstsq(weighed, np.ones(len(runs)), rcond=None)
    off = weighed @ memory - 1
    return Law(
        log_c=float(best[0]),
        p=float(best[1]),
        s=float(best[2]),
        covariance=tuple(tuple(float(x) for x in row) for row in covariance),
        scatter=scatter,
        freedom=freedom,
        bytes_a_rank=float(memory[0]),
        bytes_an_unknown=float(memory[1]),
        memory_scatter=float(np.sqrt((off**2).sum() / (len(runs) - 2))),
    )


def predict(law: Law, *, unknowns: float, ranks: int, steps: int, sweeps: float) -> Cost:
    """The cost of a run, by its number of steps and of sweeps in each."""
    term = _terms(np.array([unknowns], dtype=float), np.array([ranks], dtype=float))[0]
    seconds = float(np.exp(term @ np.array([law.log_c, law.p, law.s])))
    spread = np.sqrt(law.scatter**2 + term @ np.array(law.covariance) @ term)
    hours = seconds * steps * sweeps / 3600
    return Cost(
        sweeps=steps * sweeps,
        seconds_a_sweep=seconds,
        hours=hours,
        core_hours=hours * ranks,
        factor=float(np.exp(stats.t.ppf((1 + CONFIDENCE) / 2, law.freedom) * spread)),
        GB=(law.bytes_a_rank * ranks + law.bytes_an_unknown * unknowns) / 1e9,
    )


def held_out(runs: Sequence[dict]) -> list[tuple[dict, Cost]]:
    """The runs of the largest size, beside what the others say of them; none of two sizes."""
    largest = max(run["unknowns"] for run in runs)
    smaller = [run for run in runs if run["unknowns"] < largest]
    if len({run["unknowns"] for run in smaller}) < 2:
        return []
    known = law(smaller)
    return [beside(known, run) for run in runs if run["unknowns"] == largest]


def beside(law: Law, run: dict) -> tuple[dict, Cost]:
    """A run, and what a law says of it."""
    cost = predict(law, unknowns=run["unknowns"], ranks=run["ranks"], steps=1, sweeps=run["sweeps"])
    return run, cost


def _terms(N: np.ndarray, R: np.ndarray) -> np.ndarray:
    return np.column_stack([np.ones_like(N), np.log(N / R), np.log(R)])
