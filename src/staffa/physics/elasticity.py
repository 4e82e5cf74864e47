"""Elasticity of every class as a stiffness: 6 x 6, in Voigt's order xx, yy, zz, yz, xz, xy."""

from typing import Protocol

import numpy as np


class Elasticity(Protocol):
    """How a rock answers strains, place by place."""

    def stiffness(self, x: np.ndarray) -> np.ndarray:
        """C (Pa) along x, y, z, at points x, shape (3, n): stress = C strain, with shear strains
        doubled; symmetric and positive definite; shape (n, 6, 6)."""
        ...
