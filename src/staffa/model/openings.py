"""Openings of cracks: the strain across them that intact rock would not have.

Intact rock beside a crack carries its traction t = sigma n, and has its strain along the crack. So
the strain across a crack of normal n is that of intact rock, with its thermal strain and prestrain,
and a further strain, n j and j n. With C the stiffness of intact rock and e the elastic strain,

    t = C : (e - sym(n j)) . n,    j = (n C n)^-1 . (C : e - sigma) . n.

The integral of j . n across the crack is its opening; over a body it is the crack volume.
"""

from collections.abc import Callable

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import ufl
from dolfinx import fem, la

from staffa.backend import jit
from staffa.model.axis import Measure

# If the squared gradient of the damage is below this (in 1/ell^2), there is no crack.
FLAT = 1e-2
# An opening strain below this share of the strain across is round-off: the crack is closed.
ROUND_OFF = 1e-9


class Openings:
    """Opening strain of a state, cell by cell. All methods are collective."""

    def __init__(
        self,
        u: fem.Function,
        alpha: fem.Function,
        strain: Callable[[fem.Function], ufl.core.expr.Expr],
        *,
        ell: float,
        dx: Measure,
    ) -> None:
        """Compile the forms.

        Parameters
        ----------
        u : displacement (m).
        alpha : damage.
        strain : function that returns j . n for a normal n, constant in each cell.
        ell : regularization length (m).
        dx : measure of the body.
        """
        mesh = alpha.function_space.mesh
        dim = mesh.geometry.dim
        constants = fem.functionspace(mesh, ("Discontinuous Lagrange", 0))
        self._alpha, self._flat = alpha, FLAT / ell**2
        n = fem.Function(fem.functionspace(mesh, ("Discontinuous Lagrange", 0, (dim,))))
        self._across = n
        self._slopes = fem.Function(fem.functionspace(mesh, ("Lagrange", 1, (dim, dim))))
        self._sums = fem.Function(constants)
        slope = ufl.grad(alpha)
        tests = ufl.TestFunction(self._slopes.function_space), ufl.TestFunction(constants)
        self._squares = jit.form(ufl.inner(ufl.outer(slope, slope), tests[0]) * dx, mesh.comm)
        self._opened = jit.form(strain(n) * tests[1] * dx, mesh.comm)
        self._strained = jit.form(ufl.dot(n, ufl.grad(u) * n) * tests[1] * dx, mesh.comm)
        count = mesh.topology.index_map(dim).size_local
        self._cells = constants.dofmap.list[:count, 0]
        self.sizes = self._integrals(jit.form(tests[1] * dx, mesh.comm))

    def volumes(self) -> np.ndarray:
        """Return the crack volume in each owned cell (m^3; m^2 in 2-D), shape (n,)."""
        damaged = self._damage() > 0
        cracked = self._turn_across() & damaged
        return np.where(cracked, self._integrals(self._opened), 0.0)

    def strains(self) -> dict[str, np.ndarray]:
        """Return cell means of the opening strain, and of intact rock's strain across the crack.

        Each has shape (n,), and is 0 where there is no crack, or where it is closed.
        """
        opened = self.volumes()
        whole = self._integrals(self._strained)
        open_ = np.abs(opened) > ROUND_OFF * np.abs(whole)
        opened, whole = np.where(open_, opened, 0.0), np.where(open_, whole, 0.0)
        return {
            "opening_strain": opened / self.sizes,
            "intact_strain": (whole - opened) / self.sizes,
        }

    def _damage(self) -> np.ndarray:
        cells = self._alpha.function_space.dofmap.list[: len(self._cells)]
        return np.asarray(self._alpha.x.array[cells].max(axis=1))

    def _integrals(self, form: fem.Form) -> np.ndarray:
        return cell_integrals(form, self._sums)

    def _turn_across(self) -> np.ndarray:
        """Set each cell's normal to the direction of the damage gradient around it.

        Return True for cells that have one. A broken cell's own gradient is 0, that of its
        neighbors is not.
        """
        values, space = self._slopes.x, self._slopes.function_space
        values.array[:] = 0.0
        fem.assemble_vector(values.array, self._squares)
        values.scatter_reverse(la.InsertMode.add)
        values.scatter_forward()
        dim = space.mesh.geometry.dim
        n = len(self._cells)
        around = values.array.reshape(-1, dim, dim)[space.dofmap.list[:n]].sum(axis=1)
        squares, directions = np.linalg.eigh(around)
        self._across.x.array.reshape(-1, dim)[self._cells] = directions[:, :, -1]
        return squares[:, -1] > self._flat * self.sizes


def cell_integrals(form: fem.Form, sums: fem.Function) -> np.ndarray:
    """Return integrals over each cell that this rank owns, shape (n,).

    Parameters
    ----------
    form : linear form, with a test function that is constant in each cell.
    sums : function of its space, which is overwritten.
    """
    space = sums.function_space
    topology = space.mesh.topology
    sums.x.array[:] = 0.0
    fem.assemble_vector(sums.x.array, form)
    return np.asarray(
        sums.x.array[space.dofmap.list[: topology.index_map(topology.dim).size_local, 0]].copy()
    )
