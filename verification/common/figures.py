"""Figures of a verification, beside their expected values."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A number beside what it should be; the tolerance is absolute, or a fraction of it.

    bound: the reference is the least, or the most, that it should be. before: a reference that the
    figure had before, of the same tolerance, and its source: it stays beside the other.
    """

    what: str
    source: str
    reference: float
    measured: float
    tolerance: float
    relative: bool = False
    bound: Literal["least", "most"] | None = None
    before: tuple[float, str] | None = None

    @property
    def met(self) -> bool:
        """True if it is within the tolerance."""
        return self._within(self.reference)

    @property
    def met_before(self) -> bool:
        """True if it is within the tolerance of the reference before, or never had another."""
        return self.before is None or self._within(self.before[0])

    def _within(self, reference: float) -> bool:
        scale = abs(reference) if self.relative else 1.0
        over = self.measured - reference
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
