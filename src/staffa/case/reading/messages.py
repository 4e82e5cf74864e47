"""Messages about wrong keys of a case: one sentence each, with the way to correct it."""

import re
from collections.abc import Sequence
from typing import Any, TypeAliasType, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from staffa.case.schema.case import Case
from staffa.case.schema.shape_keys import KINDS
from staffa.case.schema.toml_text import as_toml, inline
from staffa.errors import choices, did_you_mean

EXPLAINED = "`staffa new slab` writes a case with every key explained"
# What the kinds of Pydantic's errors mean to someone who writes TOML.
RULES = {
    "greater_than": "it must be larger than {gt:g}",
    "greater_than_equal": "it must be at least {ge:,}",
    "less_than": "it must be less than {lt:,}",
    "less_than_equal": "it must be at most {le:,}",
    "finite_number": "it must be a finite number",
    "float_type": "it must be one number, without quotes",
    "int_type": "it must be a whole number, without quotes",
    "bool_type": "it must be true or false, without quotes",
    "string_type": "it must be a text in quotes",
    "string_too_long": "it must have at most {max_length} characters",
    "too_long": "it must have at most {max_length:,} entries",
}
# Parts of Pydantic's locations that name an alternative of a key, and are no key.
ALTERNATIVES = (
    *(
        "a table",
        "a table of temperature",
        "adaptive steps",
        "a value",
        "a list",
        "a formula",
        "a segment",
        "a disc",
        "a side",
    ),
    *("one value", "one property", "a random field", "a file"),
    *("a named one", *(f"kind {kind}" for kind in KINDS)),
    *("a spot", "a line"),
)
# Names that users bring along from papers and other codes.
OTHER_NAMES = {
    "alpha": "expansion",
    "beta": "expansion",
    "young": "E",
    "youngs_modulus": "E",
    "poisson": "nu",
    "epsilon": "ell",
    "length_scale": "ell",
    "diffusivity": "kappa",
    "mesh": "domain",
    "geometry": "domain",
    "boundary": "supports",
    "conductivity": "k",
    "lambda": "k",
    "density": "rho",
    "heat_capacity": "c",
    "specific_heat": "c",
    "cp": "c",
    "c_p": "c",
    "rho_c": "capacity",
    "rho_cp": "capacity",
    "temperature": "T",
    "heat_flux": "flux",
    "q": "flux",
    "convection": "h",
    "film": "h",
    "htc": "h",
    "residual": "conductivity",
    "t0": "initial",
    "t_0": "initial",
    "reference": "stress_free",
    "t_ref": "stress_free",
    "geotherm": "initial",
}


def message(error: ValidationError) -> str:
    """Return the error that explains most: an unknown key first, which may cause others."""
    details = error.errors(include_url=False)
    for detail in details:
        if detail["type"] == "extra_forbidden":
            return unknown_key(detail["loc"][:-1], str(detail["loc"][-1]))
    return _wrong_value(details[0])


def unknown_key(parts: Sequence[int | str], key: str) -> str:
    """Return a sentence on a key that a table does not have, with the keys that it has."""
    keys = [part for part in parts if part not in ALTERNATIVES]
    names = {name for model in _models_at(keys) for name in model.model_fields}
    owner = "a case" if not keys else f"[{keys[0]}]" if len(keys) == 1 else _where(keys)
    if key in names:  # of another alternative
        return f"{owner}: '{key}' does not go with the other keys there; leave it or them out"
    refused = f"{owner} has no key '{as_toml(key, 40).strip('"')}'"
    known_as = OTHER_NAMES.get(key.casefold())
    if known_as in names:
        return f"{refused}; it is called '{known_as}' here"
    tables = [name for name in Case.model_fields if key in _names_in(name)]
    if tables and len(keys) < 2 and not did_you_mean(key, names):
        return f"{refused}; it stands in [{tables[0]}]"
    return f"{refused}; {choices(key, names)}"


def _wrong_value(detail: Any) -> str:
    kind, context = detail["type"], detail.get("ctx", {})
    keys = [part for part in detail["loc"] if part not in ALTERNATIVES]
    if kind == "missing":
        return _missing(keys)
    if kind == "value_error":
        rule = str(context["error"])
    elif kind == "literal_error":
        rule = _one_of(keys, detail["input"], re.findall(r"'([^']*)'", context["expected"]))
    elif kind == "union_tag_invalid" and context["tag"].startswith("kind "):
        given = context["tag"].removeprefix("kind ")
        rule = (
            f"its kind must be one of {', '.join(map(inline, KINDS))}.{did_you_mean(given, KINDS)}"
        )
    elif kind in RULES:
        rule = RULES[kind].format(**context)
    else:
        rule = _likeness(keys)
    return f"{_where(keys)} = {as_toml(detail['input'])}: {rule}"


def _missing(keys: Sequence[int | str]) -> str:
    field = _field(keys)
    if isinstance(keys[-1], int):
        return f"{_where(keys[:-1])}: entry {keys[-1] + 1} is missing; {_likeness(keys[:-1])}"
    if field is None or not field.examples:
        return f"[{_where(keys)}] is missing; {EXPLAINED}"
    return (
        f"{_where(keys)} is missing ({field.description}); write it like "
        f"{keys[-1]} = {inline(field.examples[0])}"
    )


def _one_of(keys: Sequence[int | str], value: Any, names: list[str]) -> str:
    field = _field(keys)
    examples = field.examples if field and field.examples else []
    tables = [f", or a table like {inline(e)}" for e in examples if isinstance(e, dict)]
    guess = did_you_mean(value, names) if isinstance(value, str) else ""
    return f"it must be one of {', '.join(map(inline, names))}{''.join(tables[:1])}.{guess}"


def _likeness(keys: Sequence[int | str]) -> str:
    """Return a sentence with an example of a value, from the examples of its key."""
    field = _field(keys)
    if field is None or not field.examples:
        return f"it must be a table, a line [{_where(keys)}] with its keys below it; {EXPLAINED}"
    name = next(key for key in reversed(keys) if isinstance(key, str))
    return f"write {name} like {' or '.join(map(inline, field.examples))}"


def _where(keys: Sequence[int | str]) -> str:
    """Return keys as a user counts them: toughness.bands, entry 2, factor."""
    text, between = "", ""
    for key in keys:
        text += f", entry {key + 1}" if isinstance(key, int) else between + key
        between = ", " if isinstance(key, int) else "."
    return text


def _field(keys: Sequence[int | str]) -> FieldInfo | None:
    """Return the field of a key, None for an unknown key."""
    named = [key for key in keys if isinstance(key, str)]
    found = [field for m in _models_at(named[:-1]) if (field := _field_of(m, named[-1]))]
    return found[0] if found else None


def _names_in(table: str) -> set[str]:
    models = models_in(Case.model_fields[table].annotation)
    return {name for model in models for name in model.model_fields}


def _models_at(keys: Sequence[int | str]) -> list[type[BaseModel]]:
    """Return the tables that may stand at these keys."""
    models: list[type[BaseModel]] = [Case]
    for key in keys:
        fields = [found for model in models if (found := _field_of(model, str(key)))]
        if fields:
            models = [found for field in fields for found in models_in(field.annotation)]
    return models


def _field_of(model: type[BaseModel], key: str) -> FieldInfo | None:
    """Return the field of a key of a table; the name of a face gives the field of any face."""
    if key not in model.model_fields and model.model_config.get("extra") == "allow":
        key = "left"
    return model.model_fields.get(key)


def models_in(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    alias = get_origin(annotation)  # of a kind of values with parameters: these, and what it holds
    held = [alias.__value__] if isinstance(alias, TypeAliasType) else []
    return [model for part in (*held, *get_args(annotation)) for model in models_in(part)]
