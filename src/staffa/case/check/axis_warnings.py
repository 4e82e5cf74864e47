"""Warnings about bodies of revolution, which cannot have the cracks that hoop tension opens."""

from collections.abc import Iterator

import numpy as np

from staffa.case.check.cracking import peak_drop
from staffa.case.rules.support_rules import as_table, is_held_at
from staffa.case.scales.case_scales import Numbers
from staffa.case.scales.surface_cooling import surface_exchanges
from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import amount
from staffa.case.values.applied_forces import forces
from staffa.case.values.diffusion_time import conductivities, heat_capacity
from staffa.case.values.heat_equation import in_time
from staffa.geometry.outline import FlatFace
from staffa.units import Quantity

SAMPLES = 25  # times at which a pressure is looked at


def axis_warnings(case: Case, derived: Numbers) -> Iterator[str]:
    """Yield a warning on all tension around the axis that breaks the rock by first estimates."""
    if not case.axial:
        return
    causes = [*_of_heat(case, derived), *_of_pressure(case, derived), *_of_moves(case, derived)]
    if causes:
        yield (
            f'domain.symmetry = "axis": {"; ".join(causes)}. Tension around the axis opens radial '
            f"cracks, in planes through it, and a body of revolution has only cracks that run "
            f"around it: its damage there is smeared over whole rings. For radial cracks take the "
            f"section across the axis, or a 3-D body; stress and temperature up to the first of "
            f"them are right"
        )


def _of_heat(case: Case, derived: Numbers) -> Iterator[str]:
    cools = derived.cooled and derived.dT > 0
    if cools and (derived.dT_c is None or peak_drop(case, derived) >= derived.dT_c):
        face = case.temperature.face
        yield f"the thermal stress at '{face}' is as large around the axis as along the section"
    if case.heat is None:
        return
    rise = max((exchange.rise for exchange in surface_exchanges(case)), default=0.0)
    rock = derived.rock
    # A cylinder that is warmer inside by a parabola is pulled at its wall by half of this.
    made = _made_within(case, derived) / (2 * (1 - rock.nu))
    if rock.E * rock.expansion * max(rise, made) >= derived.sigma_c:
        yield "what is heated pulls the rock around it apart"


def _made_within(case: Case, derived: Numbers) -> float:
    """Return an upper bound of the temperature of the body's middle above its wall, by a source
    (K)."""
    assert case.heat is not None
    if case.heat.source is None:
        return 0.0
    source, x = in_time(case.heat.source, case.dim), case.outline.places.within().x
    times = np.linspace(0.0, derived.times[-1], SAMPLES)
    strongest = max(float(np.max(source(x, t))) for t in times)
    steady = strongest * case.outline.upper[0] ** 2 / (4 * conductivities(case)[0])
    return min(steady, strongest * derived.times[-1] / heat_capacity(case))


def _of_pressure(case: Case, derived: Numbers) -> Iterator[str]:
    """Warn of the pressure in a hole, which pulls around it as Lame's solution has it."""
    inner, outer = _wall(case, -1), _wall(case, 1)
    if case.forces is None or inner is None or outer is None:
        return
    given = case.forces.prestress
    even = None if given is None else given.zz
    if not isinstance(even, Quantity | int | float | None):
        return
    rest, times = float(even or 0.0), np.linspace(0.0, derived.times[-1], SAMPLES)
    a2, b2 = inner[1].position ** 2, outer[1].position ** 2
    within = _pressure(case, inner[0], times) + rest
    around = np.zeros_like(times)
    if "x" not in is_held_at(case, outer[0]):
        around = _pressure(case, outer[0], times) + rest
    if "x" in is_held_at(case, inner[0]):
        return
    hoop = float((rest + (within * (a2 + b2) - 2 * around * b2) / (b2 - a2)).max())
    if hoop >= derived.sigma_c:
        yield (
            f"what presses on '{inner[0]}' pulls there around the axis by "
            f"{amount(case, hoop, 'Pa')}, and the rock breaks at "
            f"{amount(case, derived.sigma_c, 'Pa')}"
        )


def _wall(case: Case, out: int) -> tuple[str, FlatFace] | None:
    """Return the face around the axis that is the inner (-1) or outer (1) end of the body."""
    for name, plane in case.outline.faces.items():
        if plane is not None and (plane.axis, plane.out) == (0, out) and case.outline.sides[name]:
            return name, plane
    return None


def _pressure(case: Case, face: str, times: np.ndarray) -> np.ndarray:
    """Return the largest pressure on a face at each time (Pa), shape (n,)."""
    x = case.outline.places.on(face)
    found = np.zeros_like(times)
    for side in forces(case).sides:
        if side.side == face and side.pressure is not None:
            found += np.array([float(side.pressure(x, t).max()) for t in times])
    return found


def _of_moves(case: Case, derived: Numbers) -> Iterator[str]:
    for side in case.outline.faces:
        moved = is_held_at(case, side).get("x")
        if moved is None:
            continue
        r = float(case.outline.places.on(side)[0].min())
        furthest = float(as_table(moved)[1].max())
        if furthest > 0 and r > 0 and furthest / r >= derived.sigma_c / derived.rock.E:
            yield f"supports.{side}.x moves outward by {furthest / r:.3g} of the radius"
