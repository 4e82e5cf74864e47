"""Rules on the flow in cracks: an engine that can change it, and openings that water flows in."""

from staffa.case.schema.case import Case
from staffa.case.schema.fracture_keys import OpeningKeys
from staffa.case.schema.quantity_text import amount
from staffa.case.schema.toml_text import inline
from staffa.case.values.reservoir_places import fractured_sides, least_spread
from staffa.errors import InputError
from staffa.geometry.places import SAME
from staffa.reservoir.permeability import CELLS, WIDEST


def feedback_is_possible(case: Case) -> None:
    """Require an engine whose flow can change, openings that water can flow in, and a radius that
    keeps the flow of oblique cracks."""
    keys = case.reservoir
    if keys is None or not keys.feedback:
        return
    if keys.simulator != "darts":
        raise InputError(
            f'reservoir.feedback = true: with reservoir.simulator = "{keys.simulator}" the flow is '
            f'given, and cracks cannot change it; take "darts", or leave feedback out'
        )
    if keys.coupling == "iterated" and case.solver.backtracking:
        raise InputError(
            'solver.backtracking = true: with reservoir.coupling = "iterated" the temperature of '
            'an earlier step depends on the cracks that are tried there; take "explicit", or leave '
            "backtracking out"
        )
    _openings_are_possible(case, keys.openings)


def _openings_are_possible(case: Case, openings: OpeningKeys) -> None:
    smallest, largest = inline(openings.smallest), inline(openings.largest)
    if openings.smallest >= openings.largest:
        raise InputError(
            f"reservoir.openings.smallest = {smallest} must be less than largest = {largest}; "
            f"change one of them"
        )
    if openings.largest > WIDEST:
        raise InputError(
            f"reservoir.openings.largest = {largest}: the simulator finds no solution beside wider "
            f"ways, and from {amount(case, WIDEST, 'm')} on nothing changes any more; take that or "
            f"less"
        )
    least = least_spread(case)
    if openings.spread is not None and float(openings.spread) < least * (1 - SAME):
        raise InputError(
            f"reservoir.openings.spread = {inline(openings.spread)} must be at least "
            f"{amount(case, least, 'm')}, {CELLS} cells of the reservoir and 2 damage.ell: "
            f"narrower, an oblique crack loses its flow; take a larger spread, or a smaller "
            f"reservoir.h"
        )
    for side, fracture in fractured_sides(case).items():
        if not openings.smallest <= fracture.opening <= openings.largest:
            raise InputError(
                f"reservoir.fractures, side = {inline(side)}: opening = {inline(fracture.opening)} "
                f"is not between reservoir.openings.smallest = {smallest} and largest = {largest}, "
                f"within which it may change; change one of them"
            )
