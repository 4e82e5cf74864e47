"""Warnings about loads: those that move nothing, that end early, or that leave all to round-off."""

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
from pydantic import BaseModel

from staffa.case.check.cracking import is_strained_at_start, verdict
from staffa.case.check.support_warnings import laterally_held
from staffa.case.check.temperature_change import temperature_span
from staffa.case.rules import adaptive, is_moved
from staffa.case.rules.support_rules import as_table, is_held_at
from staffa.case.rules.time_rules import counts_in
from staffa.case.scales.case_scales import Numbers
from staffa.case.scales.knots import DEPART, departure, excursion
from staffa.case.scales.pace import prescribed_knots
from staffa.case.scales.prescribed import (
    FORMULA_OF_T,
    PrescribedCurve,
    curves,
    prescribed,
    table_columns,
    visited_times,
)
from staffa.case.schema.boxes import Box
from staffa.case.schema.case import Case
from staffa.case.schema.field_types import Formula
from staffa.case.schema.heat_keys import Even
from staffa.case.schema.material_keys import RegionKeys
from staffa.case.schema.property_keys import FieldFile
from staffa.case.schema.quantity_text import amount
from staffa.case.schema.shape_keys import Cylinder, Layers
from staffa.case.schema.toml_text import inline
from staffa.case.values.heat_equation import start
from staffa.case.values.subdomains import subdomain_varies, subdomains_of
from staffa.properties.formula import uses

PLACES = re.compile(r"\b[xyz]\b")


def load_warnings(case: Case, derived: Numbers) -> Iterator[str]:
    """Yield all warnings about loads."""
    yield from _of_held_faces(case)
    yield from _of_tables(case, derived)
    yield from _of_times(case)
    yield from _of_start(case, derived)
    if is_even(case, derived) and _breaks(case, derived):
        how = f"{case.temperature.face} is cooled evenly" if derived.cooled else "pulled evenly"
        if case.temperature.T is not None:
            how = "temperature.T changes along one axis alone"
        yield (
            f"the rock is uniform and {how}: which crack comes first, and where, is decided by "
            f"round-off, or by the random direction in which a run leaves a state that is no "
            f"minimum; give the rock a seed: toughness.amplitude = 0.05, with toughness.seed = 1"
        )


def _of_held_faces(case: Case) -> Iterator[str]:
    """Warn of loads on a face that is constrained against them."""
    for side, table in case.forces.by_side().items() if case.forces else ():
        axis, every = case.outline.axis(side), "xyz"[: case.dim]
        moved = {"pressure": every if axis is None else every[axis], "x": "x", "y": "y", "z": "z"}
        for key in table.model_fields_set:
            if set(moved[key]) <= is_held_at(case, side).keys():
                own = case.supports.on(side) not in (None, "free")
                holds = f"supports.{side}" if own else "supports.section"
                yield (
                    f"forces.{side}.{key} moves nothing: {holds} constrains the face against it; "
                    f"leave one of them out"
                )


def _of_tables(case: Case, derived: Numbers) -> Iterator[str]:
    """Warn of tables in time that end, while their value changes, before the run does."""
    stop = max((*derived.times, *derived.requested))
    for where, table in prescribed(case):
        if isinstance(table, Formula):
            continue
        times, values = table_columns(table)
        still = len(values) < 2 or values[-1] == values[-2]
        if still or float(times[-1]) >= stop * (1 - 1e-9):
            continue
        yield (
            f"{where}: the table ends at t = {inline(times[-1]).strip('"')}, and the run at t = "
            f"{amount(case, stop, 's')}: in between its value stays {inline(values[-1])}; if that "
            f"is meant, give this value at the end of the run too"
        )


def _of_times(case: Case) -> Iterator[str]:
    """Warn of values in time of which the steps see too little."""
    if adaptive(case) is not None:
        for where, told in prescribed_knots(case).items():
            if told.depart > DEPART:
                yield (
                    f"{where}: steps end at {len(told.times)} of its times, the most there may "
                    f"be, and between them it departs from a straight line by {told.depart:.2g} of "
                    f"its range; smooth it if this is noise"
                )
        return
    visited = np.union1d([0.0], visited_times(case))
    for curve in curves(case):
        if curve.where == FORMULA_OF_T:
            yield from _of_excursion(case, curve, visited)
            continue
        apart, time = departure(curve.t, curve.values, visited)
        if apart > DEPART:
            yield (
                f"{curve.where}: at t = {amount(case, time, 's')}, between the times that are "
                f"visited, it departs by {apart:.2g} of its range from a straight line, which no "
                f"step sees; give time.{counts_in(case)} this time too, or steps that adapt: these "
                f"end at such times"
            )


def _of_excursion(case: Case, curve: PrescribedCurve, visited: np.ndarray) -> Iterator[str]:
    """Warn of a temperature that goes further between two steps than at both."""
    apart, time = excursion(curve.t, curve.values, visited)
    if apart > DEPART:
        yield (
            f"{curve.where}: at t = {amount(case, time, 's')}, between the times that are visited, "
            f"it goes further than at both by {apart:.2g} of its range, which no step sees; give "
            f"time.t this time too, or steps that adapt: these end at such times"
        )


def _of_start(case: Case, derived: Numbers) -> Iterator[str]:
    """Warn of rock that was joined hot, and is strained beyond its strength before cooling."""
    keys = case.heat
    if keys is None or derived.dT_c is None or not is_strained_at_start(case):
        return
    x = case.outline.places.within().x
    drop = float((start(case, keys.stress_free)(x) - start(case, keys.initial)(x)).max())
    if drop > derived.dT_c and laterally_held(case):
        yield (
            f"heat.stress_free lies up to {amount(case, drop, 'K')} above heat.initial: before "
            f"anything cools the body, constrained along its face, it is strained as by such "
            f"a drop, and damage starts at {amount(case, derived.dT_c, 'K')}; it breaks through in "
            f"the first step; take a lower stress_free, or let it shorten"
        )


def is_even(case: Case, derived: Numbers) -> bool:
    """Return whether a case is uniform along its cooled face, or along the body if it is pulled.

    Then there is no crack, no randomness, and no property, load or shape that varies there.
    """
    shaped = case.domain.is_block or isinstance(case.domain.shape, Layers | Cylinder)
    if not shaped or case.cracks or case.toughness.amplitude:
        return False
    if case.reservoir is not None or (derived.cooled and derived.face is None):
        return False
    across = derived.face.axis if derived.face else None
    if case.temperature.T is not None:
        varied = [axis for axis in range(case.dim) if uses(case.temperature.T, "xyz"[axis])]
        if len(varied) != 1:
            return False
        across = varied[0]
    if isinstance(case.domain.shape, Layers) and across != case.dim - 1:
        return False
    if any(subdomain_varies(subdomain) for subdomain in subdomains_of(case)):
        return False
    named = [region for region in case.regions.values() if region.lower is not None]
    boxes: list[Box | RegionKeys] = [
        *case.toughness.bands,
        *named,
        *(case.heat.bands if case.heat else ()),
    ]
    return all(_spans(case, box, across) for box in boxes) and all(
        _is_even(value, across) for value in _values(case)
    )


def _spans(case: Case, box: Box | RegionKeys, across: int | None) -> bool:
    """Return True if a box covers the body along every axis but this one."""
    body = case.outline
    assert box.lower is not None and box.upper is not None
    ends = zip(body.lower, body.upper, box.lower, box.upper, strict=True)
    return all(
        low <= below and high >= above
        for axis, (below, above, low, high) in enumerate(ends)
        if axis != across
    )


def _values(case: Case) -> Iterator[Any]:
    """Yield formulas, values with a gradient and fields in files of the loads of a case."""
    loads = (case.supports, case.heat, case.forces)
    for section in loads:
        if section is not None:
            yield from _placed(section)


def _placed(section: BaseModel) -> Iterator[Formula | Even | FieldFile]:
    for name in (*type(section).model_fields, *(section.model_extra or {})):
        value = getattr(section, name)
        if isinstance(value, Formula | Even | FieldFile):
            yield value
        elif isinstance(value, BaseModel):
            yield from _placed(value)


def _is_even(value: Formula | Even | FieldFile, across: int | None) -> bool:
    """Return True if a value changes along this axis at most."""
    if isinstance(value, FieldFile):
        return False
    if isinstance(value, Even):
        return all(not g for axis, g in enumerate(value.gradient) if axis != across)
    allowed = "" if across is None else "xyz"[across]
    return not set(PLACES.findall(value.formula)) - set(allowed)


def _breaks(case: Case, derived: Numbers) -> bool:
    """Return True if cracks are expected, from cooling or as the body is pulled apart."""
    if derived.cooled:
        without_threshold = derived.dT_c is None and derived.dT > 0
        return without_threshold or verdict(case, derived)[0] in ("yes", "hardly")
    if case.temperature.T is not None:
        return derived.dT_c is None or temperature_span(case, derived) >= derived.dT_c
    return is_moved(case) and _pulled(case) >= derived.sigma_c / derived.rock.E


def _pulled(case: Case) -> float:
    """Return the largest strains along an axis by which two ends of the body are moved apart.

    The second is that of ends that are moved along this axis alone.
    """
    strains = [0.0]
    for axis, size in enumerate(case.outline.size):
        low, high = (_moved_along(case, axis, out) for out in (-1, 1))
        if low is not None and high is not None:
            times = np.union1d(low[0], high[0])
            apart = np.interp(times, *high) - np.interp(times, *low)
            strains.append(float(apart.max()) / size)
    return max(strains)


def _moved_along(case: Case, axis: int, out: int) -> tuple[np.ndarray, np.ndarray] | None:
    """Return times and displacements of the outward end of an axis.

    None if the end is not moved, or along other axes too.
    """
    faces = case.outline.faces
    ends = [name for name, p in faces.items() if p and (p.axis, p.out) == (axis, out)]
    if len(ends) != 1:
        return None
    components = is_held_at(case, ends[0])
    if list(components) != ["xyz"[axis]]:
        return None
    return as_table(components["xyz"[axis]])
