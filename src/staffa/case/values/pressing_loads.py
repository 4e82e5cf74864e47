"""The loads of a case that may press some part of its rock, each by its key.

What only cools cannot: with one initial temperature, sides and fluids that are never hotter than
that and never warm up, films that stay as they are, and no source, the temperature falls
everywhere and at all times (the comparison principle of the heat equation, also for its derivative
in time). Rock of one expansion
is then pulled where it is colder than the rest. The rest may balance that by pressure; how much is
not known beforehand, so that each step without a split is held against a safe one
(`evolution.pressed_growth`).
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from staffa.case.schema.case import Case, Prescribed
from staffa.case.schema.cooling_keys import FORMULA
from staffa.case.schema.field_types import Formula
from staffa.case.schema.force_keys import ForceKeys
from staffa.case.schema.heat_keys import HeatCracks, HeatKeys, HeatSide, InTime
from staffa.case.schema.support_keys import DisplacementFile, DisplacementHistory
from staffa.case.schema.temperature_keys import depends_on_place
from staffa.case.values.diffusion_time import times_in
from staffa.case.values.heat_equation import film, start, temperature
from staffa.case.values.property_functions import varies
from staffa.case.values.subdomains import averages, subdomains_of
from staffa.heat.thermal_body import OfSurface

# Times at which a formula is looked at: evenly, and as many that crowd at the start.
SAMPLES = 100
# Part of a quantity: "20 °C" and a formula's 293.15 may differ in a digit.
ROUND_OFF = 1e-9
WARMS = "warming up again"
WATER = "the pressure of the water (reservoir)"


def pressing(case: Case) -> tuple[str, ...]:
    """Name the loads that may press rock, each with the reason; empty if only cooling acts."""
    found = [*_forces(case), *_moved(case)]
    if case.reservoir is not None:
        found.append(WATER)
    if case.temperature.profile != "none":
        found += _mismatch(case)
    if case.temperature.profile == FORMULA:
        found.append("a formula of the temperature, which may warm (temperature.T)")
    if case.heat is not None:
        found += [*_start(case, case.heat), *_heated(case, case.heat)]
    return tuple(found)


def acting_forces(keys: ForceKeys | None) -> tuple[str, ...]:
    """Return the keys of [forces] that are given."""
    if keys is None:
        return ()
    own = ("prestress", "gravity", "pore_pressure", "crack_pressure", "crack_volume")
    return (*(name for name in own if getattr(keys, name) is not None), *keys.by_side())


def _forces(case: Case) -> Iterator[str]:
    if acting := acting_forces(case.forces):
        yield f"forces ({', '.join(acting)})"


def _moved(case: Case) -> Iterator[str]:
    """Yield supports that move: they may push."""
    sides = [side for side in case.outline.faces if _moves(case.supports.on(side))]
    if sides:
        yield f"supports that move ({', '.join(sides)})"


def _moves(support: Any) -> bool:
    if not isinstance(support, Prescribed):
        return False
    given = [c for c in (support.x, support.y, support.z) if c is not None]
    return any(_moves_by(component) for component in given)


def _moves_by(component: Any) -> bool:
    if isinstance(component, DisplacementHistory):
        return bool(np.any(component.u))
    return isinstance(component, DisplacementFile) or float(component) != 0


def only_pulled(case: Case) -> bool:
    """Return True if only supports act that move flat sides outwards, as in a tensile test."""
    if not case.domain.is_block or case.forces is not None or case.temperature.profile != "none":
        return False
    for side, plane in case.outline.faces.items():
        support = case.supports.on(side)
        if not _moves(support):
            continue
        assert isinstance(support, Prescribed) and plane is not None
        for axis, name in enumerate("xyz"):
            given = getattr(support, name)
            if isinstance(given, DisplacementFile):
                return False
            u = np.ravel(given.u if isinstance(given, DisplacementHistory) else given or 0.0)
            if np.any(plane.out * u < 0 if axis == plane.axis else u != 0):
                return False
    return True


def _mismatch(case: Case) -> Iterator[str]:
    """Yield rock that does not expand alike in all places and directions."""
    body, *regions = subdomains_of(case)
    expansions = [subdomain.keys.expansion for subdomain in (body, *regions)]
    uneven = [
        f"{subdomain.where}.expansion"
        for subdomain, expansion in zip((body, *regions), expansions, strict=True)
        if (varies(expansion) and depends_on_place(expansion))
        or (isinstance(expansion, tuple) and len(set(expansion)) > 1)
    ]
    if not uneven:
        alike = averages(body).expansion
        uneven = [
            f"{subdomain.where}.expansion"
            for subdomain in regions
            if not np.isclose(averages(subdomain).expansion, alike, rtol=ROUND_OFF, atol=0.0)
        ]
    if uneven:
        yield f"thermal mismatch ({', '.join(uneven)})"


def _start(case: Case, keys: HeatKeys) -> Iterator[str]:
    """Yield initial temperatures that even out, and rock that is strained by them."""
    x = case.outline.places.within().x
    initial = start(case, keys.initial)(x)
    slack = ROUND_OFF * np.abs(initial).max()
    if np.ptp(initial) > slack:
        yield "an uneven start (heat.initial)"
    if keys.stress_free is None:
        return
    hotter = initial - start(case, keys.stress_free)(x)
    if hotter.max() > slack:
        yield "a start above heat.stress_free"
    elif np.ptp(hotter) > slack:
        yield "an uneven heat.stress_free"


def _heated(case: Case, keys: HeatKeys) -> Iterator[str]:
    """Name what heats the rock, or lets go of cooling it."""
    named = {f"heat.{side}": (side, keys.on(side)) for side in case.outline.faces}
    surfaces: list[tuple[str, str | None, HeatSide | HeatCracks]] = [
        (where, side, given) for where, (side, given) in named.items() if given is not None
    ]
    hotter, warming = [], []
    if keys.cracks is not None:
        surfaces.append(("heat.cracks", None, keys.cracks))
    coldest = min((_coldest(case, side, given) for _, side, given in surfaces), default=np.inf)
    for where, side, given in surfaces:
        heats, warms = _of_surface(case, keys, side, given)
        warms = warms or _warms_later(case, side, given, coldest)
        hotter += [where] * heats
        warming += [where] * (warms and not heats)
    if keys.source is not None:
        made = _over_time(case, keys.source, case.outline.places.within().x)
        hotter += ["heat.source"] * bool(made.max() > 0)
        warming += ["heat.source"] * (_rises(made) and not made.max() > 0)
    if hotter:
        yield f"heating ({', '.join(hotter)})"
    if warming:
        yield f"{WARMS} ({', '.join(warming)})"


def _coldest(case: Case, side: str | None, given: HeatSide | HeatCracks) -> float:
    """Return the lowest temperature of a side, or of the fluid in the cracks, over the run (K)."""
    if given.T is None:
        return np.inf
    return float(_over_time(case, given.T, _places(case, side)).min())


def _warms_later(
    case: Case, side: str | None, given: HeatSide | HeatCracks, coldest: float
) -> bool:
    """Return whether a fluid may meet rock that something colder has cooled before.

    It may through a film that changes with time, or in cracks, which open later.
    """
    if given.T is None or given.h is None or isinstance(film(given.h, case.dim), OfSurface):
        return False
    x = _places(case, side)
    warmest = float(_over_time(case, given.T, x).max())
    changes = side is None or np.ptp(_over_time(case, given.h, x), axis=0).max() > 0
    return bool(changes) and warmest > coldest + ROUND_OFF * abs(warmest)


def _places(case: Case, side: str | None) -> np.ndarray:
    places = case.outline.places
    return places.within().x if side is None else places.on(side)


def _of_surface(
    case: Case, keys: HeatKeys, side: str | None, given: HeatSide | HeatCracks
) -> tuple[bool, bool]:
    """Return whether a side or the fluid in cracks heats the rock, or cools it less with time."""
    x = _places(case, side)
    flux = getattr(given, "flux", None)
    if flux is not None:
        entering = _over_time(case, flux, x)
        return bool(entering.max() > 0), _rises(entering)
    if given.T is None:
        return False, False
    T = _over_time(case, given.T, x)
    slack = ROUND_OFF * np.abs(T).max()
    hotter = bool((T - start(case, keys.initial)(x)).max() > slack)
    weaker = given.h is not None and _weakens(case, given.h, x)
    return hotter, _rises(T) or weaker


def _weakens(case: Case, value: Any, x: np.ndarray) -> bool:
    """Return whether a film coefficient falls with time.

    One that depends on the surface's temperature does not fall by itself.
    """
    return not isinstance(film(value, case.dim), OfSurface) and _rises(-_over_time(case, value, x))


def _rises(values: np.ndarray) -> bool:
    """Return True if values, shape (n_times, n_points), rise anywhere at some time."""
    return bool(np.diff(values, axis=0).max(initial=0.0) > ROUND_OFF * np.abs(values).max())


def _over_time(case: Case, value: Any, x: np.ndarray) -> np.ndarray:
    """Return a value of [heat] at points, shape (3, n), over the run; shape (n_times, n)."""
    function = temperature(case, value)
    return np.array([np.broadcast_to(function(x, t), x.shape[1:]) for t in _times(case, value)])


def _times(case: Case, value: Any) -> list[float]:
    """Return times at which a value is looked at (s)."""
    given = case.time.t if case.time.tau is None else case.time.tau
    stop = given[-1] if isinstance(given, tuple) else getattr(given, "stop", 0.0)
    last = times_in(case, np.array([stop], dtype=float))[0]
    if isinstance(value, Formula):
        shares = np.linspace(0.0, 1.0, SAMPLES)
        return sorted({last * float(share) for share in (*shares, *shares**4)})
    kinks = value.t if isinstance(value, InTime) else ()
    return sorted({0.0, last, *(float(t) for t in kinks if t < last)})
