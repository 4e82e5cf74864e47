"""Facts on a reservoir before a run: who computes it, its scales, and what it costs."""

from collections.abc import Iterator

import numpy as np

from staffa.case.check.cost import Steps
from staffa.case.scales.breakthrough import DRAWDOWNS, breakthrough, doublet, water_heat
from staffa.case.scales.case_scales import Numbers
from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import amount, as_duration
from staffa.case.values.diffusion_time import diffusivity, heat_capacity
from staffa.case.values.reservoir_model import reservoir_grid
from staffa.case.values.reservoir_places import (
    bounds,
    crack_rule,
    fractured_sides,
    reservoir_keys,
    side_fractures,
)
from staffa.errors import InputError
from staffa.geometry.block import face_axis
from staffa.physics.material import PLANE_STRESS
from staffa.reservoir.interpreter import simulator_python

Fact = tuple[str, str, str]
# Measured with open-DARTS 2.0.0 and IAPWS water at 3,120 and 31,416 cells, on one of two busy
# cores: memory of its process (bytes, and bytes a cell), its start (s), a step of the run, which
# takes about 14 inner ones, at SMALL cells (s), and the power by which that grows.
MEMORY, MEMORY_A_CELL = 2.6e8, 5.5e3
START, STEP, SMALL, POWER = 3.0, 1.4, 3120, 1.3
PASSES = 2.0  # of temperature and cracks in a step
EARLY = 6.0  # steps that the many small inner steps of the first one are worth


def circulation_facts(case: Case, derived: Numbers) -> Iterator[Fact]:
    """Yield the facts on a reservoir, its cost left aside."""
    keys = reservoir_keys(case)
    yield from _simulator(case)
    yield from _cracks(case)
    free = "" if derived.state == PLANE_STRESS else "/(1 - nu)"
    blocked = 1.0 if derived.state == PLANE_STRESS else 1 - derived.rock.nu
    stress = derived.rock.E * derived.rock.expansion * derived.dT / blocked
    yield (
        "thermal stress",
        amount(case, stress, "Pa"),
        f"E expansion dT{free}: {stress / derived.sigma_c:.3g} sigma_c, where rock is as cold as "
        f"the water",
    )
    if keys.simulator != "fields":
        yield from _scales(case, derived)


def _simulator(case: Case) -> Iterator[Fact]:
    keys = reservoir_keys(case)
    if keys.simulator == "fields":
        assert keys.fields is not None
        with_p = "temperature and pressure" if keys.fields.p else "temperature"
        yield "reservoir", f"{len(keys.fields.t)} files", f"{with_p}, linear in time between them"
        return
    grid = reservoir_grid(case)
    x, y, z = grid.shape
    each = f"{x} x {y}" if case.dim == 2 else f"{x} x {y} x {z}"
    low, high = (" ".join(f"{c:.4g}" for c in corner) for corner in bounds(case))
    yield "reservoir", f"{grid.size:,} cells", f"{each}, from ({low}) m to ({high}) m"
    if keys.simulator == "single":
        yield "simulator", "single", "one fracture in closed form; needs no other program"
    else:
        yield "simulator", *_found(case)


def _cracks(case: Case) -> Iterator[Fact]:
    rule = crack_rule(case)
    if rule is None:
        yield "flow in cracks", "none", "cracks do not change the flow (reservoir.feedback)"
        return
    small, large, spread = (
        amount(case, x, "m") for x in (rule.smallest, rule.largest, rule.spread)
    )
    yield (
        "flow in cracks",
        f"{small} to {large}",
        f"openings; spread over {spread}: cracks nearer than {amount(case, 4 * rule.spread, 'm')} "
        f"share their water",
    )


def _found(case: Case) -> tuple[str, str]:
    try:
        python = simulator_python(reservoir_keys(case).interpreter)
    except InputError:
        return "not found", "open-DARTS; `make reservoir` installs it"
    return "found", f"open-DARTS, by {python}; `staffa doctor` tries it"


def not_found(case: Case) -> str | None:
    """Return the sentence on a simulator that is needed and not there, None if it is."""
    keys = case.reservoir
    if keys is None or keys.simulator != "darts":
        return None
    try:
        simulator_python(keys.interpreter)
    except InputError as error:
        return str(error)
    return None


def _scales(case: Case, derived: Numbers) -> Iterator[Fact]:
    """Yield Peclet and Fourier numbers, and thermal breakthrough where a closed form tells it."""
    wells = doublet(case)
    k = diffusivity(case) * heat_capacity(case)
    if wells is not None:
        _, c = water_heat(case)
        heights = [fracture.height / 2 for fracture in side_fractures(case)]
        width = min(heights, default=wells.distance)
        across = width if case.dim == 2 else width * wells.distance
        peclet = c * wells.rate * wells.distance / (k * across)
        where = "along the fracture" if heights else "between the wells"
        yield "Peclet number", f"{peclet:.3g}", f"heat by water over heat by conduction, {where}"
    length, what = _reach(case, derived)
    fourier = diffusivity(case) * derived.times[-1] / length**2
    yield (
        "Fourier number",
        f"{fourier:.2g}",
        f"kappa t/D^2 at the end, D = {amount(case, length, 'm')} {what}; above about 0.1 the end "
        f"of the reservoir is felt",
    )
    told = breakthrough(case)
    if told is not None:
        times = " and ".join(amount(case, t, "s") for t in told[0])
        shares = " and ".join(f"{share:g}" for share in DRAWDOWNS)
        yield "thermal breakthrough", times, f"drawdown of {shares}: {told[1]}"


def _reach(case: Case, derived: Numbers) -> tuple[float, str]:
    """Return the extent of rock (m) that conducts to the water, and its name in words."""
    lower, upper = bounds(case)
    sides = fractured_sides(case)
    if len(sides) == 2 and len({face_axis(side, case.dim) for side in sides}) == 1:
        axis = face_axis(next(iter(sides)), case.dim)
        return float(upper[axis] - lower[axis]) / 2, "from a fracture to the middle"
    if sides:
        axis = face_axis(next(iter(sides)), case.dim)
        return float(upper[axis] - lower[axis]), "from the fracture to the end"
    return float(np.min(upper - lower)), "across the reservoir"


def _answers(case: Case) -> float:
    """Return the number of times that a step of the run is computed by the simulator."""
    keys = reservoir_keys(case)
    if not keys.feedback:
        return 1.0
    return (PASSES + 1.0 if keys.coupling == "iterated" else 1.0) + keys.shadow


def reservoir_cost(case: Case, planned: Steps) -> list[Fact]:
    """Return memory and time of the simulator; nothing of one without a process."""
    if case.reservoir is None or case.reservoir.simulator != "darts":
        return []
    cells = reservoir_grid(case).size
    seconds = START + (planned.number + EARLY) * STEP * (cells / SMALL) ** POWER * _answers(case)
    memory = MEMORY + MEMORY_A_CELL * cells
    return [
        ("memory of the simulator", f"about {memory / 1e9:.2g} GB", "its own process"),
        (
            "time of the simulator",
            f"about {as_duration(seconds)}",
            "within a factor of 3, and more where steps are rejected; in `time` it is left out",
        ),
    ]
