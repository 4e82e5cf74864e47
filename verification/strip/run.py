"""A crack that follows a cold front along a strip, against a sharp crack.

    python -m verification.strip.phases NAME ...

makes the runs of the phase diagram that are not kept yet (`verification/strip/phases.py`).
"""

from functools import cache
from math import sqrt
from pathlib import Path

import numpy as np

from staffa.io.run_directory import Run
from staffa.measure.tip import reach
from verification.common.figures import Check, Figure, Found
from verification.common.runs import fresh_run
from verification.strip.phases import phases
from verification.strip.sharp_strip import Release, Strip, front

CASE = Path(__file__).parent / "case.toml"
SHARP = "sharp-crack finite elements"
SPEEDS = (5, 10)  # Peclet numbers
ABOVE = (1.5, 2.0)  # W/ell0 over its threshold
# The same where faces touch, by Peclet number; with faces that overlap no crack would grow there.
ABOVE_TOUCHING = {5: 1.5, 10: 1.3}
STEADY = 0.6  # time from which the crack is followed: the front has then passed the notch
# W/ell0 over its threshold while it falls: START - FALL t.
START, FALL = 2.0, 1.2
GROWS = 0.1  # part of the speed of the front below which a crack counts as stopped
ROWS = 64


@cache
def sharp(peclet: int, rows: int = ROWS) -> Release:
    """The release rate of the sharp crack."""
    return strip(rows).released(front(peclet))


@cache
def touching(peclet: int) -> Release:
    """The release rate of the sharp crack whose faces touch; on coarser cells, as it costs more."""
    return strip(ROWS // 2).released_in_contact(front(peclet))


@cache
def strip(rows: int) -> Strip:
    """The body of the sharp crack, factorized once."""
    return Strip(rows)


def temperature(peclet: int, dT: float, over_time: str = "1") -> str:
    """The setting of the moving front."""
    return f'temperature.T="-{dT:.5g}*{over_time}*where(x < t, 1, exp(-{peclet}*(x - t)))"'


def leads(run: Run) -> list[float]:
    """Distances of the tip ahead of the edge of the bath, at the steps of the steady state."""
    m = run.manifest
    beyond = reach(m.law, threshold=0.8, ell=m.ell, h=m.h)
    assert beyond is not None
    return [
        step.measures.front + beyond - step.time
        for step in run.steps
        if step.measures is not None and step.time > STEADY
    ]


def followed(peclet: int) -> list[Figure]:
    """The place of the tip beside that of the sharp crack, at two loads above the threshold."""
    figures = []
    for times in ABOVE:
        dT = sqrt(times * sharp(peclet).threshold)
        run = fresh_run(CASE, f"strip-{peclet}-{times:g}", temperature(peclet, dT))
        expected = sharp(peclet).steady(times)
        figures.append(
            Figure(
                what=f"tip ahead of the edge of the bath, P = {peclet}, {times:g} times threshold",
                source=SHARP,
                reference=expected,
                measured=float(np.mean(leads(run))),
                tolerance=max(run.manifest.ell, 0.05 * expected),
            )
        )
    return figures


def pried(peclet: int) -> Figure:
    """The place of the tip beside that of a sharp crack whose faces touch behind it."""
    times, crack = ABOVE_TOUCHING[peclet], touching(peclet)
    load = times * crack.threshold
    assert load < sharp(peclet).threshold
    settings = temperature(peclet, sqrt(load)), "damage.split=no-tension"
    run = fresh_run(CASE, f"strip-{peclet}-touching", *settings)
    expected = crack.steady(times)
    return Figure(
        what=f"faces touch: tip ahead of the edge of the bath, P = {peclet}, {times:g} times "
        f"threshold ({load / sharp(peclet).threshold:.2f} times that of faces that overlap)",
        source=SHARP,
        reference=expected,
        measured=float(np.mean(leads(run))),
        tolerance=max(run.manifest.ell, 0.05 * expected),
    )


def threshold(peclet: int) -> Figure:
    """W/ell0 at which a crack stops to follow, while the load falls, beside the sharp crack's."""
    least = sharp(peclet).threshold
    falling = temperature(peclet, sqrt(least), f"sqrt({START} - {FALL}*t)")
    times = "time.t={start=0.3,stop=1.1,steps=41}"
    run = fresh_run(CASE, f"strip-{peclet}-falling", falling, times, "output.at=[1.1]")
    return Figure(
        what=f"W/ell0 at which the crack stops, P = {peclet}",
        source=SHARP,
        reference=least,
        measured=least * (START - FALL * stop_time(run)),
        tolerance=0.07,
        relative=True,
    )


def stop_time(run: Run) -> float:
    """The middle of the step after the last in which the crack grew along with the front."""
    t = np.array([step.time for step in run.steps])
    length = np.array([step.measures.length_surface for step in run.steps if step.measures])
    grew = np.flatnonzero(np.diff(length) > GROWS * np.diff(t))
    last = int(grew[-1]) + 1
    assert last + 1 < len(t), "the crack did not stop"
    return float(t[last] + t[last + 1]) / 2


def converged(peclet: int) -> Figure:
    """The threshold of the sharp crack on cells of twice the size over that on the finer ones."""
    return Figure(
        what=f"threshold of the sharp crack on cells of twice the size over its own, P = {peclet}",
        source="finite elements that have converged",
        reference=1.0,
        measured=sharp(peclet, ROWS // 2).threshold / sharp(peclet).threshold,
        tolerance=0.01,
    )


def measured() -> Found:
    """Thresholds and tips at each speed, and a table of the sharp crack."""
    figures = []
    for peclet in SPEEDS:
        figures += [converged(peclet), threshold(peclet), *followed(peclet), pried(peclet)]
    return Found(figures=figures, text=sharp_table())


def sharp_table() -> str:
    """The table of thresholds and places of the tip of the sharp crack."""
    times = (1.2, 1.5, 2.0, 4.0)
    ahead = " | ".join(f"x/W at {k:g} times" for k in times)
    head = "| P | W/ell0 at the threshold, faces touch | x/W at 1.5 times | at 2 times "
    head += f"| threshold, faces may overlap | x/W there | {ahead} |"
    lines = [head, "|" + " --- |" * 10]
    for peclet in (3, 5, 7, 10, 14, 20, 40):
        found, held = sharp(peclet), touching(peclet)
        places = " | ".join(f"{found.steady(k):.3f}" for k in times)
        at = found.largest[0]
        touch = f"{held.threshold:.3g} | {held.steady(1.5):.3f} | {held.steady(2.0):.3f}"
        lines.append(f"| {peclet} | {touch} | {found.threshold:.3g} | {at:.3f} | {places} |")
    text = "The sharp crack: x is the place of its tip, counted from the edge of the bath."
    return "\n".join([text, "", *lines])


CHECKS = {
    "strip": Check(
        title="A crack that follows a cold front along a strip",
        text=(
            "`verification/strip/case.toml`: a strip with free edges, along which the temperature "
            "of a steady front moves: cold in the bath, exp(-V x/kappa) ahead of it. The reference "
            "(`verification/strip/sharp_strip.py`) is a straight semi-infinite crack in this "
            "field. It grows where W/ell0 is at least the threshold, which depends on the Peclet "
            "number P = W V/kappa alone, and its tip then stays where G = Gc falls ahead of it. "
            "The threshold is measured in a run in which the load falls while the front moves: the "
            "crack stops there. Tolerances: 7 % of the threshold; of places the larger of "
            "ell = 0.033 and 5 %. Faces of the crack may overlap far behind its tip, in the runs "
            "and in the reference. Where it is said, they touch in both (in the runs by the split "
            "`no-tension`), which pries the crack open at a smaller load. "
            "The thresholds that were published (Adda-Bedia and Pomeau, "
            "Phys. Rev. E 52, 4105, 1995; Corson et al., Int. J. Fract. 158, 1, 2009) could not be "
            "looked up and are not compared."
        ),
        measure=measured,
    ),
    "strip-phases": Check(
        title="Straight, wavy and branched cracks behind a cold front",
        text=(
            "`verification/strip/phases.toml` at growing loads, on a mesh that follows the cracks. "
            "Below the threshold of the sharp crack the notch stays as it is. Above, one straight "
            "crack follows the front, and at a large load it parts into several side by side. A "
            "wavy crack, which experiments find between the two, is not among these runs: up to "
            "7.4 times the threshold the crack swings by less than ell. More loads, and other "
            "speeds, are runs of `python -m verification.strip.phases`. Picture: the front in "
            "blue."
        ),
        measure=phases,
        kept="kept.json",
    ),
}
