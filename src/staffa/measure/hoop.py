"""Damage that hoop tension drives: radial cracks, which no meridian plane contains."""

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import ufl
from dolfinx import fem

from staffa.backend import jit
from staffa.backend.parallel import max_over_ranks, sum_over_ranks
from staffa.model import axis
from staffa.model.domain import Domain
from staffa.model.energy import Energy

# Largest growth of the damage in a step that still counts as none.
LEAST = 0.01
# Two principal stresses are alike if they differ by less than this part.
ALIKE = 0.01
DEGREE = 2


class Hoop:
    """Share of a step's damage that grew where hoop tension is largest. Collective."""

    def __init__(self, domain: Domain, energy: Energy) -> None:
        """Compile the forms. Collective."""
        alpha = energy.state.alpha
        self._comm, self._alpha = domain.comm, alpha
        self._growth = fem.Function(alpha.function_space)
        s = energy.intact_stress
        middle, half = (s[0, 0] + s[1, 1]) / 2, (s[0, 0] - s[1, 1]) / 2
        largest = middle + ufl.sqrt(half**2 + s[0, 1] ** 2)
        around = s[2, 2]
        drives = ufl.And(ufl.gt(around, 0), ufl.ge(around, (1 - ALIKE) * largest))
        dx = axis.volume(domain, DEGREE)
        zero = 0 * around
        driven = ufl.conditional(drives, self._growth + zero, zero)
        self._grown = jit.form(self._growth * dx, domain.comm)
        self._driven = jit.form(driven * dx, domain.comm)

    def share(self, before: np.ndarray) -> float:
        """Return the share, 0 if no damage grew.

        Parameters
        ----------
        before : damage at the vertices at the start of the step, ghosts included, shape (n_local,).
        """
        growth = np.maximum(self._alpha.x.array - before, 0.0)
        if max_over_ranks(self._comm, growth) < LEAST:
            return 0.0
        self._growth.x.array[:] = growth
        grown, driven = (
            sum_over_ranks(self._comm, fem.assemble_scalar(form))
            for form in (self._grown, self._driven)
        )
        return float(driven / grown)
