"""The JSON schema of a case has every key of every table, for programs that write cases."""

import json
import warnings
from collections.abc import Iterator
from typing import Any

import pytest
from pydantic import BaseModel

from staffa.case.reading.messages import _models_in
from staffa.case.reading.ready_cases import ready_case, ready_case_names
from staffa.case.schema.case import Case
from staffa.case.schema.field_types import CaseTable

KEYWORDS = {
    *("$defs", "$ref", "additionalProperties", "anyOf", "const", "default", "description", "enum"),
    *("examples", "exclusiveMaximum", "exclusiveMinimum", "items", "maxItems", "maxLength"),
    *("maximum", "minItems", "minLength", "minimum", "oneOf", "prefixItems", "properties"),
    *("required", "title", "type"),
}
TYPES = {"object", "array", "string", "number", "integer", "boolean", "null"}


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
            for inner in _models_in(field.annotation):
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
    assert gamma["anyOf"][0] == {"type": "number", "minimum": 0}


@pytest.mark.parametrize("name", ready_case_names())
def test_a_case_becomes_json_with_its_quantities_as_they_were_given(name: str) -> None:
    case = ready_case(name)
    written = json.loads(case.model_dump_json())
    assert written["damage"]["ell"] == case.damage.ell.given
    assert set(written) == set(Case.model_fields)
