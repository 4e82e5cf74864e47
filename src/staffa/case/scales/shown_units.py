"""Units in which a case's results are shown; no finite elements."""

from collections.abc import Iterable, Iterator
from math import pi

import numpy as np

from staffa.case.scales.case_scales import Numbers
from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import is_scaled, quantities
from staffa.case.values.diffusion_time import heat_capacity
from staffa.case.values.temperature_formula import change_range
from staffa.display_units import Magnitudes, Unit, choose_display_units
from staffa.units import Quantity, Temperature, unit_of

# Keys of [domain] that tell how finely the body is cut, not how large it is.
FINE = ("domain.h", "domain.allow_coarse")
# The part of a body that is cooled when it cracks, as an order of magnitude.
STRAINED = 0.1


def units(case: Case, derived: Numbers) -> dict[str, Unit]:
    """Return units of the case by the names of `Shown`, as it writes them; none if it is scaled."""
    if is_scaled(case):
        return {}
    return vars(
        choose_display_units(case.extents, _magnitudes(case, derived), dict(_written(case)))
    )


def reference(case: Case) -> float | None:
    """Return the temperature (K) from which the field T counts changes.

    None if it is not one number, or the case knows changes alone.
    """
    if case.reservoir is not None:
        initial = case.reservoir.temperature
        return float(initial) if isinstance(initial, Temperature) else None
    if case.heat is None:
        return None
    start = case.heat.initial if case.heat.stress_free is None else case.heat.stress_free
    return float(start) if isinstance(start, Temperature) else None


def _written(case: Case) -> Iterator[tuple[str, Unit]]:
    """Yield the unit of each quantity for which the case writes one alone.

    Of lengths those of the body count, of stresses and volumes those of [forces], of times [time].
    """
    found = [(key, quantity) for key, quantity in quantities(case) if quantity.has_units]
    body = [q for key, q in found if key.startswith("domain.") and key not in FINE]
    forces = [q for key, q in found if key.startswith("forces.")]
    volume = "volume" if case.extents == 3 else "volume per thickness"
    for name, dimension, among in (
        ("length", "length", body),
        ("time", "time", (q for key, q in found if key.startswith("time."))),
        ("stress", "stress", forces),
        ("volume", volume, forces),
        ("temperature", "temperature", (q for _, q in found if isinstance(q, Temperature))),
    ):
        unit = _only(among, dimension)
        if unit is not None:
            yield name, unit


def _only(among: Iterable[Quantity], dimension: str) -> Unit | None:
    units = {unit for unit in (unit_of(q, dimension) for q in among) if unit is not None}
    return units.pop() if len(units) == 1 else None


def _swing(case: Case) -> float:
    """Return the largest difference (K) of temperatures that the case names, 0 without any.

    Tables by temperature are left out.
    """
    known = [
        float(q)
        for key, q in quantities(case)
        if isinstance(q, Temperature) and not key.startswith(("material.", "regions."))
    ]
    return max(known) - min(known) if known else 0.0


def _magnitudes(case: Case, derived: Numbers) -> Magnitudes:
    """Return estimates from the rock's averages and the strongest stress known at the start."""
    rock, size, L = derived.rock, case.outline.size, derived.L
    volume = 1.0
    for length in size:
        volume *= length
    if case.axial:
        volume *= pi * (case.outline.lower[0] + case.outline.upper[0])
    change = max(derived.dT, _swing(case))
    if case.temperature.T is not None:
        change = float(np.ptp(change_range(case, derived.times[-1])))
    cold = rock.E * rock.expansion * change
    stored = STRAINED * max(cold, derived.sigma_c) ** 2 / (2 * rock.E) * volume
    warmth = heat_capacity(case) * change * volume if case.conducts else 1.0
    return Magnitudes(
        extent=max(size),
        depth=L,
        last=derived.times[-1],
        energy=max(stored, rock.Gc * L ** (case.extents - 1)),
        heat=STRAINED * warmth or 1.0,
        force=max(cold, derived.sigma_c) * L ** (case.extents - 1),
        stress=derived.sigma_c,
    )
