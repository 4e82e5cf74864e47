"""Generations of cracks from the tips of all steps: nucleation, arrest and its time."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil
from statistics import median

import numpy as np
from scipy.optimize import linear_sum_assignment

from staffa.records.step import Step, Tip

# A generation counts if more than this share of its cracks has stopped: one straggler at an end
# of the body does not hide an arrest.
MAJORITY = 0.5
# A crack that is slower than this share of its mean speed has stopped: growing ones slow down
# with the heat, to about a half, and stopped ones creep within ell/2.
SLOW = 0.25

# Function from the depth (m) of a recorded tip, and the free distance (m) beyond it, to the depth
# of the sharp tip.
type Sharp = Callable[[float, float | None], float]


def as_recorded(depth: float, room: float | None) -> float:
    """Return the recorded depth itself."""
    return depth


@dataclass(frozen=True, kw_only=True)
class Track:
    """One crack of the last step, followed back in time.

    Attributes
    ----------
    place : last position of its tip along the face (m).
    path : position of its tip at each step (m); None if it was not seen.
    depths : depth of its tip at each step (m); None if it was not seen.
    met : True if it has met a crack of another cooled face, see `Tip.met`.
    """

    place: tuple[float, ...]
    path: tuple[tuple[float, ...] | None, ...]
    depths: tuple[float | None, ...]
    met: bool = False

    @property
    def final(self) -> float:
        """Depth at the last step (m)."""
        return next(depth for depth in reversed(self.depths) if depth is not None)


@dataclass(frozen=True, kw_only=True)
class Nucleation:
    """First step with at least half of the final number of cracks (and two).

    Attributes
    ----------
    cracks : number of cracks at that step.
    spacing : mean spacing of all cracks of the last step, arrested ones included (m); None along a
        face with two directions.
    depth : median depth of the cracks at that step (m).
    tau : dimensionless time of that step; None in a case without it.
    time : time of that step (s).
    """

    cracks: int
    spacing: float | None
    depth: float
    tau: float | None
    time: float


@dataclass(frozen=True, kw_only=True)
class Generation:
    """Cracks that arrest together.

    Attributes
    ----------
    number : number of the generation, counted from 1.
    cracks : number of its cracks.
    depth : median depth of their arrest (m).
    tau : median dimensionless time of arrest; None in a case without it.
    time : median time of arrest (s).
    """

    number: int
    cracks: int
    depth: float
    tau: float | None
    time: float


@dataclass(frozen=True, kw_only=True)
class Arrests:
    """Nucleation and generations of the cracks of a run.

    Attributes
    ----------
    nucleation : first appearance of cracks; None without.
    generations : the generations in their order.
    left : number of cracks in no generation.
    growing : number of these that had not stopped.
    depth : median depth of these (m); None without any.
    """

    nucleation: Nucleation | None
    generations: tuple[Generation, ...]
    left: int
    growing: int
    depth: float | None


def arrests(steps: Sequence[Step], *, axis: int, ell: float, sharp: Sharp = as_recorded) -> Arrests:
    """Sort the cracks of the last step into generations.

    The arrest of a crack is the first step at which its tip was within ell/2 of its final depth.
    The crack has stopped if a quarter of its mean speed until then (final depth over tau) would
    have carried it by more than ell/2 since.

    Generation k is the shallower half of the cracks that generation k - 1 left (Bahr's period
    doubling). The cracks are sorted by depth and parted at the largest ratio of neighboring depths
    that parts them no worse than one to two: depths of arrest grow in proportion from one
    generation to the next. If the medians of the two parts differ by less than ell, all cracks left
    are one generation. A generation counts if more than half of its cracks have stopped. The search
    ends at the first that does not count, or with fewer than two cracks left. Cracks that have met
    one of another cooled face are in no generation, and not left.

    Parameters
    ----------
    steps : records of the run in order.
    axis : axis along which depth is measured.
    ell : regularization length (m).
    sharp : depth (m) of the sharp tip from that of the recorded tip (`Manifest.sharp`).
    """
    seen = [step for step in steps if step.measures is not None]
    whole = sorted(tracks(seen, axis=axis, sharp=sharp), key=lambda track: track.final)
    nucleation = _nucleation(seen, whole, sharp)
    rest = [track for track in whole if not track.met]
    found: list[Generation] = []
    while len(rest) > 1:
        members = rest[: _doubling(rest, ell)]
        stopped = [_has_stopped(track, seen, ell) for track in members]
        if sum(stopped) <= MAJORITY * len(members):
            break
        found.append(_generation(len(found) + 1, members, seen, ell))
        rest = rest[len(members) :]
    return Arrests(
        nucleation=nucleation,
        generations=tuple(found),
        left=len(rest),
        growing=sum(not _has_stopped(track, seen, ell) for track in rest),
        depth=median(track.final for track in rest) if rest else None,
    )


def tracks(steps: Sequence[Step], *, axis: int, sharp: Sharp = as_recorded) -> tuple[Track, ...]:
    """Follow each crack of the last measured step back from step to step.

    The tips of two steps are paired so that the sum of their distances is least. The two of a pair
    are nearer along the face than half the distance from the later one to the next tip. So no tip
    is taken twice, a crack may curve, and one that passes below another is not lost. Depths are
    those of sharp tips, as in `arrests`.

    Parameters
    ----------
    steps : records of the run in order.
    axis : axis along which depth is measured.
    sharp : depth (m) of the sharp tip from that of the recorded tip.
    """
    measured = [index for index, step in enumerate(steps) if step.measures is not None]
    tips = _tips(steps[measured[-1]]) if measured else ()
    if not tips:
        return ()
    followed: list[list[Tip | None]] = [[None] * len(steps) for _ in tips]
    for history, tip in zip(followed, tips, strict=True):
        history[measured[-1]] = tip
    now = list(tips)
    for index in reversed(measured[:-1]):
        before = _tips(steps[index])
        for number, earlier in _pairs(now, before, axis):
            followed[number][index] = now[number] = before[earlier]
    return tuple(
        Track(
            place=_along(tip, axis),
            path=tuple(None if seen is None else seen.position for seen in history),
            depths=tuple(
                None if seen is None else sharp(seen.depth, seen.room) for seen in history
            ),
            met=tip.met,
        )
        for tip, history in zip(tips, followed, strict=True)
    )


def _pairs(now: Sequence[Tip], before: Sequence[Tip], axis: int) -> list[tuple[int, int]]:
    """Return pairs (crack, earlier tip) that belong together."""
    if not before:
        return []
    apart = _distances([tip.position for tip in now], [tip.position for tip in before])
    aside = _distances([_along(tip, axis) for tip in now], [_along(tip, axis) for tip in before])
    between = _distances([tip.position for tip in now], [tip.position for tip in now])
    np.fill_diagonal(between, np.inf)
    possible = aside < between.min(axis=1, initial=np.inf)[:, None] / 2
    none = 1.0 + len(now) * apart.max()  # worse than all pairs together
    pairs = zip(*linear_sum_assignment(np.where(possible, apart, none)), strict=True)
    return [(int(i), int(k)) for i, k in pairs if possible[i, k]]


def _distances(here: Sequence[Sequence[float]], there: Sequence[Sequence[float]]) -> np.ndarray:
    return np.asarray(np.linalg.norm(np.array(here)[:, None] - np.array(there)[None], axis=2))


def _tips(step: Step) -> tuple[Tip, ...]:
    return step.measures.tips if step.measures else ()


def _along(tip: Tip, axis: int) -> tuple[float, ...]:
    return tuple(c for i, c in enumerate(tip.position) if i != axis)


def _clock(step: Step) -> float:
    return step.time if step.tau is None else step.tau


def _arrest(track: Track, steps: Sequence[Step], ell: float) -> Step:
    there = (d is not None and d >= track.final - ell / 2 for d in track.depths)
    return steps[next(index for index, reached in enumerate(there) if reached)]


def _has_stopped(track: Track, steps: Sequence[Step], ell: float) -> bool:
    arrest, end = _clock(_arrest(track, steps, ell)), _clock(steps[-1])
    return SLOW * track.final * (end - arrest) > ell / 2 * arrest


def _doubling(rest: Sequence[Track], ell: float) -> int:
    """Return the number of cracks in the shallower half; the cracks are sorted by depth."""
    depth, n = [track.final for track in rest], len(rest)
    splits = range(ceil(n / 3), n - ceil(n / 3) + 1)
    # Of equal ratios, that nearest to the middle.
    at_least = [max(final, ell) for final in depth]  # within ell of the face all are the same
    ratios = {k: round(at_least[k] / at_least[k - 1], 9) for k in splits}
    split = max(splits, key=lambda k: (ratios[k], -abs(2 * k - n)))
    return split if median(depth[split:]) - median(depth[:split]) >= ell else n


def _generation(
    number: int, members: Sequence[Track], steps: Sequence[Step], ell: float
) -> Generation:
    ends = [_arrest(track, steps, ell) for track in members]
    taus = [step.tau for step in ends if step.tau is not None]
    return Generation(
        number=number,
        cracks=len(members),
        depth=median(track.final for track in members),
        tau=median(taus) if taus else None,
        time=median(step.time for step in ends),
    )


def _nucleation(steps: Sequence[Step], cracks: Sequence[Track], sharp: Sharp) -> Nucleation | None:
    enough = max(2, len(cracks) / 2)
    for step in steps:
        if len(_tips(step)) >= enough:
            return Nucleation(
                cracks=len(_tips(step)),
                spacing=_spacing(cracks),
                depth=median(sharp(tip.depth, tip.room) for tip in _tips(step)),
                tau=step.tau,
                time=step.time,
            )
    return None


def _spacing(cracks: Sequence[Track]) -> float | None:
    if len(cracks) < 2 or len(cracks[0].place) != 1:
        return None
    places = sorted(track.place[0] for track in cracks)
    return float(np.mean([b - a for a, b in pairwise(places)]))
