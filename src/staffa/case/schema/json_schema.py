"""The JSON schema of a table of the case file, as editors of TOML understand it."""

from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaMode
from pydantic_core import CoreSchema
from pydantic_core.core_schema import no_info_after_validator_function

# How JSON schemas call bounds that Pydantic leaves by its own names.
BOUNDS = {"ge": "minimum", "gt": "exclusiveMinimum", "le": "maximum", "lt": "exclusiveMaximum"}
NONE = {"type": "null"}  # TOML has no such value


class Rule:
    """A rule that a value keeps, and what the JSON schema says of it.

    Parameters
    ----------
    check : takes a value and returns it; ValueError if it breaks the rule.
    told : keywords of the JSON schema, such as `minimum`.
    """

    def __init__(self, check: Any, **told: Any) -> None:
        self._check, self._told = check, told

    def __get_pydantic_core_schema__(
        self, source: Any, handler: GetCoreSchemaHandler
    ) -> CoreSchema:
        """Apply the rule after the value has been read."""
        return no_info_after_validator_function(self._check, handler(source))

    def __get_pydantic_json_schema__(
        self, schema: CoreSchema, handler: GetJsonSchemaHandler
    ) -> dict[str, Any]:
        """Return the schema of the value, with the rule."""
        return {**handler(schema), **self._told}


class Schema(GenerateJsonSchema):
    """The JSON schema of a table: bounds by their names there, one definition a table."""

    def generate_inner(self, schema: Any) -> dict[str, Any]:
        """See `GenerateJsonSchema`."""
        found = super().generate_inner(schema)
        return {BOUNDS.get(name, name): value for name, value in found.items()}

    def generate(self, schema: Any, mode: JsonSchemaMode = "validation") -> dict[str, Any]:
        """See `GenerateJsonSchema`."""
        found = super().generate(schema, mode)
        kinds = found.get("$defs", {})
        tables = {name: kind for name, kind in kinds.items() if "properties" in kind}
        plain = {name: _plain(part, kinds) for name, part in {**found, "$defs": tables}.items()}
        return {"$schema": self.schema_dialect, **plain}


def _plain(node: Any, kinds: dict[str, Any]) -> Any:
    """Return a part of a schema without null, and with kinds of values in place of their names.

    The names of these kinds hold addresses, so that they differ from one process to the next.
    """
    if isinstance(node, list):
        return [_plain(part, kinds) for part in node]
    if not isinstance(node, dict):
        return node
    name = str(node.get("$ref", "")).removeprefix("#/$defs/")
    if name in kinds and "properties" not in kinds[name]:
        rest = {key: value for key, value in node.items() if key != "$ref"}
        return _plain({**kinds[name], **rest}, kinds)
    found = {
        key: _plain(part, kinds)
        for key, part in node.items()
        if part is not None and not (key == "title" and isinstance(part, str))
    }
    return _one_of_one({key: _without_null(part) for key, part in found.items()})


def _without_null(part: Any) -> Any:
    return [one for one in part if one != NONE] if isinstance(part, list) else part


def _one_of_one(node: dict[str, Any]) -> dict[str, Any]:
    """Return a choice among one as that one."""
    choice = node.get("anyOf")
    if isinstance(choice, list) and len(choice) == 1:
        return {**choice[0], **{key: part for key, part in node.items() if key != "anyOf"}}
    return node
