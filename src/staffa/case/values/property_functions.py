"""From the value of a property, as keys, to a number or a function of position."""

from collections.abc import Callable
from functools import partial
from typing import Any

from staffa.case.schema.field_types import CaseTable
from staffa.case.schema.property_keys import RandomField
from staffa.geometry.places import Sample
from staffa.physics.elasticity import PointFunction, Property, values


def varies(value: Any) -> bool:
    """Return whether a property varies in space, that is, whether it is a table."""
    return isinstance(value, CaseTable)


def point_property(value: Any, dim: int) -> Property:
    """Return a property as a number or a function of position, in SI or scaled as the case is."""
    return value.at_points(dim) if varies(value) else float(value)


def in_space(value: Any, dim: int) -> PointFunction:
    """Return the same as a function of points, where it is one number too."""
    return partial(values, point_property(value, dim))


def mean_value(value: Any, dim: int, places: Callable[[], Sample]) -> float:
    """Return the mean of a property, over places if it is not known otherwise.

    Parameters
    ----------
    value : the property as the case gives it.
    dim : dimension of the body.
    places : returns the places over which the mean is taken.
    """
    if isinstance(value, RandomField):
        return float(value.mean)
    found = point_property(value, dim)
    if not callable(found):
        return found
    there = places()
    return there.mean(found(there.x))


def product_of(one: Property, other: Property) -> Property:
    """Return the product of two properties."""
    if not callable(one) and not callable(other):
        return one * other
    return lambda x: values(one, x) * values(other, x)
