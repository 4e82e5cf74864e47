"""Test of a mesh that may be refined: is it fine enough for the state on it?"""

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np

from staffa.backend.parallel import any_over_ranks, max_over_ranks, sum_over_ranks
from staffa.backend.vectors import readable
from staffa.evolution.problem import Problem
from staffa.minimize.bounded import BoundedEnergy
from staffa.model.domain import local_edges
from staffa.model.fields import State
from staffa.model.refinement import Wanted, too_coarse
from staffa.physics.damage import has_threshold

# Damage above which no cell may be coarse. Without a threshold there is some damage everywhere:
# then another damage decides, and its slope (in 1/ell).
DAMAGED, SOFT, STEEP = 0.01, 0.1, 0.05
# Part of the coarse cells up to which damage is that of cracks.
FEW = 0.2
# Change of temperature over a cell, over the allowed one, at which it is halved twice.
MUCH = 4.0
# Of the drive at which cells are split: where some are, those above this part of it are split too.
NEAR = 0.7


class TooCoarseError(Exception):
    """A state has come to cells that are too coarse for it; raised on all ranks together.

    Attributes
    ----------
    wanted : what the cells of this rank should become.
    """

    def __init__(self, wanted: Wanted) -> None:
        super().__init__("the mesh is too coarse for the state on it")
        self.wanted = wanted


class Resolution:
    """The test whether every cell is fine enough for a state. All of it is collective."""

    def __init__(self, problem: Problem, state: State, damage: BoundedEnergy) -> None:
        """Find the coarse cells of the mesh.

        Parameters
        ----------
        problem : the problem, with rules of refinement, on a mesh that may be refined.
        state : its state.
        damage : its energy as a function of the damage, at that state.
        """
        domain, rules = problem.domain, problem.refinement
        assert domain.source is not None
        assert rules is not None
        self._comm, self._rules, self._state, self._damage = domain.comm, rules, state, damage
        self._ell, self._threshold = problem.material.ell, has_threshold(problem.material.law)
        self._edges, self._finest = local_edges(domain), domain.source.finest
        self._coarse = np.flatnonzero(too_coarse(self._edges, self._finest))
        self._all_corners = state.alpha.function_space.dofmap.list[: len(self._edges)]
        self._corners = self._all_corners[self._coarse]
        geometry = domain.mesh.geometry
        x = geometry.x[geometry.dofmaps[0][self._coarse], : domain.dim]
        self._frame = np.linalg.inv(x[:, 1:] - x[:, :1])
        self._force = damage.unit.duplicate()

    def destroy(self) -> None:
        """Free the PETSc objects."""
        self._force.destroy()

    def worst(self) -> float:
        """Return the largest damage in a coarse cell; 0 where there is no such cell."""
        return max(0.0, max_over_ranks(self._comm, self._state.alpha.x.array[self._corners]))

    def require(self) -> None:
        """Require that no coarse cell has too much damage, drive or change of temperature.

        Raises
        ------
        TooCoarseError
            Cells must be split.
        """
        uneven = self._uneven()
        if any_over_ranks(self._comm, bool((uneven > 1).any())):
            raise TooCoarseError(self._wanted(uneven))
        self._require_of(self._damaged())  # at a temperature that is resolved

    def require_at_cracks(self) -> None:
        """Require that no crack is in coarse cells.

        While a body is evenly damaged, before cracks part from it, nothing is known yet.

        Raises
        ------
        TooCoarseError
            Cells must be split.
        """
        damaged = self._damaged()
        if self._at_few_places(damaged):
            self._require_of(damaged)

    def _require_of(self, damaged: np.ndarray) -> None:
        """Require that no coarse cell is damaged, or driven too much."""
        drive, most = self._drive(), self._rules.drive
        if any_over_ranks(self._comm, bool((damaged | (drive > most)).any())):
            wanted = self._wanted(np.where(drive > NEAR * most, 2.0, 1.0))
            wanted.edge[self._coarse[damaged | (drive > 1)]] = self._finest
            alpha = self._state.alpha.x.array[self._all_corners].max(axis=1, initial=0.0)
            wanted.around[:] = alpha > (DAMAGED if self._threshold else SOFT)
            raise TooCoarseError(wanted)

    def _at_few_places(self, damaged: np.ndarray) -> bool:
        """Return True if some coarse cells are damaged, and most are not."""
        counts = np.array([damaged.sum(), len(damaged)], dtype=float)
        some, every = sum_over_ranks(self._comm, counts)
        return bool(0 < some <= FEW * every)

    def _wanted(self, shorter: np.ndarray) -> Wanted:
        """Return the edges of coarse cells divided by these numbers as what cells should become."""
        wanted = Wanted.nothing(len(self._edges))
        split = self._coarse[shorter > 1]
        wanted.edge[split] = self._edges[split] / shorter[shorter > 1]
        return wanted

    def _damaged(self) -> np.ndarray:
        alpha = self._state.alpha.x.array[self._corners]
        largest = alpha.max(axis=1, initial=0.0)
        if self._threshold:
            return np.asarray(largest > DAMAGED)
        slope = (self._frame @ (alpha[:, 1:] - alpha[:, :1])[..., None])[..., 0]
        steep = self._ell * np.linalg.norm(slope, axis=1) > STEEP
        return np.asarray((largest > SOFT) | steep)

    def _drive(self) -> np.ndarray:
        """Return the energy that drives the damage over its threshold, the largest in each cell."""
        if not self._threshold:
            return np.zeros(len(self._coarse))
        self._damage.gradient(self._force)
        drive = self._state.alpha.copy()
        resisted = readable(self._force) / readable(self._damage.unit)
        drive.x.array[: len(resisted)] = 1.0 - resisted
        drive.x.scatter_forward()
        return np.asarray(drive.x.array[self._corners].max(axis=1, initial=0.0))

    def _uneven(self) -> np.ndarray:
        """Return how much shorter cells should be for the temperature: half or a quarter."""
        T = self._state.T.x.array
        allowed = self._rules.drop * max_over_ranks(self._comm, np.abs(T))
        corners = T[self._corners]
        change = corners.max(axis=1) - corners.min(axis=1)
        return np.select([change > MUCH * allowed, change > allowed], [4.0, 2.0], 1.0)
