"""Estimates of the coldest and hottest surface of a body with the heat equation, before a run.

Each surface is taken alone, as that of a half-space that conducts as the rock does across it.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from math import pi, sqrt
from typing import Any

import numpy as np

from staffa.case.rules.temperature_range import temperature_range
from staffa.case.rules.time_rules import times_given
from staffa.case.schema.case import Case
from staffa.case.schema.heat_keys import HeatCracks, HeatSide, InTime
from staffa.case.schema.property_keys import FieldFile
from staffa.case.schema.temperature_keys import InTemperature
from staffa.case.values.diffusion_time import conductivity_across, diffusivity, times_in
from staffa.case.values.given_files import in_body
from staffa.case.values.heat_equation import film, in_time
from staffa.case.values.property_functions import in_space
from staffa.heat.thermal_body import OfSurface
from staffa.loads.closed_form import Convective, Face

SAMPLES = 50  # times at which a formula is looked at
AT_ONCE = 0.99  # a drop of which so much is there from the start is a jump

ROUND_OFF = 1e-9  # part of a temperature: "20 °C" and a formula's 293.15 may differ in a digit


@dataclass(frozen=True, kw_only=True)
class SurfaceExchange:
    """Heat exchange of the rock with a side, or with a fluid in the cracks.

    Attributes
    ----------
    where : name of the side, or "cracks".
    drop : greatest cooling of the side or fluid below the initial rock (K).
    rise : greatest heating of the side or fluid above the initial rock (K).
    film : largest film coefficient h over the conductivity (1/m), None without a film.
    reached : drop of the rock's surface at the end (K).
    at_once : True if the surface has its drop from the start.
    """

    where: str
    drop: float
    rise: float
    film: float | None = None
    reached: float
    at_once: bool = False


def surface_exchanges(case: Case) -> tuple[SurfaceExchange, ...]:
    """Return the heat exchanges of a case with profile "heat", up to its last time.

    The fluid in the cracks is held against the rock in the middle of the cooled face.
    """
    keys, face = case.heat, case.temperature.face
    assert keys is not None
    last = times_in(case, times_given(case)[-1:])[0]
    named = {side: keys.on(side) for side in case.outline.faces}
    found = [_exchange(case, side, side, g, last) for side, g in named.items() if g is not None]
    if keys.cracks is not None and keys.cracks.h is not None:
        found.append(_exchange(case, "cracks", face, keys.cracks, last))
    return tuple(found)


def cooled_besides(case: Case) -> tuple[str, ...]:
    """Return the boundaries that are cooled besides the face from which depths are measured."""
    if case.heat is None or not case.temperature.has_face:
        return ()
    known = [e.where for e in surface_exchanges(case) if e.drop > 0]
    return tuple(e for e in known if e in case.outline.faces and e != case.temperature.face)


def face_cools(case: Case) -> bool:
    """Return False if other boundaries are cooled, and the face that depths are measured from is
    not."""
    if not cooled_besides(case):
        return True
    return any(e.drop > 0 for e in surface_exchanges(case) if e.where == case.temperature.face)


def strongest(found: Iterable[SurfaceExchange], face: str) -> SurfaceExchange | None:
    """Return the strongest cooling: at the face if that cools, else anywhere; None without one."""
    cooling = [e for e in found if e.drop > 0]
    at_face = [e for e in cooling if e.where == face]
    return max(at_face or cooling, key=lambda e: e.drop, default=None)


def _exchange(
    case: Case, where: str, side: str, given: HeatSide | HeatCracks, last: float
) -> SurfaceExchange:
    middle = _middle(case, side)
    if isinstance(given, HeatSide) and given.flux is not None:
        k = conductivity_across(case, side)
        flux = _history(case, given.flux, middle, last)
        shift = 2 * sqrt(diffusivity(case, side) * last / pi) / k
        drop, rise = _shares(-flux * shift)
        return SurfaceExchange(where=where, drop=drop, rise=rise, reached=drop)
    assert case.heat is not None
    initial = case.heat.initial
    at_start = in_space(initial, case.dim)
    start = _mean(case, initial, side) if isinstance(initial, FieldFile) else at_start(middle)[0]
    if isinstance(given.T, FieldFile):
        below = np.array([float(start) - _mean(case, given.T, side)])
    else:
        below = float(start) - _history(case, given.T, middle, last)
    below[np.abs(below) < ROUND_OFF * abs(start)] = 0.0
    drop, rise = _shares(below)
    if given.h is None:
        at_once = bool(drop > 0 and below[0] >= AT_ONCE * drop)
        return SurfaceExchange(where=where, drop=drop, rise=rise, reached=drop, at_once=at_once)
    k = conductivity_across(case, side)
    film = _largest_film(case, given.h, middle, last) / k
    return SurfaceExchange(
        where=where,
        drop=drop,
        rise=rise,
        film=film,
        reached=_behind_film(drop, film, diffusivity(case, side), last),
    )


def _mean(case: Case, value: FieldFile, side: str) -> float:
    """Return the mean over a side of a field in a file."""
    return float(np.mean(in_body(case, value)(case.outline.places.on(side))))


def _largest_film(case: Case, value: Any, x: np.ndarray, last: float) -> float:
    """Return the largest film coefficient over the run.

    One that depends on the surface's temperature counts over the temperatures that the case names.
    """
    law = film(value, case.dim)
    if not isinstance(law, OfSurface):
        return float(np.max(_history(case, value, x, last)))
    T = np.linspace(*temperature_range(case), SAMPLES)
    if isinstance(value, InTemperature):
        T = np.union1d(T, np.clip(np.array(value.T, dtype=float), T[0], T[-1]))
    there = np.repeat(x, len(T), axis=1)
    times = np.linspace(0.0, last, SAMPLES).tolist()
    return max(float(np.max(law.at(there, t, T))) for t in times)


def _shares(below: np.ndarray) -> tuple[float, float]:
    """Return largest drop and largest rise (K), each at least 0."""
    return max(0.0, float(below.max())), max(0.0, float(-below.min()))


def _behind_film(drop: float, film: float, kappa: float, t: float) -> float:
    surface = Face(axis=0, position=0.0, inward=1)
    known = Convective(dT=drop, kappa=kappa, face=surface, h=film)
    return float(-known.temperature(np.zeros((3, 1)), t)[0])


def _history(case: Case, value: Any, x: np.ndarray, last: float) -> np.ndarray:
    """Return a value at one point over the run, from t = 0 on."""
    times = {float(t) for t in np.linspace(0.0, last, SAMPLES)}
    if isinstance(value, InTime):
        times |= {float(t) for t in value.t if t <= last}
    function = in_time(value, case.dim)
    return np.array([float(np.ravel(function(x, t))[0]) for t in sorted(times)])


def _middle(case: Case, side: str) -> np.ndarray:
    """Return the middle of a side, shape (3, 1); that of the body if the side is not flat."""
    body, x = case.outline, np.zeros((3, 1))
    x[: case.dim, 0] = (np.array(body.lower) + np.array(body.upper)) / 2
    plane = body.faces[side]
    if plane:
        x[plane.axis] = plane.position
    return x
