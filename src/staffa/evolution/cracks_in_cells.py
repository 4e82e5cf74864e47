"""Area and volume of the rock's cracks in the cells of a reservoir, and how far its walls moved."""

from collections.abc import Sequence

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import ufl
from dolfinx import fem

from staffa.backend import jit
from staffa.backend.parallel import sum_over_ranks
from staffa.errors import InputError
from staffa.evolution.thermal_state import Cracks
from staffa.measure.probes import located
from staffa.model import axis
from staffa.model.domain import Domain
from staffa.model.fields import Spaces
from staffa.model.openings import cell_integrals
from staffa.reservoir.crack_permeability import CrackedCells
from staffa.reservoir.grid import Grid
from staffa.reservoir.permeability import along_axes
from staffa.reservoir.simulator import Fracture

DEGREE = 4  # of the polynomials that are integrated exactly


class CracksInCells:
    """Sort the cracks of a state into the cells of a reservoir. Collective.

    An element belongs to the cell that its middle lies in. The area of its cracks is half the
    variation of alpha^4, which counts a crack as 1 whatever the profile of its damage is, and
    diffuse damage hardly at all. Their volume is that of `model.openings`.

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
        slope, dx = ufl.grad(self._alpha**4), axis.volume(domain, DEGREE)
        area = 0.5 * ufl.sqrt(ufl.dot(slope, slope)) * ufl.TestFunction(spaces.cell) * dx
        self._area = jit.form(area, domain.comm)
        vectors = fem.functionspace(domain.mesh, ("Discontinuous Lagrange", 0, (domain.dim,)))
        self._slopes = fem.Function(vectors)
        slopes = ufl.dot(ufl.grad(self._alpha), ufl.TestFunction(vectors)) * dx
        self._slope = jit.form(slopes, domain.comm)
        mesh = domain.mesh
        n_owned = mesh.topology.index_map(mesh.topology.dim).size_local
        self._elements = spaces.cell.dofmap.list[:n_owned, 0]
        middles = spaces.cell.tabulate_dof_coordinates()[self._elements]
        self._cells, _ = grid.cells_around(middles)
        self._walls = [_Wall(domain, grid, fracture) for fracture in fractures]

    def __call__(self, cracks: Cracks) -> CrackedCells:
        """Return the cracks of a state, the same on all ranks. Collective.

        Parameters
        ----------
        cracks : damage and displacement.
        """
        self._alpha.x.array[:], self._u.x.array[:] = cracks.alpha, cracks.u
        area = self._thickness * cell_integrals(self._area, self._sums)
        volume = self._thickness * cracks.volumes()
        normals = self._normals()
        along = area[:, None] * along_axes(normals)
        across = area[:, None, None] * normals[:, :, None] * normals[:, None, :]
        parts = (area, volume, *along.T, *across.reshape(-1, self._grid.dim**2).T)
        sums = np.array([self._in_cells(part) for part in parts])
        area, volume, x, y, z, *tensor = sum_over_ranks(self._comm, sums)
        walls = [wall.moved(self._u) for wall in self._walls]
        dim = self._grid.dim
        return CrackedCells(
            area=area,
            volume=volume,
            along=np.stack([x, y, z], axis=-1),
            across=np.stack(tensor, axis=-1).reshape(-1, dim, dim),
            walls=np.concatenate([*walls, np.zeros(0)]),
        )

    def _in_cells(self, of_elements: np.ndarray) -> np.ndarray:
        return np.bincount(self._cells, weights=of_elements, minlength=self._grid.size)

    def _normals(self) -> np.ndarray:
        """Return the direction of the damage's slope in each element, shape (n_elements, dim)."""
        self._slopes.x.array[:] = 0.0
        fem.assemble_vector(self._slopes.x.array, self._slope)
        slopes = self._slopes.x.array.reshape(-1, self._grid.dim)[self._elements]
        lengths = np.linalg.norm(slopes, axis=1)
        return np.asarray(slopes / np.where(lengths > 0, lengths, 1.0)[:, None])


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
        if np.any(beside & (found == 0)):
            raise InputError(
                "a cell of the fracture's row lies at no place of the body's side; take a body "
                "whose sides are flat"
            )
        self._ranks = np.maximum(found, 1)

    def moved(self, u: fem.Function) -> np.ndarray:
        """Return the displacement into the body at each cell (m). Collective."""
        into_body = np.zeros(len(self._ranks))
        if len(self._here):
            values = u.eval(self._points, self._elements).reshape(len(self._here), -1)
            into_body[self._here] = -self._end * values[:, self._axis]
        return np.asarray(sum_over_ranks(self._comm, into_body) / self._ranks)
