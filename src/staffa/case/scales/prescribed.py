"""All that a case prescribes in time, as curves: tables, and formulas of t at some places."""

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import BaseModel

from staffa.case.rules.time_rules import times_given
from staffa.case.scales.knots import DEPART
from staffa.case.schema.case import Case
from staffa.case.schema.field_types import Formula
from staffa.case.schema.heat_keys import InTime
from staffa.case.schema.support_keys import DisplacementFile, DisplacementHistory
from staffa.case.values.diffusion_time import times_in
from staffa.properties.formula import formula, formula_variables, uses

SAMPLES = 1001  # times at which a formula is looked at, before what is steep between them
MOST_SAMPLES = 10_000  # then nothing more is closed in on
PLACES = 9  # points at which a formula is looked at
# A jump of a formula is closed in on down to this part of the run.
JUMP = 1e-9
FORMULA_OF_T = "temperature.T"
TIME = re.compile(r"\bt\b")
type Table = DisplacementHistory | InTime | DisplacementFile


@dataclass(frozen=True, kw_only=True)
class PrescribedCurve:
    """Prescribed value in time.

    Attributes
    ----------
    where : its key.
    t : times (s), shape (n,).
    values : values at m places, shape (n, m).
    """

    where: str
    t: np.ndarray
    values: np.ndarray


def curves(case: Case) -> Iterator[PrescribedCurve]:
    """Yield every value of a case that is prescribed in time, from t = 0 to the end of the run.

    Among its times are those of the case and of its outputs. Beyond the times of a table its value
    stays. A formula is looked at SAMPLES times, and between them where it changes by more than
    `knots.DEPART` of its range.
    """
    visited = visited_times(case)
    end = visited[-1]
    for where, given in prescribed(case):
        if isinstance(given, Formula):
            side = where.split(".")[1]
            on = side if side in case.outline.faces else None
            yield _of_formula(case, where, given.formula, on, visited)
            continue
        t, values = (np.array(column, dtype=float) for column in table_columns(given))
        within = np.unique([0.0, *t[t < end], *visited])
        yield PrescribedCurve(where=where, t=within, values=np.interp(within, t, values)[:, None])
    if case.temperature.T is not None and uses(case.temperature.T, "t"):
        begin = float(visited[0])  # what is before belongs to the first step
        yield _of_formula(case, FORMULA_OF_T, case.temperature.T, None, visited, begin)


def visited_times(case: Case) -> np.ndarray:
    """Return the times of a case and of its outputs (s), increasing; of adaptive steps the ends."""
    outputs = np.array(case.output.at, dtype=float)
    return np.unique([*times_in(case, times_given(case)), *times_in(case, outputs)])


def table_columns(table: Table) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """Return the times of a table and the values at them; of a field in a file its factors."""
    if isinstance(table, DisplacementFile):
        return table.t or (), table.factor or ()
    return table.t, table.u if isinstance(table, DisplacementHistory) else table.value


def prescribed(section: BaseModel, path: str = "") -> Iterator[tuple[str, Table | Formula]]:
    """Yield every table in time and every formula of t of a case, with its key."""
    for name in (*type(section).model_fields, *(section.model_extra or {})):
        value = getattr(section, name)
        where = f"{path}.{name}".lstrip(".")
        of_time = isinstance(value, Formula) and TIME.search(value.formula)
        if of_time or isinstance(value, DisplacementHistory | InTime):
            yield where, value
        elif isinstance(value, DisplacementFile):
            if value.t is not None:
                yield where, value
        elif isinstance(value, BaseModel):
            yield from prescribed(value, where)


def _of_formula(
    case: Case, where: str, text: str, side: str | None, visited: np.ndarray, begin: float = 0.0
) -> PrescribedCurve:
    """Return a formula in time at some places of a side, or of the body (None)."""
    on = case.outline.places.on(side)
    x = on[:, np.unique(np.linspace(0, on.shape[1] - 1, PLACES).round().astype(int))]
    function = formula(text, formula_variables(case.dim))

    def at(times: np.ndarray) -> np.ndarray:
        return np.array([np.zeros(x.shape[1]) + function(x, float(time)) for time in times])

    t, values = _sampled(at, np.unique([*np.linspace(begin, visited[-1], SAMPLES), *visited]))
    return PrescribedCurve(where=where, t=t, values=values)


def _sampled(
    at: Callable[[np.ndarray], np.ndarray], t: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return times and values, with more times where the value changes much between two of them."""
    values = at(t)
    least = JUMP * float(t[-1])
    while True:
        much = DEPART * float(np.ptp(values, axis=0).max())
        steep = (np.abs(np.diff(values, axis=0)).max(axis=1) > much) & (np.diff(t) > least)
        if not steep.any() or len(t) > MOST_SAMPLES:
            return t, values
        between = (t[:-1] + t[1:])[steep] / 2
        where = np.flatnonzero(steep) + 1
        t, values = np.insert(t, where, between), np.insert(values, where, at(between), axis=0)
