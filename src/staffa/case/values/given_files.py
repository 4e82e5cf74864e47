"""Fields in files that a case names besides those of its rock: their keys and what they cover."""

from collections.abc import Iterator

import numpy as np

from staffa.case.schema.case import Case
from staffa.case.schema.property_keys import FieldFile
from staffa.case.schema.support_keys import DisplacementFile, Prescribed
from staffa.properties.mesh_field import MeshField

START = ("initial", "stress_free")


def given_files(case: Case) -> Iterator[tuple[str, FieldFile, str | None]]:
    """Yield each: its key, itself, and the face that it is for, None for the whole body."""
    for name in START:
        value = getattr(case.heat, name, None)
        if isinstance(value, FieldFile):
            yield f"heat.{name}", value, None
    for side in case.outline.faces:
        given = case.heat.on(side) if case.heat is not None else None
        if given is not None and isinstance(given.T, FieldFile):
            yield f"heat.{side}.T", given.T, side
        support = case.supports.on(side)
        for axis in "xyz" if isinstance(support, Prescribed) else "":
            value = getattr(support, axis)
            if isinstance(value, FieldFile):
                yield f"supports.{side}.{axis}", value, side


def in_body(case: Case, value: FieldFile) -> MeshField:
    """Return the field at vertices of the body, which may lie a cell outside of the file's mesh: by
    so much do two meshes of one round body differ. There it has the value of the nearest place."""
    return value.field.reaching(case.outline.h)


def factors(value: DisplacementFile) -> tuple[np.ndarray, np.ndarray]:
    """Return times (s) and the factor at each, of shape (n,)."""
    if value.t is None or value.factor is None:
        return np.zeros(1), np.ones(1)
    return np.array(value.t, dtype=float), np.array(value.factor, dtype=float)


def largest_displacement(value: DisplacementFile) -> float:
    """Return the displacement of largest size in it (m), with its sign."""
    found = value.field.values
    return float(found[np.argmax(np.abs(found))])
