"""What differs between two runs besides their results: keys of the cases, facts of the runs."""

from collections.abc import Callable, Iterator, Mapping
from hashlib import file_digest
from operator import eq
from typing import Any

from pydantic import BaseModel

from staffa.case.schema.case import Case
from staffa.case.schema.toml_text import inline
from staffa.case.values.attached_files import attached
from staffa.compare.pair import Pair
from staffa.records.manifest import Manifest
from staffa.results.slab_table import ABSENT, Table

# Facts of a manifest that are not in the case, or follow from more than one of its keys.
FACTS = (
    *("version", "commit", "ranks", "law", "scaled", "adaptive", "mesh", "cells", "unknowns"),
    *("toughness_factor", "tip_reach"),
)


def case_differences(pair: Pair) -> Table:
    """The keys of the cases whose values differ, defaults resolved; 5 mm and 0.005 m do not.

    So do the files that they name, by the first digits of their SHA-256.
    """
    cases = [dict(_keys(side.case)) for side in pair.sides]
    rows = _rows(*cases, same=lambda a, b: a == b or inline(a) == inline(b), text=_value)
    rows += _rows(*(dict(_files(side.case)) for side in pair.sides), same=eq, text=_fact)
    return Table(
        header=("case", *pair.names),
        rows=rows,
        notes=() if rows else ("The cases do not differ.",),
    )


def manifest_differences(pair: Pair) -> Table:
    """What differs of how the cases were run, and of the numbers derived from them."""
    facts = [dict(_facts(side.run.manifest)) for side in pair.sides]
    rows = _rows(*facts, same=lambda a, b: _fact(a) == _fact(b), text=_fact)
    return Table(
        header=("run", *pair.names),
        rows=rows,
        notes=() if rows else ("Version, ranks, mesh and derived numbers do not differ.",),
    )


def _rows(
    one: Mapping[str, Any],
    other: Mapping[str, Any],
    *,
    same: Callable[[Any, Any], bool],
    text: Callable[[Any], str],
) -> tuple[tuple[str, ...], ...]:
    values = ((name, one.get(name), other.get(name)) for name in dict.fromkeys([*one, *other]))
    return tuple((name, text(a), text(b)) for name, a, b in values if not same(a, b))


def _keys(case: Case) -> Iterator[tuple[str, Any]]:
    for section in Case.model_fields:
        table = getattr(case, section)
        if not isinstance(table, BaseModel):
            yield section, table
            continue
        yield from ((f"{section}.{key}", value) for key, value in table)  # names of faces too


def _files(case: Case) -> Iterator[tuple[str, Any]]:
    for path in attached(case):
        with path.open("rb") as file:
            yield path.name, file_digest(file, "sha256").hexdigest()[:8]


def _facts(manifest: Manifest) -> Iterator[tuple[str, Any]]:
    for name in FACTS:
        yield name.replace("_", " "), getattr(manifest, name)
    yield "planned times", len(manifest.times)
    yield from ((f"{name} of a script", own.identity) for name, own in (manifest.own or {}).items())
    yield from manifest.scales.items()
    yield from ((f"{name}, version", version) for name, version in manifest.versions.items())
    yield from ((f"PETSc {name}", value) for name, value in manifest.petsc_options.items())


def _value(value: Any) -> str:
    return ABSENT if value is None else inline(value)


def _fact(value: Any) -> str:
    if value is None:
        return ABSENT
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
