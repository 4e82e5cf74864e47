"""Figures of a verification, beside their expected values."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A number beside what it should be; the tolerance is absolute, or a fraction of it.

    bound: the reference is the least, or the most, that it should be.
    """

    what: str
    source: str
    reference: float
    measured: float
    tolerance: float
    relative: bool = False
    bound: Literal["least", "most"] | None = None

    @property
    def met(self) -> bool:
        """True if it is within the tolerance."""
        scale = abs(self.reference) if self.relative else 1.0
        over = self.measured - self.reference
        off = {None: abs(over), "least": -over, "most": over}[self.bound]
        return bool(off <= self.tolerance * scale)


@dataclass(frozen=True, kw_only=True)
class Found:
    """Figures, and what else stands on the page below them (Markdown)."""

    figures: list[Figure]
    text: str


@dataclass(frozen=True, kw_only=True)
class Check:
    """A title, a text for the page, and what measures the figures.

    kept: file or folder beside `run.py` that holds its runs, too long for each `make verify`.
    """

    title: str
    text: str
    measure: Callable[[], "list[Figure] | Found"]
    kept: str | None = None
