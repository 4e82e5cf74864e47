"""First cracks of a cold face with AT1: when the damaged layer breaks up, and into what bands."""

from collections.abc import Iterator
from math import sqrt
from pathlib import Path

from staffa.backend.stack import MPI

import numpy as np

from staffa import build, march, problem, read_case
from staffa.model.fields import vertices
from staffa.records.step import Step
from verification.common.figures import Check, Figure
from verification.onset import layer

CASE = Path(__file__).parent / "case.toml"
# dT/dT_c: the least for which the theory speaks, and a severer one.
RATIOS = (3.0, 5.16)
# The theory gives a range for each. What is asked for is its middle within 15 %: 8.9 to 12.1 and
# .74 to 1.01. That a range is wide widens nothing.
THEORY = {"wavelength": (10.0, 11.0), "sqrt(kappa t)": (0.8, 0.95)}
ALLOWED = 0.15
# Against the layer of the same m. The time is flat about its least: the place is known less well.
EXACT = {"wavelength": 0.05, "sqrt(kappa t)": 0.02}
# Half of it fits between the rollers of a cell, in whole cells of the mesh.
WAVELENGTHS = np.arange(8.0, 13.5, 1.0)
CELL_H = 0.125
# Room for ten bands, half ones on the rollers: half a band more or less is 5 %. The noise is so
# small that the layer is uniform but for it: ten times as much breaks it up 3 % earlier.
WIDTH, STRIP_H, SEEDS, NOISE = 105.0, 1 / 6, (1, 2), 1e-3


def _marched(m: float, *settings: str) -> Iterator[tuple[Step, np.ndarray]]:
    """The steps for dT/dT_c = m, each with the damage along the face, from left to right."""
    ell = layer.regularization_length(m)
    case = read_case(CASE, (f"damage.ell={ell}", f"temperature.dT={sqrt(ell)}", *settings))
    body = problem(case, comm=MPI.COMM_SELF)
    system = build(body)
    x = vertices(system.state.alpha.function_space)
    face = np.flatnonzero(x[:, 1] < body.domain.h / 2)
    face = face[np.argsort(x[face, 0])]
    try:
        for step in march(body, system):
            yield step, system.state.alpha.x.array[face]
    finally:
        system.destroy()


def uniqueness(m: float, wavelength: float, h: float = CELL_H) -> float:
    """sqrt(kappa t) when the smallest eigenvalue of a cell half a wavelength wide crosses zero."""
    settings = (f"domain.size=[{wavelength / 2}, 16.0]", f"domain.h={h}")
    before = None
    for step, _ in _marched(m, *settings, "solver.stability=report"):
        assert step.stability is not None and step.stability.bifurcation is not None
        now = sqrt(step.time), step.stability.bifurcation
        if now[1] < 0 and before:
            return float(np.interp(0.0, (now[1], before[1]), (now[0], before[0])))
        before = now
    raise RuntimeError(f"no eigenvalue crossed zero: dT/dT_c = {m}, wavelength {wavelength}")


def first_mode(m: float, h: float = CELL_H) -> tuple[float, float]:
    """Wavelength whose eigenvalue crosses zero first, and sqrt(kappa t) then."""
    times = np.array([uniqueness(m, wavelength, h) for wavelength in WAVELENGTHS])
    return layer.lowest(WAVELENGTHS, times)


def bands(m: float, seed: int, *settings: str) -> tuple[float, float]:
    """Mean distance of the damage bands, and sqrt(kappa t) when damage goes on in them alone.

    That is when the least damage along the face rises by less than half of what it did in the step
    before; within the step, by the rise. Bands are the maxima then, half ones on the rollers.
    """
    noise = (f"toughness.amplitude={NOISE}", f"toughness.seed={seed}")
    strip = (f"domain.size=[{WIDTH}, 16.0]", f"domain.h={STRIP_H}")
    least: list[tuple[float, float]] = []
    for step, alpha in _marched(m, *strip, *noise, *settings):
        least.append((sqrt(step.time), float(alpha.min())))
        if len(least) < 3:
            continue
        (_, a), (t, b), (now, c) = least[-3:]
        if c - b < (b - a) / 2:
            around = np.concatenate([alpha[1:2], alpha, alpha[-2:-1]])
            peak = (alpha > around[:-2]) & (alpha >= around[2:])
            number = peak.sum() - (int(peak[0]) + int(peak[-1])) / 2
            return WIDTH / float(number), t + (now - t) * (c - b) / (b - a)
    raise RuntimeError(f"the damaged layer did not break up: dT/dT_c = {m}, seed {seed}")


def onset() -> list[Figure]:
    """The first mode of the layer, and the bands that grow from noise."""
    figures = []
    for m in RATIOS:
        found = np.array([bands(m, seed) for seed in SEEDS]).mean(axis=0)
        mode, exact = first_mode(m), layer.onset(m)
        ways = {"first eigenvalue": mode, "bands from noise": tuple(found)}
        for place, (what, ends) in enumerate(THEORY.items()):
            figures += [
                Figure(
                    what=f"{what} over sqrt(ell ell0), {way}, dT/dT_c = {m:g}",
                    source=f"theory, {ends[0]:g} to {ends[1]:g}",
                    reference=sum(ends) / 2,
                    measured=values[place],
                    tolerance=ALLOWED,
                    relative=True,
                )
                for way, values in ways.items()
            ]
            figures.append(
                Figure(
                    what=f"{what} over sqrt(ell ell0), first eigenvalue, dT/dT_c = {m:g}",
                    source="the layer wave by wave, in one dimension",
                    reference=exact[place],
                    measured=mode[place],
                    tolerance=EXACT[what],
                    relative=True,
                )
            )
    return figures


CHECKS = {
    "onset": Check(
        title="The first cracks of a cold face, with AT1",
        text=(
            "A layer of damage under the face loses uniqueness, and breaks into a wavelength. Both "
            "are found in two ways: by the smallest eigenvalue of cells half a wavelength wide, "
            "and by the bands that grow from 0.1 % of noise in the toughness, mean of two seeds. "
            "Bands are not cracks yet: these follow later, out of most of them. The theory gives a "
            "range for all dT/dT_c from 3 on; the reference is its middle, and the tolerance 15 % "
            "of that. The layer of the same dT/dT_c, wave by wave, is another reference. "
            "Tolerances are fractions of the reference."
        ),
        measure=onset,
    ),
}
