"""The verdict on whether cooling cracks a body, and what else may break it."""

from collections.abc import Iterator
from math import sqrt

import numpy as np

from staffa.case.rules import is_moved
from staffa.case.scales.case_scales import Numbers, load
from staffa.case.scales.squeeze import Squeeze, squeeze
from staffa.case.scales.surface_cooling import strongest, surface_exchanges
from staffa.case.schema.case import Case
from staffa.case.values.applied_forces import forces
from staffa.case.values.default_split import presses
from staffa.case.values.heat_equation import start
from staffa.case.values.subdomains import is_uneven
from staffa.units import Quantity

# Of places a correlation length apart, one in 700 is further below the mean of a random field.
RARE = 3.0
# A drop that exceeds the one that starts damage by this factor cracks the face beyond doubt.
WELL_ABOVE = 1.5


def first_and_last(derived: Numbers) -> tuple[float, float]:
    """Return the first time after zero, and the last."""
    times = [t for t in (*derived.times, *derived.requested) if t > 0] or [0.0]
    return min(times), max(times)


def peak_drop(case: Case, derived: Numbers) -> float:
    """Return the largest drop of the cooled face by the end of the run (K)."""
    if case.heat is not None:
        coldest = strongest(surface_exchanges(case), case.temperature.face)
        return coldest.reached if coldest else 0.0
    if case.reservoir is not None:
        return derived.dT
    assert derived.face is not None
    on_face = np.zeros((3, 1))
    on_face[derived.face.axis] = derived.face.position
    _, last = first_and_last(derived)
    return float(-load(case, derived).temperature(on_face, last)[0])


def rare_factor(case: Case) -> float:
    """Return the toughness over its mean at the weak places of a lognormal field, 1 without one."""
    variance = np.log1p(case.toughness.amplitude**2)
    return float(np.exp(-RARE * np.sqrt(variance) - variance / 2)) if variance else 1.0


def face_squeeze(case: Case, derived: Numbers) -> Squeeze | None:
    """Return the squeeze of the cooled face, where even rock tells it; None without forces too."""
    return squeeze(case, derived, peak_drop(case, derived)) if case.forces else None


def other_causes(case: Case, *, forces: bool = True) -> tuple[str, ...]:
    """Name the causes that may break the body besides nucleation by cooling.

    Parameters
    ----------
    case : the case.
    forces : True if [forces] count: they do where `face_squeeze` does not tell their effect.
    """
    given = ("the given cracks may grow",) if case.cracks else ()
    moved = ("the moved sides load it too",) if is_moved(case) else ()
    acting = forced(case) if forces else _fluid(case)
    water = ("the pressure of the water acts too",) if presses_by_water(case) else ()
    return (*given, *moved, *acting, *water, *_causes_of_heat(case))


def presses_by_water(case: Case) -> bool:
    """Return True if a reservoir presses on pores and cracks."""
    return forces(case).fluid


def forced(case: Case) -> tuple[str, ...]:
    """Say that [forces] act, if they do."""
    return (f"[forces] act too ({presses(case)})",) if case.forces else ()


def _fluid(case: Case) -> tuple[str, ...]:
    names = ("crack_pressure", "crack_volume")
    pressing = case.forces is not None and any(getattr(case.forces, name) for name in names)
    return ("the fluid in the cracks drives them too",) if pressing else ()


def _causes_of_heat(case: Case) -> Iterator[str]:
    """Name the effects of the heat equation besides cooling the face."""
    if case.heat is None:
        return
    found = surface_exchanges(case)
    coldest = strongest(found, case.temperature.face)
    if case.heat.source is not None or any(e.rise > 0 for e in found):
        yield "heated parts may pull others apart"
    if any(e.drop > 0 and e is not coldest for e in found):
        yield "other places are cooled too"
    if is_strained_at_start(case):
        yield "the body is strained from the start"
    if not isinstance(case.heat.initial, Quantity):
        yield "the initial temperature may even out"


def is_strained_at_start(case: Case) -> bool:
    """Return True if the initial temperature is not the one free of stress."""
    keys = case.heat
    if keys is None or keys.stress_free is None:
        return False
    x = case.outline.places.within().x
    return not np.allclose(start(case, keys.stress_free)(x), start(case, keys.initial)(x))


def verdict(case: Case, derived: Numbers) -> tuple[str, str]:
    """Judge if cooling starts cracks, and why; other causes are named beside it."""
    if derived.dT_c is None:
        return "cannot be told", "without a threshold only a run can tell"
    squeezed = face_squeeze(case, derived)
    causes = other_causes(case, forces=squeezed is None)
    if case.forces is not None and squeezed is None:
        said = "cannot be told", "from dT_c alone"
    elif squeezed is not None:
        said = _of_ratio(case, squeezed.share, causes, "net tension", squeezed.needs(case))
    else:
        ratio = peak_drop(case, derived) / derived.dT_c
        said = _of_ratio(case, ratio, causes, "drop", "")
    return said[0], "; ".join([said[1], *causes])


def _of_ratio(
    case: Case, ratio: float, causes: tuple[str, ...], what: str, needs: str
) -> tuple[str, str]:
    """Return the verdict from the ratio of this drop or stress to the start of damage."""
    bound = "dT_c" if what == "drop" else "what starts damage"
    if ratio >= WELL_ABOVE:
        return "yes", f"the {what} is well above {bound}"
    if ratio >= 1:
        return "hardly", f"damage starts, but the {what} is little above {bound}"
    if ratio > sqrt(rare_factor(case)):
        why = "the face cools enough only where the random toughness is low"
        return "perhaps", f"{why}{needs}"
    if is_uneven(case):
        why = "the averages of the rock stand it, but it differs from them"
        return "perhaps", f"{why}{needs}"
    if causes:
        why = "by cooling: the face never cools enough to damage sound rock"
        return "no new crack", f"{why}{needs}"
    return "no", f"the face never cools enough to damage the rock{needs}"
