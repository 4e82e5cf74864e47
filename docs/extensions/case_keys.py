"""The keys of a case as Markdown, from the models and their JSON schema.

Each table of a case is a section, and each kind of table within it one below. Kinds that differ in
the unit of one key alone, such as random fields of moduli and of toughnesses, are one.
"""

import re
from collections import defaultdict
from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

from staffa.case.reading.messages import models_in
from staffa.case.schema.case import Case
from staffa.case.schema.field_types import CaseTable, SidesTable
from staffa.case.schema.material_keys import RegionKeys, RockKeys
from staffa.case.schema.toml_text import inline
from staffa.units import EXAMPLES

type Node = dict[str, Any]
type Model = type[BaseModel]

ALIKE = 3  # models of one base, from which on they are one section
SAID = {
    "exclusiveMinimum": "larger than {}",
    "minimum": "at least {}",
    "exclusiveMaximum": "less than {}",
    "maximum": "at most {}",
    "minItems": "at least {} entries",
    "maxItems": "at most {} entries",
    "maxLength": "at most {} characters",
}
TYPES = {"boolean": "true or false", "integer": "whole number", "number": "number"}
TYPES |= {"string": "text", "object": "table"}


class Keys:
    """The models of a case in the order of its tables, with what is to be said of each."""

    def __init__(self) -> None:
        self.schema = Case.model_json_schema()
        self.users: dict[Model, list[str]] = defaultdict(list)
        self._walk(Case, "")
        self.groups, self.bases = dict[Model, Model](), dict[Model, Model]()
        self._group()

    def _walk(self, model: Model, path: str) -> None:
        for name, field in model.model_fields.items():
            place = f"{path}.{name}".strip(".")
            for inner in dict.fromkeys(models_in(field.annotation)):
                first = inner not in self.users
                self.users[inner].append(place)
                if first:
                    self._walk(inner, place)

    def _group(self) -> None:
        """Find for each model the one that is shown in its place, and the one that names both."""
        families = defaultdict(list)
        for model in self.users:
            base = model.__mro__[1]
            alone = base in (CaseTable, SidesTable)
            families[model if alone else base, tuple(model.model_fields)].append(model)
        for (base, _), family in families.items():
            for model in family:
                alike = len(family) >= ALIKE
                self.groups[model] = family[0] if alike else model
                self.bases[model] = base if alike else model

    def family(self, model: Model) -> list[Model]:
        """Return the models that one section is about."""
        return [one for one, shown in self.groups.items() if shown is model]

    def properties(self, model: Model) -> dict[str, Node]:
        """Return the keys of a model, as the JSON schema has them."""
        found: dict[str, Node] = self.schema["$defs"][model.__name__]["properties"]
        return found

    def node_of(self, model: Model) -> Node:
        """Return the JSON schema of a model."""
        found: Node = self.schema if model is Case else self.schema["$defs"][model.__name__]
        return found

    def title(self, model: Model) -> str:
        """Return the heading of a kind of table: what its docstring says first."""
        text = " ".join((self.bases[model].__doc__ or model.__name__).split())
        return re.split(r"[.:;](?: |$)|, | \(docs/", text)[0]

    def kind(self, node: Node) -> str:
        """Return the type of a key in words, with its unit, and links to tables."""
        if "$ref" in node:
            name = node["$ref"].removeprefix("#/$defs/")
            model = next(one for one in self.users if one.__name__ == name)
            title = self.title(model)
            return f"table [{title[0].lower() + title[1:]}](#{anchor(self.groups[model])})"
        for name in ("oneOf", "anyOf"):
            if name in node:
                return ", or ".join(dict.fromkeys(self.kind(one) for one in node[name]))
        if "x-dimensions" in node:
            told = (f"{name} ({unit(si)})" for name, si in node["x-dimensions"].items())
            return " or ".join(told)
        if "enum" in node or "const" in node:
            return ", ".join(f"`{inline(one)}`" for one in node.get("enum", [node.get("const")]))
        if node.get("type") == "array":
            entries = node.get("prefixItems") or [node["items"]]
            return f"list of: {'; '.join(dict.fromkeys(self.kind(one) for one in entries))}"
        inner = node.get("additionalProperties")
        if isinstance(inner, dict):
            return f"tables by name: {self.kind(inner)}"
        return TYPES[node["type"]]

    def rules(self, node: Node) -> list[str]:
        """Return the bounds of a key in words."""
        found = [said.format(node[name]) for name, said in SAID.items() if name in node]
        for one in node.get("prefixItems") or ([node["items"]] if "items" in node else []):
            found += [f"each {rule}" for rule in self.rules(one)]
        for one in (*node.get("oneOf", ()), *node.get("anyOf", ())):
            found += self.rules(one)
        return list(dict.fromkeys(found))


def anchor(model: Model) -> str:
    """Return the name by which pages link to a kind of table."""
    return f"keys-{model.__name__.lower()}"


def unit(si: str) -> str:
    """Return a unit as readers write it."""
    return si.replace("**", "^").replace("*", " ")


def words(text: str) -> str:
    """Return a description as Markdown: tables in braces as code, pages of this site as links."""
    text = " ".join(text.split())
    parts = re.split(r"(`[^`]*`|\{[^{}]*\}|\[[\w.]+\])", text)
    shown = []
    for index, part in enumerate(parts):
        if index % 2:
            shown.append(part if part.startswith("`") else f"`{part}`")
        else:
            shown.append(re.sub(r"([*_<>$\\])", r"\\\1", part))
    return re.sub(r"docs/([\w/-]+)/([\w-]+)\.md", r"[\2](../\1/\2.md)", "".join(shown))


def keys_page() -> str:
    """Return the reference of all keys, a section for each table of a case."""
    keys, shown = Keys(), set[Model]()
    lines = ["## At the top", "", *_key(keys, Case, "title", "title")]
    for name, field in Case.model_fields.items():
        models = models_in(field.annotation)
        if not models:
            continue
        tables = {"regions": "[regions.NAME]", "cracks": "[[cracks]]"}.get(name, f"[{name}]")
        lines += [f"(keys-{name})=", f"## `{tables}`", ""]
        if len(models) == 1:
            lines += _table(keys, models[0], "regions.NAME" if name == "regions" else name)
        else:
            lines += [words(field.description or ""), ""]
        below = [model for model in _below(keys, models) if keys.groups[model] is model]
        for model in below if len(models) == 1 else [*models, *below]:
            if model not in shown:
                shown.add(model)
                lines += _nested(keys, model)
    return "\n".join(lines)


def _below(keys: Keys, models: list[Model]) -> Iterator[Model]:
    """Yield the models that tables may hold, in the order in which they are met."""
    for model in models:
        for field in model.model_fields.values():
            inner = [keys.groups[one] for one in dict.fromkeys(models_in(field.annotation))]
            yield from inner
            yield from _below(keys, inner)


def _table(keys: Keys, model: Model, path: str) -> Iterator[str]:
    yield from [words(model.__doc__ or ""), ""]
    own = set(keys.properties(model))
    if model is RegionKeys:
        own -= set(RockKeys.model_fields)
        rock = ", ".join(f"`{name}`" for name in RockKeys.model_fields)
        yield from [f"It takes these keys of [`[material]`](#keys-material): {rock}.", ""]
    for name in keys.properties(model):
        if name not in own:
            continue
        yield from _key(keys, model, name, f"{path}.{name}")


def _nested(keys: Keys, model: Model) -> Iterator[str]:
    """Yield the section of a kind of table that stands within others."""
    family = keys.family(model)
    users = dict.fromkeys(place for one in family for place in keys.users[one])
    text = keys.bases[model].__doc__ or ""
    yield from [f"({anchor(model)})=", f"### {words(keys.title(model))}", "", words(text), ""]
    yield from [f"Stands in {', '.join(f'`{place}`' for place in users)}.", ""]
    for name, node in keys.properties(model).items():
        differ = len({keys.kind(keys.properties(one)[name]) for one in family}) > 1
        kind = "as of the key in which it stands" if differ else keys.kind(node)
        said = [_first(keys, model, name, kind), *_more(keys, name, node)]
        yield from [f"`{name}`", ": " + "\\\n  ".join(line for line in said if line), ""]


def _key(keys: Keys, model: Model, name: str, path: str) -> Iterator[str]:
    """Yield a key of a table of the case, as an entry that can be linked and searched."""
    node = keys.node_of(model)["properties"][name]
    yield from [f":::{{confval}} {path}", _first(keys, model, name, keys.kind(node)), ""]
    for line in _more(keys, name, node):
        yield from [line, ""]
    yield from [":::", ""]


def _first(keys: Keys, model: Model, name: str, kind: str) -> str:
    """Return the first line on a key: its type and its default."""
    node = keys.node_of(model)["properties"][name]
    default = "needed" if name in keys.node_of(model).get("required", []) else "may be left out"
    if "default" in node:
        default = f"default `{inline(node['default'])}`"
    return f"*Type:* {kind}; {default}."


def _more(keys: Keys, name: str, node: Node) -> Iterator[str]:
    """Yield the meaning of a key, its rules, and its examples, one of them with a unit."""
    yield words(node.get("description", ""))
    if rules := keys.rules(node):
        yield f"*Rule:* {', '.join(rules)}."
    examples = [f"`{name} = {inline(value)}`" for value in node.get("examples", [])]
    scaled = not any(isinstance(value, str) for value in node.get("examples", []))
    if scaled and "x-dimensions" in node:
        examples += [f"`{name} = {inline(EXAMPLES[one])}`" for one in node["x-dimensions"]]
    if examples:
        yield f"*Example:* {', '.join(examples)}."
