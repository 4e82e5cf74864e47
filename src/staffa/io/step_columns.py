"""The steps of a run as flat rows, a name for each number, in SI units."""

from collections.abc import Iterator, Sequence
from dataclasses import is_dataclass
from functools import cache
from math import nan
from types import UnionType
from typing import TYPE_CHECKING, Any, NamedTuple, Union, get_args, get_origin, get_type_hints

from staffa.errors import InputError
from staffa.geometry.block import face_axis
from staffa.io.production_rows import production
from staffa.records.manifest import Manifest
from staffa.records.step import Step

if TYPE_CHECKING:
    from pandas import DataFrame

SCALARS = (int, float, bool, str)
# Numbers that follow from more than one entry of a record.
DERIVED = ("energies_total", "audit_violations", "cracks", "spacing", "deepest")
TOGETHER = ("T", "power", "heat", "pressure", "drawdown", "area")  # of all wells together
RENAMED = {"index": "step"}  # a frame has an `index` already


class Field(NamedTuple):
    """A number or a text of a step, by the name of its column.

    Attributes
    ----------
    name : those of the record that holds it and of the value: "audit_balance".
    path : attributes that lead from the step to it.
    kind : its type.
    """

    name: str
    path: tuple[str, ...]
    kind: type


@cache
def fields_of(record: Any = Step) -> tuple[Field, ...]:
    """Return the numbers and texts of a record and of the records in it.

    Parameters
    ----------
    record : its class.
    """
    return tuple(_fields(record))


def _fields(record: Any) -> Iterator[Field]:
    for name, hint in get_type_hints(record).items():
        kinds = get_args(hint) if get_origin(hint) in (Union, UnionType) else (hint,)
        inner: Any = next(filter(is_dataclass, kinds), None)
        scalar = next((k for k in kinds if isinstance(k, type) and issubclass(k, SCALARS)), None)
        if inner is not None:
            for field in fields_of(inner):
                yield Field(f"{name}_{field.name}", (name, *field.path), field.kind)
        elif scalar is not None:
            yield Field(RENAMED.get(name, name), (name,), scalar)


def frame_of(manifest: Manifest, steps: Sequence[Step]) -> "DataFrame":
    """Return a pandas frame with a row for each step.

    Parameters
    ----------
    manifest : of the run.
    steps : of the run.

    Raises
    ------
    InputError
        pandas is not installed.
    """
    rows = rows_of(manifest, steps)
    own = [f"quantities_{name}" for q in manifest.quantities for name in q.columns]
    return pandas_frame(rows, [*(field.name for field in fields_of()), *DERIVED, *own])


def pandas_frame(rows: Sequence[Any], columns: Sequence[str]) -> "DataFrame":
    """Return a pandas frame of rows.

    Parameters
    ----------
    rows : each as a dictionary or a tuple.
    columns : names of its columns if there is no row.

    Raises
    ------
    InputError
        pandas is not installed.
    """
    try:
        from pandas import DataFrame
    except ImportError as error:
        raise InputError(
            f"a frame of a run needs pandas, which does not load ({error}); `pip install "
            f"'staffa[frames]'`"
        ) from None
    return DataFrame(rows) if rows else DataFrame(columns=columns)


def rows_of(manifest: Manifest, steps: Sequence[Step]) -> list[dict[str, Any]]:
    """Return a row for each step, as docs/reference/results.md lists its columns.

    Parameters
    ----------
    manifest : of the run.
    steps : of the run.

    Returns
    -------
    list of dict
        Values by the names of their columns, in SI units; what a step lacks is NaN, of texts None.
    """
    flows = _water(manifest, steps)
    return [
        {field.name: _value(step, field) for field in fields_of()}
        | {"energies_total": step.energies.total}
        | {"audit_violations": len(step.audit.violations) if step.audit else nan}
        | _cracks(manifest, step)
        | _by_side(step)
        | _quantities(manifest, step)
        | flows.get(step.index, {})
        for step in steps
    ]


def _water(manifest: Manifest, steps: Sequence[Step]) -> dict[int, dict[str, float]]:
    """Return the production of all wells together, by step; of a shadow too, where there is one."""
    rows: dict[int, dict[str, float]] = {}
    for ending, cracks in (("", True), ("_without", False)):
        for found in production(manifest.reservoir, steps, cracks=cracks):
            rows.setdefault(found.step, {}).update(
                {f"production_{name}{ending}": getattr(found, name) for name in TOGETHER}
            )
    return rows


def _value(step: Step, field: Field) -> Any:
    value: Any = step
    for name in field.path:
        value = getattr(value, name, None)
    return nan if value is None and field.kind is not str else value


def _cracks(manifest: Manifest, step: Step) -> dict[str, float]:
    """Return the number of cracks, their mean spacing, the deepest, and those at each depth."""
    measures, face = step.measures, manifest.face
    found = {"cracks": nan, "spacing": nan, "deepest": nan}
    if measures is None:
        return found
    if face is not None:
        found |= {"cracks": len(measures.tips), "deepest": manifest.deepest(measures)}
    if face is not None and manifest.flat and len(measures.tips) > 1:
        across = face_axis(str(manifest.cooled_side), 2)
        along = [tip.position[1 - across] for tip in measures.tips]
        found["spacing"] = (max(along) - min(along)) / (len(along) - 1)
    return found | {f"cracks_at_{s.height:.6g}": s.cracks for s in measures.sections}


def _by_side(step: Step) -> dict[str, float]:
    """Return the forces of supports and the heat that entered, by side."""
    forces = {
        f"reaction_{side}_{axis}": component
        for side, force in step.reactions.items()
        for axis, component in zip("xyz", force, strict=False)
    }
    heat = step.heat.entered if step.heat else {}
    return forces | {f"heat_from_{source}": amount for source, amount in heat.items()}


def _quantities(manifest: Manifest, step: Step) -> dict[str, float]:
    """Return the quantities of a script, in the units of these; no name is that of another."""
    return {
        f"quantities_{name}": number
        for quantity in manifest.quantities
        for name, number in zip(
            quantity.columns, step.quantities.get(quantity.name, ()), strict=False
        )
    }
