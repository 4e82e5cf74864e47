"""From a case to TOML text: as resolved for the record, or with every key explained."""

import re
import textwrap
from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from staffa.case.schema.case import Case, Disc, Named, Segment
from staffa.case.schema.force_keys import ForceKeys
from staffa.case.schema.heat_keys import HeatKeys
from staffa.case.schema.material_keys import RegionKeys
from staffa.case.schema.reservoir_keys import ReservoirKeys
from staffa.records.case_about import ABOUT
from staffa.units import Quantity

WIDTH = 96
UNITS = """Numbers are either all scaled (then E = Gc = expansion = kappa = k = rho = c = 1 need not
be given), or all have units, in quotes: "70 GPa", "5 mm", "10 J/m^2", "120 K", "9e-6 1/K", "2 min".
"""
# Keys whose default follows from the loads and the rock: a case to be edited leaves it open.
FOLLOW = ("split", "elements")
# Tables that a case may lack altogether.
OPTIONAL: dict[str, type[BaseModel]] = {
    "heat": HeatKeys,
    "reservoir": ReservoirKeys,
    "forces": ForceKeys,
}


def inline(value: Any) -> str:
    """Return a value as TOML writes it on one line."""
    if isinstance(value, BaseModel):
        value = {name: getattr(value, name) for name in _names(value)}
    if isinstance(value, dict):
        pairs = [f"{_key(key)} = {inline(v)}" for key, v in value.items() if v is not None]
        return f"{{ {', '.join(pairs)} }}" if pairs else "{}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(inline(v) for v in value)}]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, Quantity):
        return inline(value.given)
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"')
        return '"' + "".join(c if c.isprintable() else _escaped(c) for c in escaped) + '"'
    return repr(value) if isinstance(value, int | float) else str(value)  # or a date


def as_toml(value: Any, width: int = 60) -> str:
    """Return a value as it stands in the file, cut short."""
    try:
        text = inline(value)
    except RecursionError:
        text = "[[[..."
    return text if len(text) <= width else text[: width - 3] + "..."


def _escaped(character: str) -> str:
    code = ord(character)
    return f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def to_toml(case: Case, *, explained: bool = False) -> str:
    """Return the case as TOML that reads back as the same case.

    Parameters
    ----------
    case : the case.
    explained : True for a comment on every key, and for unset keys as comments with an example.
    """
    lines = [*_comment(UNITS), ""] if explained else []
    lines += _keys(case, explained, tables=False)
    for name, field in Case.model_fields.items():
        table = getattr(case, name)
        if isinstance(table, BaseModel):
            lines.append("")
            if explained:
                lines += _comment(type(table).__doc__ or "")
            lines += [f"[{name}]", *_keys(table, explained, tables=True)]
        elif isinstance(table, dict):
            lines += _regions(table, explained)
        elif name in OPTIONAL:
            lines += ["", *_absent(name, OPTIONAL[name])] if explained else []
        elif name not in ABOUT and (table or explained):
            lines += ["", *_cracks(case, field, explained)]
    return "\n".join(lines).strip() + "\n"


def _keys(table: BaseModel, explained: bool, *, tables: bool) -> Iterator[str]:
    for name in _names(table):
        field = type(table).model_fields.get(name)
        value = getattr(table, name)
        if not tables and name not in ABOUT:
            continue
        if explained:
            yield from _comment(field.description or "" if field else "a face of the body")
        follows = explained and name in FOLLOW and name not in table.model_fields_set
        if value is not None and not follows:
            yield f"{_key(name)} = {inline(value)}"
        elif explained and field:
            yield _example(name, field)


def _names(table: BaseModel) -> tuple[str, ...]:
    """Return the keys of a table: those that every case has, then the names that the case adds."""
    return (*type(table).model_fields, *(table.model_extra or {}))


def _key(name: str) -> str:
    """Return a name as TOML writes it before the equals sign."""
    return name if re.fullmatch(r"[\w-]+", name, re.ASCII) else inline(name)


def _example(name: str, field: FieldInfo) -> str:
    """Return a key as a comment, with its default or an example."""
    given = [*(field.examples or []), *([] if field.is_required() else [field.default])]
    return f"# {name} = {inline(given[0])}"


def _absent(name: str, model: type[BaseModel]) -> Iterator[str]:
    """Yield a table that the case lacks, as comments."""
    yield from _comment(model.__doc__ or "")
    yield f"# [{name}]"
    for key, field in model.model_fields.items():
        yield from _comment(field.description or "")
        yield _example(key, field)


def _regions(regions: dict[str, RegionKeys], explained: bool) -> Iterator[str]:
    """Yield the tables [regions.NAME], or one as comments; other keys are those of [material]."""
    if explained:
        yield from ["", *_comment(RegionKeys.__doc__ or "")]
    if explained and not regions:
        yield "# [regions.NAME]"
        for key in ("lower", "upper", "E"):
            field = RegionKeys.model_fields[key]
            yield from [*_comment(field.description or ""), _example(key, field)]
    for name, region in regions.items():
        bare = re.fullmatch(r"[A-Za-z0-9_-]+", name)
        yield from ["", f"[regions.{name if bare else inline(name)}]"]
        for key, field in type(region).model_fields.items():
            value = getattr(region, key)
            if value is not None:
                yield from _comment(field.description or "") if explained else ()
                yield f"{key} = {inline(value)}"


def _comment(text: str) -> list[str]:
    return textwrap.wrap(" ".join(text.split()), WIDTH, initial_indent="# ", subsequent_indent="# ")


def _cracks(case: Case, field: FieldInfo, explained: bool) -> Iterator[str]:
    """Yield the tables [[cracks]], or an example of one as a comment."""
    if explained:
        yield from _comment(field.description or "")
    shape = Segment if case.dim == 2 else Disc
    if not case.cracks:
        yield "# [[cracks]]"
        for name, key in (shape.model_fields | Named.model_fields).items():
            yield from _comment(key.description or "")
            yield _example(name, key)
    for crack in case.cracks:
        yield "[[cracks]]"
        yield from _keys(crack, explained, tables=True)
