"""Boxes: parts of the body whose numbers differ from the rest."""

from collections.abc import Iterable

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
        bounds = zip(x, box.lower, box.upper, strict=False)
        inside = np.all([(c >= low) & (c <= high) for c, low, high in bounds], axis=0)
        values[inside] *= factor
    return values
