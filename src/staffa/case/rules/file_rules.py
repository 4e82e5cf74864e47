"""Rules on fields in files: place, units and values."""

from collections.abc import Iterator

import numpy as np

from staffa.case.rules.time_rules import table_agrees
from staffa.case.schema.case import Case
from staffa.case.schema.heat_keys import TemperatureFile
from staffa.case.schema.property_keys import FieldFile
from staffa.case.schema.quantity_text import is_scaled, unit
from staffa.case.schema.support_keys import DisplacementFile
from staffa.case.schema.toml_text import as_toml, inline
from staffa.case.values.given_files import given_files, in_body
from staffa.case.values.subdomains import subdomains_of
from staffa.errors import InputError

UNIT = 'if its coordinates count in another unit, say so, like unit = "1 mm"'


def files_count_as_the_case(case: Case) -> None:
    """Require units of a file's values where the case has units, and of temperatures always.

    A case without units allows none. The body must be larger than the cells of the file's mesh.
    """
    scaled = is_scaled(case)
    for where, value in _files(case):
        if scaled and value.field_unit is not None:
            raise InputError(
                f"{where}.field_unit = {inline(value.field_unit)} is for a case with units, and "
                f"this one is scaled; leave it out"
            )
        if isinstance(value, TemperatureFile) and not scaled and value.field_unit is None:
            raise InputError(
                f"{where}.field_unit is missing: how the temperatures in {value.file} count; write "
                f'it like field_unit = "°C", or "K"'
            )
        _is_larger_than_a_cell(case, where, value)


def _files(case: Case) -> Iterator[tuple[str, FieldFile]]:
    """Yield every field in a file, with its key."""
    for subdomain in subdomains_of(case):
        yield from (
            (where, value)
            for _, where, value in subdomain.properties()
            if isinstance(value, FieldFile)
        )
    yield from ((where, value) for where, value, _ in given_files(case))


def _is_larger_than_a_cell(case: Case, where: str, value: FieldFile) -> None:
    body, dim = case.outline, case.dim
    extent = value.field.cells_around(body.places.on())
    if extent is None or not np.all(extent[:dim] > (1 + 1e-6) * np.array(body.size)):
        return
    raise InputError(
        f"{where} = {as_toml(value)}: the body, {_size(body.size)}{unit(case, 'm')}, is smaller "
        f"than one cell of its mesh, {_size(extent[:dim])}{unit(case, 'm')}; {UNIT}, else give "
        f"a number or a formula"
    )


def _size(extent: tuple[float, ...] | np.ndarray) -> str:
    return " x ".join(f"{length:.4g}" for length in extent)


def files_cover_the_body(case: Case) -> None:
    """Require that fields of temperatures and displacements cover the body, or their side."""
    for where, value, side in given_files(case):
        places = case.outline.places.on(side)
        found = in_body(case, value)(places)
        covers(where, value, case.dim, places, found)
        if isinstance(value, TemperatureFile) and not is_scaled(case) and found.min() < 0:
            raise InputError(
                f"{where} = {as_toml(value)}: {found.min():g} K lies below absolute zero; look at "
                f"field_unit, that of its temperatures"
            )
        if isinstance(value, DisplacementFile):
            _has_its_table(where, value)


def _has_its_table(where: str, value: DisplacementFile) -> None:
    if (value.t is None) != (value.factor is None):
        missing, given = ("t", "factor") if value.t is None else ("factor", "t")
        raise InputError(
            f"{where}.{missing} is missing: a table needs both, times t and a factor on the field "
            f"at each; give it, or leave {given} out"
        )
    if value.t is not None and value.factor is not None:
        table_agrees(where, value.t, value.factor, "factor")


def covers(where: str, value: FieldFile, dim: int, places: np.ndarray, found: np.ndarray) -> None:
    """Require that a field of a file covers all places where it is needed.

    Parameters
    ----------
    where : the key of the field, for messages.
    value : the field of the file.
    dim : dimension of the body.
    places : sampled places (m), shape (3, n).
    found : values of the field there, NaN outside of its mesh, shape (n,).
    """
    lost = ~np.isfinite(found)
    if not np.any(lost):
        return
    at, low, high = (
        inline(tuple(float(f"{c:.4g}") for c in place[:dim]))
        for place in (places[:, np.argmax(lost)], *value.field.bounds)
    )
    raise InputError(
        f"{where} = {as_toml(value)}: its mesh does not reach {at}, nor {lost.mean():.0%} of the "
        f"places; it reaches from {low} to {high}, and must cover all of the body, or of the "
        f"region or side; {UNIT}"
    )
