"""The part of what drove a step's damage that a safe split would have kept, in pressed rock."""

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

# The driving energy without a split may exceed that of a safe one by this part of the latter.
EXCESS_ALLOWED = 0.05
# Damage that grew by less nowhere did not grow: round-off, and the thin tails of AT2.
GROWTH = 0.01
# Energies of two cells that are equal but for round-off.
EQUAL = 1e-6


@dataclass(frozen=True, kw_only=True)
class Driven:
    """Energies that drove damage in a step (J/m in 2-D, J in 3-D): without a split, and under the
    safe one. place: of the largest difference, in words."""

    whole: float
    safe: float
    place: str

    @property
    def excess(self) -> float:
        """The part by which the one exceeds the other."""
        return self.whole / self.safe - 1 if self.safe else (np.inf if self.whole > 0 else 0.0)


def safest_of(mesh: Mesh, rock: IsotropicRock | AnisotropicRock) -> EnergySplit:
    """The split of a rock under which pressure breaks the least. Collective.

    mesh: that of the rock, whose nu may depend on temperature.
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
    """Compares what drove damage without a split with what drives it under the safest one.

    With a(alpha) psi the elastic energy density, growth of the damage by d releases -a' psi d, and
    under the safe split -a' (psi - psi_-) d. Everything is collective.
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
        """A sentence where the driving energy exceeds that of the safe split by more than 5 %.

        before: damage at the vertices at the end of the step before, ghosts included.
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
        """The energies that drove damage since `before`; None if it grew nowhere."""
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
        """The place of the cell in which the most energy exceeds, shape (n_cells,), in words; of
        equal ones the same on any partition."""
        most = max_over_ranks(self.comm, excess)
        places = self._middles[excess >= (1 - EQUAL) * most, : self._mesh.geometry.dim]
        first = min(places.round(12).tolist(), default=None)
        best = best_candidate(self.comm, None if first is None else tuple(-x for x in first))
        assert best is not None
        return f"({', '.join(f'{0.0 - x:.4g}' for x in best)})"
