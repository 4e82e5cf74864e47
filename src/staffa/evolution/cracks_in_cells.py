"""Area and volume of the rock's cracks in the cells of a reservoir, and how far its walls moved."""

from collections.abc import Sequence

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import ufl
from dolfinx import fem

from staffa.backend import jit
from staffa.backend.parallel import sum_over_ranks
from staffa.evolution.thermal_state import Cracks
from staffa.measure.probes import located
from staffa.model import axis
from staffa.model.domain import Domain
from staffa.model.fields import Spaces
from staffa.model.openings import cell_integrals
from staffa.reservoir.crack_permeability import CrackedCells
from staffa.reservoir.grid import Grid
from staffa.reservoir.simulator import Fracture

DEGREE = 4  # up to which alpha^4 times a strain is integrated exactly


class CracksInCells:
    """Sort the cracks of a state into the cells of a reservoir. Collective.

    An element belongs to the cell that its middle lies in. Its cracks have an area of half the
    variation of alpha^4, which counts a crack as 1 whatever the profile of its damage is, and
    diffuse damage hardly at all; and a volume of alpha^4 div u.

    Parameters
    ----------
    domain, spaces : the body, and the spaces of its fields.
    grid : the cells.
    fractures : fractures along sides of the body.
    """

    def __init__(
        self, domain: Domain, spaces: Spaces, grid: Grid, fractures: Sequence[Fracture]
    ) -> None:
        self._comm, self._grid = domain.comm, grid
        self._thickness = float(np.ptp(grid.edges[2])) if grid.dim == 2 else 1.0
        self._alpha, self._u = fem.Function(spaces.alpha), fem.Function(spaces.u)
        self._sums = fem.Function(spaces.cell)
        cracked, test = self._alpha**4, ufl.TestFunction(spaces.cell)
        slope = ufl.grad(cracked)
        dx = axis.volume(domain, DEGREE)
        area = 0.5 * ufl.sqrt(ufl.dot(slope, slope)) * test * dx
        volume = cracked * axis.divergence(domain, self._u) * test * dx
        self._forms = [jit.form(form, domain.comm) for form in (area, volume)]
        mesh = domain.mesh
        n_owned = mesh.topology.index_map(mesh.topology.dim).size_local
        middles = spaces.cell.tabulate_dof_coordinates()[spaces.cell.dofmap.list[:n_owned, 0]]
        self._cells, _ = grid.cells_around(middles)
        self._walls = [_Wall(domain, grid, fracture) for fracture in fractures]

    def __call__(self, cracks: Cracks) -> CrackedCells:
        """Return the cracks of a state, the same on all ranks. Collective.

        Parameters
        ----------
        cracks : damage and displacement.
        """
        self._alpha.x.array[:], self._u.x.array[:] = cracks.alpha, cracks.u
        area, volume = (
            np.bincount(
                self._cells,
                weights=self._thickness * cell_integrals(form, self._sums),
                minlength=self._grid.size,
            )
            for form in self._forms
        )
        area, volume = sum_over_ranks(self._comm, np.array([area, volume]))
        walls = [wall.moved(self._u) for wall in self._walls]
        return CrackedCells(area=area, volume=volume, walls=np.concatenate([*walls, np.zeros(0)]))


class _Wall:
    """The wall of a fracture along a side, at the middles of the cells of its row. Collective."""

    def __init__(self, domain: Domain, grid: Grid, fracture: Fracture) -> None:
        self._comm = domain.comm
        self._axis, self._end = fracture.side
        # Where the reservoir goes on beyond the body, its fracture keeps its opening.
        lower, upper = np.zeros(3), np.zeros(3)
        lower[: domain.dim] = domain.lower
        upper[: domain.dim] = np.add(domain.lower, domain.size)
        points = grid.centers[grid.row(fracture.side)].copy()
        points[:, domain.dim :] = 0.0
        points[:, self._axis] = upper[self._axis] if self._end > 0 else lower[self._axis]
        beside = np.all((points >= lower) & (points <= upper), axis=1)
        here, self._elements = located(domain, points)
        kept = beside[here]
        self._here, self._elements = here[kept], self._elements[kept]
        self._points = points[self._here]
        found = sum_over_ranks(self._comm, np.bincount(self._here, minlength=len(points)))
        self._ranks = np.maximum(found, 1)

    def moved(self, u: fem.Function) -> np.ndarray:
        """Return the displacement into the body at each cell (m). Collective."""
        into_body = np.zeros(len(self._ranks))
        if len(self._here):
            values = u.eval(self._points, self._elements).reshape(len(self._here), -1)
            into_body[self._here] = -self._end * values[:, self._axis]
        return np.asarray(sum_over_ranks(self._comm, into_body) / self._ranks)
