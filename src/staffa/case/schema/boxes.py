"""Boxes: parts of the body whose numbers differ from the rest."""

from collections.abc import Iterable

import numpy as np
from pydantic import Field

from staffa.case.schema.field_types import CaseTable, Position
from staffa.geometry.places import in_box


class Box(CaseTable):
    """A part of the body between two corners."""

    lower: tuple[Position, ...] = Field(description="lower corner", examples=[[0.0, 0.0]])
    upper: tuple[Position, ...] = Field(description="upper corner", examples=[[5.0, 0.02]])


def product(
    x: np.ndarray,
    boxes: Iterable[tuple[Box, float]],
    *,
    h: float,
    start: np.ndarray | float = 1.0,
) -> np.ndarray:
    """Return the product of the factors of all boxes around each point, shape (n,).

    Parameters
    ----------
    x : points (m), shape (3, n).
    boxes : each box with its factor.
    h : edge of the cells (m); see `in_box` for points on the sides.
    start : factor outside of all boxes, a number or one a point.
    """
    values = start * np.ones(x.shape[1])
    for box, factor in boxes:
        values[in_box(box.lower, box.upper, x, h=h)] *= factor
    return values
