"""A plate with a real slit that heat must go around: the reference of an insulating crack."""

from dataclasses import dataclass

from staffa.backend.stack import MPI

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem
from dolfinx import mesh as dmesh
from dolfinx.fem.petsc import LinearProblem

# The plate is 1 x 1, its bottom at 0 and its top at 1; the slit lies across its middle.
START, END, HEIGHT = 0.3, 0.7, 0.5


@dataclass(frozen=True, kw_only=True)
class Slit:
    """flow: heat through the plate, conductivity 1; x, T: points, shape (n, 2), and their
    temperatures."""

    flow: float
    x: np.ndarray
    T: np.ndarray

    def jump(self, apart: float) -> float:
        """Mean over the slit of the difference between points so far above and below it."""
        up, down = (self._along(HEIGHT + side * apart) for side in (1, -1))
        return float(np.mean(up - down))

    def _along(self, y: float) -> np.ndarray:
        rows = np.unique(self.x[:, 1].round(9))
        nearest = rows[np.abs(rows - y).argmin()]
        along, height = self.x.T
        row = (np.abs(height - nearest) < 1e-7) & (along > START) & (along < END)
        return self.T[row][np.argsort(self.x[row, 0])]


def slit(n: int) -> Slit:
    """Solve on n x n squares whose vertices on the slit are there twice; n a multiple of 20."""
    columns = np.arange(n + 1) / n
    grid = np.array([(x, y) for y in columns for x in columns])
    inside = (np.abs(grid[:, 1] - HEIGHT) < 1e-9) & (grid[:, 0] > START + 1e-9)
    twice = np.flatnonzero(inside & (grid[:, 0] < END - 1e-9))
    above = dict(zip(twice.tolist(), range(len(grid), len(grid) + len(twice)), strict=True))
    points = np.concatenate([grid, grid[twice]])
    cells = []
    for j in range(n):
        for i in range(n):
            corners = [j * (n + 1) + i, j * (n + 1) + i + 1, (j + 1) * (n + 1) + i]
            corners.append(corners[2] + 1)
            over = (j + 0.5) / n > HEIGHT
            cells.append([above.get(c, c) if over else c for c in corners])
    element = basix.ufl.element("Lagrange", "quadrilateral", 1, shape=(2,), dtype=np.float64)
    mesh = dmesh.create_mesh(MPI.COMM_SELF, np.array(cells, dtype=np.int64), element, points)
    space = fem.functionspace(mesh, ("Lagrange", 1))
    T, phi = ufl.TrialFunction(space), ufl.TestFunction(space)
    ends = []
    for y, value in ((0.0, 0.0), (1.0, 1.0)):
        dofs = fem.locate_dofs_geometrical(space, lambda x, y=y: np.isclose(x[1], y))
        ends.append(fem.dirichletbc(value, dofs, space))
    zero = fem.Constant(mesh, 0.0)
    problem = LinearProblem(
        ufl.dot(ufl.grad(T), ufl.grad(phi)) * ufl.dx,
        zero * phi * ufl.dx,
        bcs=ends,
        petsc_options={"ksp_type": "preonly", "pc_type": "lu"},
        petsc_options_prefix="slit_",
    )
    solution = problem.solve()
    flow = fem.assemble_scalar(fem.form(ufl.dot(ufl.grad(solution), ufl.grad(solution)) * ufl.dx))
    x = space.tabulate_dof_coordinates()[:, :2]
    return Slit(flow=float(flow), x=x, T=solution.x.array.copy())
