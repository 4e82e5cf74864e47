"""Elasticity of every class as a stiffness: 6 x 6, in Voigt's order xx, yy, zz, yz, xz, xy."""

from typing import Any, Protocol

import numpy as np


class Elasticity(Protocol):
    """How a rock answers strains, place by place."""

    def stiffness(self, x: np.ndarray) -> np.ndarray:
        """C (Pa) along x, y, z, at points x, shape (3, n): stress = C strain, with shear strains
        doubled; symmetric and positive definite; shape (n, 6, 6)."""
        ...


class Isotropic:
    """E (Pa) and nu, each a number or one at each point."""

    def __init__(self, *, E: Any, nu: Any) -> None:
        self.E, self.nu = E, nu

    def stiffness(self, x: np.ndarray) -> np.ndarray:
        """See `Elasticity`."""
        E, nu = (
            np.broadcast_to(v(x) if callable(v) else v, x.shape[1:]) for v in (self.E, self.nu)
        )
        S = np.zeros((x.shape[1], 6, 6))
        for i in range(3):
            S[:, i, i], S[:, 3 + i, 3 + i] = 1 / E, 2 * (1 + nu) / E
            for j in range(3):
                if i != j:
                    S[:, i, j] = -nu / E
        return np.linalg.inv(S)
