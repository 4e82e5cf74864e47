"""What a verification measures: figures beside what they should be."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A number beside what it should be; the tolerance is absolute, or a fraction of it."""

    what: str
    source: str
    reference: float
    measured: float
    tolerance: float
    relative: bool = False

    @property
    def met(self) -> bool:
        """Whether it is within the tolerance."""
        scale = abs(self.reference) if self.relative else 1.0
        return bool(abs(self.measured - self.reference) <= self.tolerance * scale)


@dataclass(frozen=True, kw_only=True)
class Found:
    """Figures, and what else stands on the page below them (Markdown)."""

    figures: list[Figure]
    text: str


@dataclass(frozen=True, kw_only=True)
class Check:
    """A title, a text for the page, and what measures the figures."""

    title: str
    text: str
    measure: Callable[[], "list[Figure] | Found"]
