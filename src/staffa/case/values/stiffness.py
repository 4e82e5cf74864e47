"""From the keys of a rock to its axes, its tensors and its elasticity."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from staffa.case.schema.material_keys import MaterialKeys, RockKeys, is_isotropic
from staffa.physics.elasticity import (
    Elasticity,
    Full,
    Isotropic,
    Orthotropic,
    Property,
    TransverselyIsotropic,
)
from staffa.properties.axes import turned_by, with_axis, with_third


def rock_axes(keys: RockKeys) -> np.ndarray:
    """Return the rock's axes as rows along x, y, z; with `axis` the third is across the bedding."""
    if keys.axis is not None:
        return with_axis(keys.axis)
    if keys.angle is not None:
        return turned_by(keys.angle)
    return np.eye(3) if keys.axes is None else with_third(keys.axes)


def tensor(keys: RockKeys, given: Sequence[float], third: float | None = None) -> np.ndarray:
    """Return a symmetric tensor in x, y, z from its values along the rock's axes, shape (3, 3).

    Parameters
    ----------
    keys : the rock, which gives its axes.
    given : two or three values; with `axis` two, along the bedding and across it.
    third : third value if it is left out (2-D); None for the mean of the others.
    """
    numbers = [float(g) for g in given]
    if keys.axis is not None:
        numbers = [numbers[0], numbers[0], numbers[1]]
    elif len(numbers) == 2:
        numbers.append(sum(numbers) / 2 if third is None else third)
    axes = rock_axes(keys)
    return np.asarray(axes.T @ np.diag(numbers) @ axes)


def structural_tensor(keys: RockKeys) -> np.ndarray | None:
    """Return the structural tensor A; None if Gc is no list.

    The toughness of a crack across n is Gc sqrt(n . A n), where Gc is the least of the given list.
    """
    if not isinstance(keys.Gc, tuple):
        return None
    least = float(min(keys.Gc))
    return tensor(keys, [(float(g) / least) ** 2 for g in keys.Gc], third=1.0)


def elasticity(keys: MaterialKeys, read: Callable[[Any], Property]) -> Elasticity:
    """Return the elasticity of a rock; read: makes a number or a function of each of its values."""
    axes = rock_axes(keys)
    if keys.stiffness is not None:
        return Full(C=np.array(keys.stiffness, dtype=float), axes=axes)
    if is_isotropic(keys):
        return Isotropic(E=read(keys.E), nu=read(keys.nu))
    if keys.E_axis is not None:
        return TransverselyIsotropic(
            E=read(keys.E),
            nu=read(keys.nu),
            E_axis=read(keys.E_axis),
            nu_axis=read(keys.nu_axis),
            G_axis=read(keys.G_axis),
            axes=axes,
        )
    assert isinstance(keys.E, tuple) and isinstance(keys.nu, tuple) and isinstance(keys.G, tuple)
    return Orthotropic(
        E=_three(keys.E, read, keys.E[-1]),
        nu=_three(keys.nu, read, 0.0),
        G=_three(keys.G, read, keys.G[-1]),
        axes=axes,
    )


def _three(
    given: Sequence[Any], read: Callable[[Any], Property], left_out: Any
) -> tuple[Property, Property, Property]:
    """Return a list of an orthotropic rock. In plane stress, where the third axis has no effect, E1
    and E2, nu12, and G12 are enough: that axis is then as stiff as the second, and nothing
    contracts it."""
    first, second, third = (read(value) for value in (*given, *[left_out] * (3 - len(given))))
    return first, second, third
