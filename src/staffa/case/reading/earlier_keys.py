"""Keys that version 0.1.0 called otherwise: translated in a run directory, refused in a case."""

from typing import Any

from staffa.case.schema.toml_text import inline
from staffa.errors import InputError

# Values of `output.fields` of 0.1.0, which is `output.steps` now.
STEPS = ("requested", "all")


def translate(table: dict[str, Any]) -> None:
    """Give the keys of a run of 0.1.0 the names that they have now.

    Parameters
    ----------
    table : case as TOML holds it, changed in place.
    """
    output = table.get("output")
    if isinstance(output, dict) and output.get("fields") in STEPS:
        output["steps"] = output.pop("fields")


def refuse(table: dict[str, Any]) -> None:
    """Refuse keys that are called otherwise now.

    Raises
    ------
    InputError
        With the name that the key has now.
    """
    output = table.get("output")
    if isinstance(output, dict) and output.get("fields") in STEPS:
        value = inline(output["fields"])
        raise InputError(
            f"output.fields = {value}: this key is called output.steps now; write steps = {value}, "
            f'or list the fields to keep, like fields = ["u", "alpha", "T"]'
        )
