"""Facts, warnings and notes on a front of temperature that a formula moves through the body."""

from collections.abc import Iterator
from itertools import pairwise

from staffa.case.check.cracking import first_and_last
from staffa.case.check.mesh_warnings import cell_edge
from staffa.case.rules import adaptive
from staffa.case.scales.case_scales import Numbers
from staffa.case.scales.moving_front import MovingFront, moving_front
from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import amount
from staffa.physics import scales

# A front over fewer cells than these loads cracks by the mesh.
LEAST_CELLS = 3
# Cracks that follow a front in longer leaps than this, in ell, may take another path.
LEAP = 2.0


def front_facts(case: Case, derived: Numbers) -> list[tuple[str, str, str]]:
    """Return facts on a moving front, none without one: each a name, a value and a meaning."""
    front, last = _front(case, derived)
    if front is None:
        return []
    rock, size = vars(derived.rock), front.width
    ell0 = scales.ell0(**rock, dT=front.span, state=derived.state)
    unit_time = size / abs(front.speed)
    way, backward = "xyz"[front.axis], "towards lower " if front.speed < 0 else "along "
    speed = amount(case, abs(front.speed), "m/s")
    return [
        ("front", f"{speed} {backward}{way}", "V, of the isotherm of half the change"),
        ("length of the front", amount(case, front.length, "m"), "change over its steepest slope"),
        (
            "Peclet number",
            f"{size / front.length:.3g}",
            "width over this length: W V/kappa if the front is a steady one",
        ),
        ("ell0", amount(case, ell0, "m"), "Gc over thermal stress squared, dT the whole change"),
        (
            "W/ell0",
            f"{size / ell0:.4g}",
            f"the load; W = {amount(case, size, 'm')} across the front",
        ),
        ("W/V", amount(case, unit_time, "s"), f"the run lasts {last / unit_time:.3g} of it"),
    ]


def front_warnings(case: Case, derived: Numbers) -> Iterator[str]:
    """Yield a warning on a front that the mesh does not resolve."""
    front, _ = _front(case, derived)
    if front is None or front.length >= LEAST_CELLS * cell_edge(case):
        return
    yield (
        f"the mesh does not resolve the front of temperature.T: it is "
        f"{amount(case, front.length, 'm')} long, {front.length / cell_edge(case):.2g} h; make it "
        f"{LEAST_CELLS} h or longer, or the cells smaller"
    )


def front_notes(case: Case, derived: Numbers) -> Iterator[str]:
    """Yield a note on steps in which the front moves far."""
    front, _ = _front(case, derived)
    times = sorted({*derived.times, *derived.requested})
    if front is None or len(times) < 2 or adaptive(case) is not None:
        return
    ell, speed = float(case.damage.ell), abs(front.speed)
    leap = speed * max(b - a for a, b in pairwise(times)) / ell
    if leap > LEAP:
        yield (
            f"the front moves {leap:.3g} ell in a step, and cracks follow in leaps as long, which "
            f"may change their paths: steps of {amount(case, ell / speed, 's')} move it by ell"
        )


def _front(case: Case, derived: Numbers) -> tuple[MovingFront | None, float]:
    """Return the front and the end of the run (s)."""
    last = first_and_last(derived)[1]
    return moving_front(case, last), last
