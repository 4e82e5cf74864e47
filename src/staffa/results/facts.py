"""A row of a summary."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Fact:
    """Row of a summary.

    Attributes
    ----------
    name : its name.
    text : its value.
    alarm : True if something is wrong.
    """

    name: str
    text: str
    alarm: bool = False
