"""Warnings and notes on a reservoir: its wells, its cells, and what they do not resolve."""

from collections.abc import Iterator

import numpy as np

from staffa.case.check.circulation_facts import not_found
from staffa.case.check.cooling_warnings import of_plane_strain
from staffa.case.check.cracking import first_and_last
from staffa.case.check.water_pressure import pressure_warnings
from staffa.case.scales.case_scales import Numbers
from staffa.case.scales.reservoir_drop import coldest_water
from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import amount, at_least, at_most
from staffa.case.schema.toml_text import as_toml, inline
from staffa.case.values.property_functions import in_space
from staffa.case.values.reservoir_places import (
    BAND,
    beyond,
    bounds,
    cell_size,
    crack_rule,
    differing,
    fractured_sides,
    reservoir_keys,
)
from staffa.geometry.block import SIDES
from staffa.physics.scales import diffusion_length

THIN = 4.0  # cells at the wall of a fracture in sqrt(kappa t), which see the cold rock
BETWEEN = 10  # cells between two wells, at least
EVEN = 0.01  # of the largest rate, by which rates may differ
WIDE = 0.25  # of the smallest extent of the body, beyond which cracks are spread too far
FELT = 0.5  # diffusion lengths over an extent, from which its end is felt


def reservoir_warnings(case: Case, derived: Numbers) -> Iterator[str]:
    """Yield all warnings about the reservoir."""
    if case.reservoir is None:
        return
    missing = not_found(case)
    if missing is not None:
        yield (
            f'reservoir.simulator = "darts": {missing.rstrip(".")}; or take "single", or "fields" '
            f"with the files of another simulator"
        )
    if case.reservoir.simulator == "fields":
        if derived.dT <= 0:
            yield "reservoir.fields: the body gets nowhere colder in these files; is that meant?"
        return
    yield from _of_feedback(case)
    yield from of_plane_strain(case, derived, derived.dT, None)
    if derived.dT_c is not None and 0 < derived.dT < derived.dT_c:
        yield (
            f"hardly anything will crack: the water is colder than the rock by "
            f"{amount(case, derived.dT, 'K')}, and damage starts at a drop of "
            f"{amount(case, derived.dT_c, 'K')}; inject colder water, or take a larger damage.ell "
            f"(a lower strength)"
        )
    yield from _of_injection(case)
    yield from _of_pressures(case)
    yield from _of_rates(case)
    yield from pressure_warnings(case, derived)
    yield from _of_distance(case)
    yield from _of_cells(case, derived)
    yield from _of_ends(case, derived)


def _of_feedback(case: Case) -> Iterator[str]:
    """Warn of keys without effect, and of a flow that cannot follow the cracks well."""
    keys = reservoir_keys(case)
    if not keys.feedback:
        for name in differing(keys):
            yield (
                f"reservoir.{name} = {as_toml(getattr(keys, name), 40)} does not count, since "
                f"cracks do not change the flow; give reservoir.feedback = true, or leave it out"
            )
        return
    if keys.agreement is not None and keys.agreement < keys.tolerance:
        yield (
            f"reservoir.agreement = {keys.agreement:g} is less than reservoir.tolerance = "
            f"{keys.tolerance:g}, the error of one answer of the simulator: more passes that show "
            f"nothing; take agreement >= {keys.tolerance:g}, or a smaller tolerance"
        )
    rule, extent = crack_rule(case), min(case.outline.size)
    if rule is not None and rule.spread > WIDE * extent:
        yield (
            f"reservoir.openings.spread: cracks are spread over {amount(case, rule.spread, 'm')}, "
            f"in a body of {amount(case, extent, 'm')}: the cells hardly tell one "
            f"crack from the next; take a smaller spread, reservoir.h or damage.ell"
        )


def _of_injection(case: Case) -> Iterator[str]:
    """Warn of injected water that is not colder than all of the rock."""
    x = case.outline.places.on()
    coldest = float(np.min(in_space(reservoir_keys(case).temperature, case.dim)(x)))
    for number, well in enumerate(reservoir_keys(case).wells, start=1):
        if well.T is not None and float(well.T) > coldest:
            rock = f"{coldest - 273.15:.4g} °C"
            heats = "heats" if coldest_water(case) >= coldest else "heats some of"
            yield (
                f"reservoir.wells, entry {number} ('{well.name}'), T = {inline(well.T)}: this "
                f"water {heats} the rock, the coldest of which has {rock}; is that meant?"
            )


def _of_pressures(case: Case) -> Iterator[str]:
    """Warn of a well whose pressure drives water the other way than it is meant to go."""
    keys = reservoir_keys(case)
    for number, well in enumerate(keys.wells, start=1):
        if well.pressure is None:
            continue
        place = np.zeros((3, 1))
        place[: case.dim, 0] = well.at
        rock = float(in_space(keys.pressure, case.dim)(place)[0])
        if well.injects == (float(well.pressure) < rock) and float(well.pressure) != rock:
            takes = "takes water out" if well.injects else "lets water in"
            kind = "an injector" if well.injects else "a producer"
            yield (
                f"reservoir.wells, entry {number} ('{well.name}'), pressure = "
                f"{inline(well.pressure)}: {kind} that {takes} at first, since the rock has "
                f"{amount(case, rock, 'Pa')} there; is that meant?"
            )


def _of_rates(case: Case) -> Iterator[str]:
    """Warn of given rates that bring more water in than out, or less."""
    rates = [well.rate for well in reservoir_keys(case).wells]
    known = [float(rate) for rate in rates if rate is not None]
    more = sum(known)
    if len(known) == len(rates) and abs(more) > EVEN * max(map(abs, known)):
        way, end = ("in", "rises") if more > 0 else ("out", "falls")
        yield (
            f"reservoir.wells: {amount(case, abs(more), 'kg/s')} more go {way} than the other way, "
            f"and the reservoir has no other end, so that its pressure {end} on and on; give the "
            f'producer a pressure in place of its rate, like pressure = "20 MPa"'
        )


def _of_distance(case: Case) -> Iterator[str]:
    """Warn of cells too large to tell the wells apart."""
    wells = reservoir_keys(case).wells
    pairs = [(a, b) for a in wells if a.injects for b in wells if not b.injects]
    apart = min(float(np.linalg.norm(np.subtract(a.at, b.at))) for a, b in pairs)
    if cell_size(case) * BETWEEN > apart:
        yield (
            f"reservoir.h: cells of {amount(case, cell_size(case), 'm')} are less than "
            f"{BETWEEN} between an injector and a producer, {amount(case, apart, 'm')} apart, and "
            f"the error of its temperature is in proportion to them; take h <= "
            f"{at_most(case, apart / BETWEEN, 'm', digits=2)}"
        )


def _of_cells(case: Case, derived: Numbers) -> Iterator[str]:
    """Warn of cells that do not resolve the cold rock, or the water in a fracture."""
    first, last = (diffusion_length(derived.kappa, t) for t in first_and_last(derived))
    for side, fracture in fractured_sides(case).items():
        if THIN * fracture.height / 2 > first:
            thinner = at_most(case, 2 * first / THIN, "m")
            yield (
                f"reservoir.fractures, side = {inline(side)}: its cells are "
                f"{amount(case, fracture.height, 'm')} high, and the cells of the wall begin with "
                f"half of that, beside sqrt(kappa t) = {amount(case, first, 'm')} at the first "
                f"step: they do not see the cold rock; take height <= {thinner}"
            )
    if not fractured_sides(case) and cell_size(case) > last:
        yield (
            f"reservoir.h: cells of {amount(case, cell_size(case), 'm')} are longer than "
            f"sqrt(kappa t) = {amount(case, last, 'm')} at the end: the border of the cold rock is "
            f"smeared over a few of them; take h <= {at_most(case, last, 'm', digits=2)} to see it"
        )


def _of_ends(case: Case, derived: Numbers) -> Iterator[str]:
    """Warn of an end of the reservoir that conduction from a fracture reaches."""
    _, last = first_and_last(derived)
    deep = diffusion_length(derived.kappa, last)
    lower, upper = bounds(case)
    sides = fractured_sides(case)
    if len(sides) != 1:
        return
    (side,) = sides
    axis, end = SIDES[case.dim][side]
    length = float(upper[axis] - lower[axis])
    if deep > FELT * length:
        other = next(n for n, s in SIDES[case.dim].items() if s == (axis, -end))
        more = 2 * deep - length + beyond(case).get((axis, -end), 0.0)
        yield (
            f"at the last step sqrt(kappa t) is {deep / length:.2g} of the "
            f"{amount(case, length, 'm')} of rock beside the fracture, whose end keeps its heat: "
            f"the water is as between parallel fractures; for deep rock take "
            f"reservoir.beyond.{other} >= {at_least(case, more, 'm', digits=2)}"
        )


def reservoir_notes(case: Case, derived: Numbers) -> Iterator[str]:
    """Yield notes on choices that may be intended."""
    keys = case.reservoir
    if keys is None or keys.simulator == "fields":
        return
    first, _ = first_and_last(derived)
    seen = (BAND * float(case.damage.ell)) ** 2 / derived.kappa
    if first < seen:
        yield (
            f"damage is about 4 ell = {amount(case, 2 * BAND * float(case.damage.ell), 'm')} wide "
            f"at a wall or a crack, and so is the band in which water meets broken rock: the "
            f"temperature of the producer is not resolved before sqrt(kappa t) is 2 ell, at t = "
            f"{at_least(case, seen, 's', digits=2)}"
        )
    if keys.simulator == "single" and (keys.permeability or keys.porosity):
        yield (
            'reservoir.simulator = "single": water flows in the fracture alone; permeability does '
            "not count"
        )
