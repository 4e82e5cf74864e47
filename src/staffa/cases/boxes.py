"""Boxes: parts of the body whose numbers differ from the rest."""

from collections.abc import Iterable, Sequence

import numpy as np
from pydantic import Field

from staffa.cases.kinds import Position, Section


class Box(Section):
    """A part of the body between two corners."""

    lower: tuple[Position, ...] = Field(description="lower corner", examples=[[0.0, 0.0]])
    upper: tuple[Position, ...] = Field(description="upper corner", examples=[[5.0, 0.02]])


def product(
    x: np.ndarray, boxes: Iterable[tuple[Box, float]], start: np.ndarray | float = 1.0
) -> np.ndarray:
    """At the points x, shape (3, n): `start` times the factors of all boxes around each."""
    values = start * np.ones(x.shape[1])
    for box, factor in boxes:
        values[inside(box.lower, box.upper, x)] *= factor
    return values


def inside(lower: Sequence[float], upper: Sequence[float], x: np.ndarray) -> np.ndarray:
    """Whether points x, shape (3, n), lie between two corners: shape (n,)."""
    bounds = zip(x, lower, upper, strict=False)
    return np.all([(c >= low) & (c <= high) for c, low, high in bounds], axis=0)
