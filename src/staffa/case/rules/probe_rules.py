"""Rules on probes: their points are in the body, and their names tell them apart."""

import numpy as np

from staffa.case.rules.body_rules import is_inside
from staffa.case.schema.case import Case
from staffa.case.schema.probe_keys import Line
from staffa.case.schema.toml_text import inline
from staffa.errors import InputError


def probes_are_inside(case: Case) -> None:
    """Require that each probe has the body's dimension, lies in it, and has a unique name."""
    names = set()
    for number, probe in enumerate(case.output.probes, start=1):
        where = f"output.probes, entry {number}"
        points = {"point": probe.point} if not isinstance(probe, Line) else _ends(probe)
        for key, point in points.items():
            is_inside(case, f"{where}, {key} = {inline(point)}", point)
            _is_in_rock(case, f"{where}, {key} = {inline(point)}", point)
        if isinstance(probe, Line) and probe.start == probe.end:
            raise InputError(
                f"{where}: start and end are both {inline(probe.start)}; move one, or give a point"
            )
        if probe.name in names:
            raise InputError(
                f"{where}, name = {inline(probe.name)}: an entry before it has this name; choose "
                f"another, since probes.csv tells them apart by it"
            )
        names.add(probe.name)


def _is_in_rock(case: Case, said: str, point: tuple[float, ...]) -> None:
    """Refuse a point in the hole of a shape, or beyond its round side."""
    keys = case.domain.shape
    x = np.array([[float(c)] for c in point])
    if keys is not None and not keys.shape().contains(x, 0.0)[0]:
        raise InputError(f"{said} lies where the shape has no rock; move it into the body")


def _ends(probe: Line) -> dict[str, tuple[float, ...]]:
    return {"start": probe.start, "end": probe.end}
