"""The ready cases that come with staffa."""

from collections.abc import Sequence
from importlib.resources import files

from staffa.arguments import require
from staffa.case.reading.read import parse_case
from staffa.case.schema.case import Case
from staffa.errors import InputError, choices


def ready_case_names() -> tuple[str, ...]:
    """Return the names of the ready cases."""
    folder = files("staffa.case.ready")
    return tuple(
        sorted(f.name.removesuffix(".toml") for f in folder.iterdir() if f.name.endswith(".toml"))
    )


def text(name: str) -> str:
    """Return the file of a ready case, with the sources of its numbers in its comments.

    Raises
    ------
    InputError
        There is no such case.
    """
    require(name, str, "name", 'give the name of a ready case, like "slab"')
    if name not in ready_case_names():
        raise InputError(f"staffa has no case '{name}'; {choices(name, ready_case_names())}")
    return (files("staffa.case.ready") / f"{name}.toml").read_text(encoding="utf-8")


def ready_case(name: str, settings: Sequence[str] = ()) -> Case:
    """Return a ready case, with `section.key=value` settings put over it."""
    return parse_case(text(name), settings, name=name)
