"""Growth of damage in compression: the part of its driving energy that a safe split would keep."""

from dataclasses import dataclass

from staffa.backend.stack import MPI  # noqa: F401

import basix
import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import Mesh, compute_midpoints

from staffa.backend import jit
from staffa.backend.parallel import best_candidate, max_over_ranks, sum_over_ranks
from staffa.model.energy import Energy
from staffa.model.strain import AnisotropicRock, IsotropicRock
from staffa.physics.split import NO_SPLIT, SPLITS, EnergySplit, driven_density

# Largest excess of the driving energy without a split over that of a safe one, over the latter.
EXCESS_ALLOWED = 0.05
# Growth of the damage up to which there is none: round-off, and the thin tails of AT2.
GROWTH = 0.01
# Relative difference of two cells' energies that are equal within round-off.
EQUAL = 1e-6


@dataclass(frozen=True, kw_only=True)
class Driven:
    """Energies that drove damage in a step (J; J/m in 2-D).

    Attributes
    ----------
    whole : without a split.
    safe : with the safe split.
    place : position of the largest difference, as text.
    """

    whole: float
    safe: float
    place: str

    @property
    def excess(self) -> float:
        """Relative excess of the first over the second."""
        return self.whole / self.safe - 1 if self.safe else (np.inf if self.whole > 0 else 0.0)


def safest_of(mesh: Mesh, rock: IsotropicRock | AnisotropicRock) -> EnergySplit:
    """Return the split under which a rock breaks least in compression. Collective.

    Parameters
    ----------
    mesh : mesh of the rock, whose nu may depend on temperature.
    rock : the elastic law.
    """
    if isinstance(rock, IsotropicRock):
        dim = mesh.topology.dim
        cells = np.arange(mesh.topology.index_map(dim).size_local, dtype=np.int32)
        middle = basix.geometry(mesh.basix_cell()).mean(axis=0)[None, :]
        nu = jit.expression(rock.nu, middle, mesh.comm).eval(mesh, cells)
        if -max_over_ranks(mesh.comm, -nu) >= 0:
            return SPLITS["no-tension"]
    return SPLITS["volumetric-deviatoric"]


class PressedGrowth:
    """Comparison of the energy that drove damage without a split with that under the safest split.

    With a(alpha) psi the elastic energy density, growth of the damage by d releases -a' psi d, and
    under the safe split -a' (psi - psi_-) d. All methods are collective.
    """

    def __init__(self, energy: Energy) -> None:
        alpha = energy.state.alpha
        self.comm, self._mesh = energy.comm, alpha.function_space.mesh
        self.safe = safest_of(self._mesh, energy.elasticity)
        self._alpha, self._grown = alpha, fem.Function(alpha.function_space)
        damage = ufl.variable(alpha)
        fall = -ufl.diff(energy.law.a(damage), damage)
        e = energy.strained()
        driving = [fall * driven_density(split, e) for split in (NO_SPLIT, self.safe)]
        cell = self._mesh.basix_cell()
        middle = basix.geometry(cell).mean(axis=0)[None, :]
        values = ufl.as_vector([self._grown, *driving])
        self._values = jit.expression(values, middle, self.comm)
        dim = self._mesh.topology.dim
        count = self._mesh.topology.index_map(dim).size_local
        self._cells = np.arange(count, dtype=np.int32)
        self._middles = compute_midpoints(self._mesh, dim, self._cells)
        constants = fem.functionspace(self._mesh, ("Discontinuous Lagrange", 0))
        sizes = jit.form(ufl.TestFunction(constants) * ufl.dx(self._mesh), self.comm)
        self._sizes = fem.assemble_vector(sizes).array[:count]

    def said(self, before: np.ndarray) -> tuple[str, ...]:
        """Return a message if the driving energy exceeds that of the safe split by more than 5 %.

        Parameters
        ----------
        before : damage at the vertices after the step before, ghosts included, shape (n_local,).
        """
        driven = self.driven(before)
        if driven is None or driven.excess <= EXCESS_ALLOWED:
            return ()
        share = f"{100 * (1 - driven.safe / driven.whole):.0f} %"
        return (
            f"pressed rock: {share} of the energy that drove damage in this step would not under "
            f'the split "{self.safe.name}", most of it at {driven.place}; where pressed rock must '
            f'not break, take damage.split = "{self.safe.name}"',
        )

    def driven(self, before: np.ndarray) -> Driven | None:
        """Return the energies that drove damage since `before`; None if it did not grow."""
        self._grown.x.array[:] = np.maximum(self._alpha.x.array - before, 0.0)
        if max_over_ranks(self.comm, self._grown.x.array) < GROWTH:
            return None
        found = self._values.eval(self._mesh, self._cells).reshape(len(self._cells), 3).T
        released, safely = found[1:] * found[0] * self._sizes
        whole, safe = sum_over_ranks(self.comm, np.array([released.sum(), safely.sum()]))
        return Driven(
            whole=float(whole), safe=max(float(safe), 0.0), place=self._worst(released - safely)
        )

    def _worst(self, excess: np.ndarray) -> str:
        """Return the position of the cell with the largest excess, shape (n_cells,), as text.

        Of equal cells it is the same on any partition.
        """
        most = max_over_ranks(self.comm, excess)
        places = self._middles[excess >= (1 - EQUAL) * most, : self._mesh.geometry.dim]
        first = min(places.round(12).tolist(), default=None)
        best = best_candidate(self.comm, None if first is None else tuple(-x for x in first))
        assert best is not None
        return f"({', '.join(f'{0.0 - x:.4g}' for x in best)})"
