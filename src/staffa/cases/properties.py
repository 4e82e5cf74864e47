"""From the value of a property, as keys, to a number or a function of position."""

from collections.abc import Callable
from typing import Any

import numpy as np

from staffa.cases.anisotropy import turned_by, with_third
from staffa.cases.formula import formula, names
from staffa.cases.kinds import Formula
from staffa.cases.property_keys import FieldFile, RandomField
from staffa.cases.random_field import random_factor
from staffa.physics.elasticity import PointFunction, Property, values


def point_property(value: Any, dim: int) -> Property:
    """What stands for a property, in SI or scaled as the case is.

    A field in a file is NaN where its mesh does not reach.
    """
    if isinstance(value, Formula):
        evaluated = formula(value.formula, names(dim, time=False))
        return lambda x: evaluated(x, 0.0)
    if isinstance(value, FieldFile):
        return value.field
    if isinstance(value, RandomField):
        mean, factor = float(value.mean), random_waves(value, dim)
        return lambda x: mean * factor(x)
    return float(value)


def random_waves(value: RandomField, dim: int) -> PointFunction:
    """A random field over its mean."""
    lengths = value.length if isinstance(value.length, tuple) else (value.length,) * dim
    axes = turned_by(value.angle) if value.angle is not None else np.eye(3)
    if value.axes is not None:
        axes = with_third(value.axes)
    return random_factor(
        value.distribution,
        value.variation,
        lengths=tuple(float(length) for length in lengths),
        axes=axes[:dim, :dim],
        seed=value.seed,
    )


def average(value: Any, dim: int, places: Callable[[], np.ndarray]) -> float:
    """The one number that stands for a property: its mean; of formulas and files over places."""
    if isinstance(value, RandomField):
        return float(value.mean)
    found = point_property(value, dim)
    return float(np.mean(found(places()))) if callable(found) else found


def product_of(one: Property, other: Property) -> Property:
    """The product of two properties."""
    if not callable(one) and not callable(other):
        return one * other
    return lambda x: values(one, x) * values(other, x)
