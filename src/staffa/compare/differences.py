"""Differences between two runs besides their results: keys of the cases, facts of the runs."""

from collections.abc import Callable, Iterable, Iterator
from hashlib import file_digest
from typing import Any

from pydantic import BaseModel

from staffa.case.schema.case import Case
from staffa.case.schema.toml_text import inline
from staffa.case.values.attached_files import attached
from staffa.compare.pair import Pair, Side
from staffa.records.manifest import Manifest
from staffa.results.tables import ABSENT, Table, columns_of

# Facts of a manifest that are not in the case, or follow from more than one of its keys.
FACTS = (
    *("version", "commit", "ranks", "law", "scaled", "adaptive", "mesh", "cells", "unknowns"),
    *("toughness_factor", "tip_reach"),
)
LABELS = {
    **{"cells": "cells at the start", "unknowns": "unknowns at the start"},
    **{"toughness_factor": "effective Gc over Gc", "tip_reach": "tip reach"},
}
# Keys of a case in whose place a script may give an object, by the name of its argument.
GIVEN = {"damage": "damage.law", "split": "damage.split", "temperature": "temperature"}
Facts = Iterable[tuple[str, Any]]


def case_differences(pair: Pair) -> Table:
    """Return the keys whose values differ, defaults resolved; 5 mm and 0.005 m do not.

    Files that the cases name are told by the first digits of their SHA-256. What a script gave in
    place of keys stands in their place, by its identity.
    """
    owns = [side.run.manifest.own or {} for side in pair.sides]
    given = {key for name, key in GIVEN.items() if any(name in own for own in owns)}
    rows = tuple(_given(pair, name) for name in GIVEN if GIVEN[name] in given)
    rows = tuple(row for row in rows if row[1] != row[2])
    rows += tuple(row for row in _rows(pair, _keys, inline) if row[0] not in given)
    rows += _rows(pair, lambda side: _files(side.case), _fact)
    return _table(pair, "case", rows, "The cases do not differ.")


def manifest_differences(pair: Pair) -> Table:
    """Return what differs in the way the cases were run, and in the numbers derived from them."""
    rows = _rows(pair, lambda side: _facts(side.run.manifest), _fact)
    return _table(pair, "run", rows, "Version, ranks, mesh and derived numbers do not differ.")


def _table(pair: Pair, of: str, rows: tuple[tuple[str, ...], ...], same: str) -> Table:
    return Table(
        title=f"What differs in the {of}s",
        columns=columns_of(of, *pair.names),
        rows=rows,
        notes=() if rows else (same,),
    )


def _rows(
    pair: Pair, facts: Callable[[Side], Facts], text: Callable[[Any], str]
) -> tuple[tuple[str, ...], ...]:
    """Return names and texts of the facts that differ, as values and as text."""
    one, other = (dict(facts(side)) for side in pair.sides)
    pairs = [(name, (one.get(name), other.get(name))) for name in {**one, **other}]
    told = [
        (name, *(ABSENT if value is None else text(value) for value in both))
        for name, both in pairs
        if both[0] != both[1]
    ]
    return tuple(row for row in told if row[1] != row[2])


def _given(pair: Pair, name: str) -> tuple[str, ...]:
    """Return the row of what a script gave at least one of the runs.

    Parameters
    ----------
    pair : the two runs.
    name : name of the argument, of GIVEN.
    """
    manifests = [side.run.manifest for side in pair.sides]
    found = [(manifest.own or {}).get(name) for manifest in manifests]
    one, other = (
        _of_the_case(side.case, name) if own is None else f"{own.identity}, of a script"
        for own, side in zip(found, pair.sides, strict=True)
    )
    a, b = found
    if a and b and a.identity == b.identity and _tried_alike(pair, name) and not a.alike(b):
        other += ", but with other values"
    return GIVEN[name], one, other


def _tried_alike(pair: Pair, name: str) -> bool:
    """Return True if the objects of both scripts were tried at the same places, times and strains.

    Parameters
    ----------
    pair : the two runs.
    name : name of the argument, of GIVEN.
    """
    one, other = pair.sides
    if name == "split":  # in plane stress at two principal strains, else at three
        return one.case.plane_stress == other.case.plane_stress
    if name == "temperature":  # at the vertices of the mesh, at the first and the last time
        a, b = ((side.run.manifest.own or {})[name].at for side in pair.sides)
        return one.run.manifest.mesh == other.run.manifest.mesh and a == b
    return True


def _of_the_case(case: Case, name: str) -> str:
    """Return the law or split of the case; its temperature has separate rows."""
    return (
        "of the case"
        if name == "temperature"
        else inline(getattr(case.damage, GIVEN[name].partition(".")[2]))
    )


def _keys(side: Side) -> Iterator[tuple[str, Any]]:
    """Yield the keys of a case that act: a load of a script takes the place of its cooling."""
    replaced = ("temperature", "heat") if side.run.manifest.own_load else ()
    for section in Case.model_fields:
        table = getattr(side.case, section)
        if not isinstance(table, BaseModel):
            if section not in replaced:
                yield section, table
            continue
        for key, value in table:  # names of faces too
            if section not in replaced or (section, key) == ("temperature", "face"):
                yield f"{section}.{key}", value


def _files(case: Case) -> Iterator[tuple[str, Any]]:
    for path in attached(case):
        with path.open("rb") as file:
            yield path.name, file_digest(file, "sha256").hexdigest()[:8]


def _facts(manifest: Manifest) -> Iterator[tuple[str, Any]]:
    yield from ((LABELS.get(name, name), getattr(manifest, name)) for name in FACTS)
    yield "planned times", len(manifest.times)
    yield from manifest.scales.items()
    yield from ((f"{name}, version", version) for name, version in manifest.versions.items())
    yield from ((f"PETSc {name}", value) for name, value in manifest.petsc_options.items())


def _fact(value: Any) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
