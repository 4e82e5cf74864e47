"""The JSON schema of a case: every key of every table, held to the models, the cases and errors."""

import json
import tomllib
import warnings
from collections.abc import Iterator
from typing import Any

import pytest
from jsonschema import Draft202012Validator
from pydantic import BaseModel

from staffa.case.reading.messages import models_in
from staffa.case.reading.read import parse_case
from staffa.case.reading.ready_cases import ready_case, ready_case_names, text
from staffa.case.schema.case import Case
from staffa.case.schema.field_types import CaseTable
from staffa.case.schema.toml_text import to_toml
from staffa.errors import InputError
from support.commands import forked

KEYWORDS = {
    *("$defs", "$ref", "$schema", "pattern", "x-dimensions"),
    *("additionalProperties", "anyOf", "const", "default", "description", "enum"),
    *("examples", "exclusiveMaximum", "exclusiveMinimum", "items", "maxItems", "maxLength"),
    *("maximum", "minItems", "minLength", "minimum", "oneOf", "prefixItems", "properties"),
    *("required", "title", "type"),
}
TYPES = {"object", "array", "string", "number", "integer", "boolean"}


@pytest.fixture(scope="module")
def schema() -> dict[str, Any]:
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a default that cannot be written would be left out
        return Case.model_json_schema()


def nodes(tree: Any) -> Iterator[dict[str, Any]]:
    """All objects within a schema that are schemas themselves."""
    yield tree
    inside = [*tree.get("properties", {}).values(), *tree.get("$defs", {}).values()]
    for name in ("anyOf", "oneOf", "allOf", "prefixItems"):
        inside += tree.get(name, [])
    inside += [tree[name] for name in ("items", "additionalProperties") if tree.get(name)]
    for node in inside:
        yield from nodes(node)


def tables(model: type[BaseModel], seen: dict[str, type[BaseModel]]) -> dict[str, type[BaseModel]]:
    """The model, and all that its keys may hold, by name."""
    if model.__name__ not in seen:
        seen[model.__name__] = model
        for field in model.model_fields.values():
            for inner in models_in(field.annotation):
                tables(inner, seen)
    return seen


def test_the_schema_is_one_and_survives_json(schema: dict[str, Any]) -> None:
    again = json.loads(json.dumps(schema))
    assert again == schema
    for node in nodes(schema):
        kinds = node.get("type", [])
        assert set([kinds] if isinstance(kinds, str) else kinds) <= TYPES, node
        assert {"type", "$ref", "anyOf", "oneOf", "allOf", "enum", "const"} & set(node), node
        assert set(node) <= KEYWORDS, node
        if "$ref" in node:
            assert node["$ref"].removeprefix("#/$defs/") in schema["$defs"], node
        assert set(node.get("required", [])) <= set(node.get("properties", {})), node


def test_every_key_of_every_table_stands_in_it(schema: dict[str, Any]) -> None:
    found = tables(Case, {})
    assert len(found) > 30 and all(issubclass(model, CaseTable) for model in found.values())
    for name, model in found.items():
        written = schema if name == "Case" else schema["$defs"][name]
        assert set(written["properties"]) == set(model.model_fields), name
        for key, field in model.model_fields.items():
            told = written["properties"][key].get("description", field.description)
            assert told == field.description, f"{name}.{key}"


def test_a_quantity_is_a_number_or_a_text_with_a_unit(schema: dict[str, Any]) -> None:
    ell = schema["$defs"]["DamageKeys"]["properties"]["ell"]
    assert ell["type"] == ["number", "string"]
    expansion = schema["$defs"]["MaterialKeys"]["properties"]["expansion"]
    assert "9e-6 1/K" in json.dumps(expansion)
    gamma = schema["$defs"]["DamageKeys"]["properties"]["gamma"]
    assert (gamma["type"], gamma["minimum"]) == ("number", 0)


@pytest.mark.parametrize("name", ready_case_names())
def test_a_case_becomes_json_with_its_quantities_as_they_were_given(name: str) -> None:
    case = ready_case(name)
    written = json.loads(case.model_dump_json())
    assert written["damage"]["ell"] == case.damage.ell.given
    assert set(written) == set(Case.model_fields)


GOOD = """
title = "small"
[domain]
size = [1.0, 1.0]
h = 0.1
[damage]
ell = 0.3
[temperature]
severity = 10.0
[time]
t = [0.1, 0.2]
"""


def complaints(table: dict[str, Any], schema: dict[str, Any]) -> list[str]:
    """Return the complaints of a validator that knows nothing of staffa, each with its key."""
    found = Draft202012Validator(schema).iter_errors(table)
    return [f"{error.json_path}: {error.message}" for error in found]


def test_the_command_prints_a_schema_of_its_dialect(schema: dict[str, Any]) -> None:
    printed = forked("schema")
    assert printed.returncode == 0, printed.stderr
    assert json.loads(printed.stdout) == schema
    Draft202012Validator.check_schema(schema)


def test_the_schema_is_the_same_in_another_process(schema: dict[str, Any]) -> None:
    """No name in it depends on where Python keeps its objects."""
    assert "0x" not in json.dumps(schema) and "Annotated" not in json.dumps(schema)


@pytest.mark.parametrize("name", ready_case_names())
def test_the_schema_takes_each_ready_case(name: str, schema: dict[str, Any]) -> None:
    assert complaints(tomllib.loads(text(name)), schema) == []
    resolved = tomllib.loads(to_toml(ready_case(name)))
    assert complaints(resolved, schema) == [], "as it is kept with a run"


def test_every_example_and_default_of_a_key_is_taken(schema: dict[str, Any]) -> None:
    count = 0
    for table in (schema, *schema["$defs"].values()):
        for name, key in table["properties"].items():
            for value in (
                *key.get("examples", []),
                *([key["default"]] if "default" in key else []),
            ):
                alone = {**key, "$defs": schema["$defs"]}
                assert complaints(value, alone) == [], f"{name} = {value}"
                count += 1
    assert count > 200, f"only {count}: does the test still see them?"


@pytest.mark.parametrize(
    ("setting", "key"),
    [
        ("domain.hh=0.1", "$.domain"),
        ('domain.h="abc"', "$.domain.h"),
        ('domain.h="5"', "$.domain.h"),
        ("domain.h=-0.1", "$.domain.h"),
        ("domain.size=[1.0]", "$.domain.size"),
        ('domain.cells="hexagon"', "$.domain.cells"),
        ('damage.law="AT3"', "$.damage.law"),
        ("damage.gamma=-1.0", "$.damage.gamma"),
        ("damage.allow_coarse=1", "$.damage.allow_coarse"),
        ("material.nu=0.6", "$.material.nu"),
        ("toughness.amplitude=1.0", "$.toughness.amplitude"),
        ('temperature.profile="warm"', "$.temperature.profile"),
        ("time.t=0.1", "$.time.t"),
        ("output.checkpoint={steps=0}", "$.output.checkpoint.steps"),
        ("output.checkpoint={hours=1}", "$.output.checkpoint"),
        ("solver.sweeps=1.5", "$.solver.sweeps"),
        ("solver.change=0.1", "$.solver.change"),
        ("cracks=[{start=[0.5,0.0]}]", "$.cracks[0]"),
        ("titel='x'", "$"),
    ],
)
def test_program_and_schema_refuse_the_same_key(
    setting: str, key: str, schema: dict[str, Any]
) -> None:
    table = tomllib.loads(GOOD)
    names, value = setting.split("=", 1)
    *path, last = names.split(".")
    inner = table
    for name in path:
        inner = inner.setdefault(name, {})
    inner[last] = tomllib.loads(f"value = {value}")["value"]
    assert complaints(tomllib.loads(GOOD), schema) == []
    assert any(said.startswith(f"{key}:") for said in complaints(table, schema))
    with pytest.raises(InputError, match=last):
        parse_case(GOOD, [setting])
