"""Perpendicular unit axes, as rows along x, y, z, from what a case says of directions."""

from collections.abc import Sequence

import numpy as np


def turned_by(angle: float) -> np.ndarray:
    """Return axes turned about z, from x to y, by an angle in degrees."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def with_third(axes: Sequence[Sequence[float]]) -> np.ndarray:
    """Return unit axes from the first two, which are perpendicular and of any length."""
    first, second = (np.array(a, dtype=float) / np.linalg.norm(a) for a in axes)
    return np.array([first, second, np.cross(first, second)])


def with_axis(axis: Sequence[float]) -> np.ndarray:
    """Return unit axes whose third is this one; of a 2-D body the first lies in its plane."""
    third = np.zeros(3)
    third[: len(axis)] = axis
    third /= np.linalg.norm(third)
    aside = np.zeros(3)
    aside[2 if len(axis) == 2 else int(np.argmin(np.abs(third)))] = 1.0
    first = np.cross(third, aside)
    first /= np.linalg.norm(first)
    return np.array([first, np.cross(third, first), third])
