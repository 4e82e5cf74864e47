"""Energy of an even array of cracks, and its first and second variation by the fronts.

An array of cells, each cut off from the others by cracks down to the depth a, is cooled from its
face. By superposition the cracks are loaded by the stress of the uncracked half-space, which is
sigma theta(z) with theta = erfc(z/(2 sqrt(kappa t))). Lengths are over the spacing p, stresses over
sigma, and E = 1, so the potential energy P is over sigma^2 p^3/E.

Fronts move by a vertical displacement w of the mesh. The energy is written on the mesh as it is, so
that its derivatives by w are exact for the finite elements (variation.py).
"""

from collections.abc import Sequence

from staffa.backend.stack import MPI

import basix.ufl
import numpy as np
import scipy.sparse as sparse
import ufl
from dolfinx import fem, mesh
from dolfinx.fem.petsc import assemble_matrix
from scipy.spatial import KDTree

from verification.columns_theory.cross_sections import CLOSE, CrossSection, graded
from verification.columns_theory.ties import fixed_by_turn, on_component, tied

BELOW = 1.6  # depth of the body below the fronts; a longer one changes nothing (run.py)


class Array:
    """Array with all fronts at one depth, and its derivatives by them.

    Parameters
    ----------
    section : cell, cut across.
    depth : of the fronts.
    nu : Poisson's ratio.
    first, ratio : first step of the mesh above and below the front, and growth of the steps.
    below : depth of the body below the fronts.
    """

    def __init__(
        self,
        section: CrossSection,
        *,
        depth: float,
        nu: float,
        first: float,
        ratio: float,
        below: float = BELOW,
    ) -> None:
        self.section, self.depth = section, depth
        above = depth - graded(first, ratio, 0.15, depth)[::-1]
        z = np.concatenate([above, depth + graded(first, ratio, 0.25, below)[1:]])
        self.domain = extruded(section, z)
        dim = self.domain.geometry.dim
        self.u_space = fem.functionspace(self.domain, ("Lagrange", 2, (dim,)))
        self.w_space = fem.functionspace(self.domain, ("Lagrange", 1))
        self.nodes = self.u_space.tabulate_dof_coordinates()[:, :dim]
        self.free = self.nodes[:, -1] < depth - CLOSE
        self.bottom = self.nodes[:, -1] > z[-1] - CLOSE
        self.layer = fem.Constant(self.domain, 1.0)  # sqrt(kappa t)
        self.u, self.w = fem.Function(self.u_space), fem.Function(self.w_space)
        self.forms = self._compiled(nu)
        self.moved = self._moved()

    def _compiled(self, nu: float) -> dict[str, fem.Form]:
        """Derivatives of the potential energy."""
        energy = self._energy(nu)
        by_u = ufl.derivative(energy, self.u)
        by_w = ufl.derivative(energy, self.w)
        forms = {
            "P": energy,
            "u": by_u,
            "w": by_w,
            "uu": ufl.derivative(by_u, self.u),
            "uw": ufl.derivative(by_u, self.w),
            "ww": ufl.derivative(by_w, self.w),
        }
        return {name: fem.form(form) for name, form in forms.items()}

    def _energy(self, nu: float) -> ufl.Form:
        """Potential energy of a cell, on the mesh that w moves along the last axis."""
        dim, last = self.domain.geometry.dim, self.domain.geometry.dim - 1
        down = ufl.unit_vector(last, dim)
        stretch = 1 + self.w.dx(last)
        back = ufl.Identity(dim) - ufl.outer(down, ufl.grad(self.w)) / stretch
        strain = ufl.sym(ufl.grad(self.u) * back)
        lame, mu = nu / ((1 + nu) * (1 - 2 * nu)), 1 / (2 * (1 + nu))  # plane strain in 2-D
        stored = lame / 2 * ufl.tr(strain) ** 2 + mu * ufl.inner(strain, strain)
        z = ufl.SpatialCoordinate(self.domain)[last] + self.w
        cold = 1 - ufl.erf(z / (2 * self.layer))
        pulled = -cold * ufl.dot(self.u, ufl.FacetNormal(self.domain))
        facets = mesh.locate_entities_boundary(self.domain, last, self._on_crack)
        tags = mesh.meshtags(self.domain, last, np.sort(facets), np.ones(len(facets), np.int32))
        dx = ufl.Measure("dx", self.domain, metadata={"quadrature_degree": 4})
        ds = ufl.Measure("ds", self.domain, subdomain_data=tags, metadata={"quadrature_degree": 6})
        return stored * stretch * dx - pulled * stretch * ds(1)

    def _on_crack(self, x: np.ndarray) -> np.ndarray:
        """Points of the walls down to the fronts."""
        dim = len(self.section.lattice)
        steps = np.concatenate([self.section.lattice, -self.section.lattice])
        if dim == 2:
            steps = np.concatenate([steps, [steps[0] - steps[1], steps[1] - steps[0]]])
        wall = np.max(steps @ x[:dim], axis=0) > 0.5 - CLOSE
        return np.asarray(wall & (x[dim] < self.depth + CLOSE))

    def _moved(self) -> np.ndarray:
        """Movement of the mesh with each node of the perimeter, shape (w, nodes)."""
        at = self.w_space.tabulate_dof_coordinates()
        dim = len(self.section.lattice)
        _, point = KDTree(self.section.points).query(at[:, :dim])
        z = at[:, dim]
        still = np.minimum(z, at[:, dim].max() - z) / min(0.6 * self.depth, 0.6)
        moved = np.zeros((len(at), len(self.section.perimeter)))
        weight = self.section.weight[point] * np.clip(still, 0, 1)
        moved[np.arange(len(at)), self.section.node[point]] = weight
        return moved

    def matrix(self, name: str) -> sparse.csr_matrix:
        """A second derivative."""
        found = assemble_matrix(self.forms[name])
        found.assemble()
        rows, columns, values = found.getValuesCSR()
        return sparse.csr_matrix((values, columns, rows), shape=found.getSize())

    def vector(self, name: str) -> np.ndarray:
        """A first derivative."""
        return fem.assemble_vector(self.forms[name]).array

    def bloch(self, k: np.ndarray, mirrors: Sequence[int] = ()) -> sparse.csr_matrix:
        """Displacements from independent real numbers, for a wave vector.

        With a turn by half around the axis of the cell, and complex conjugation, the energy and k
        stay as they are. So there is a basis in which the stiffness is real.

        Parameters
        ----------
        k : wave vector.
        mirrors : for mirrors across x, and across y, 1 or -1: only displacements that are even or
            odd.
        """
        tie = tied(self.nodes, self.section.lattice, k, self.free)
        full = tie.matrix()
        kept = np.unique(tie.of)
        dim = self.nodes.shape[1]
        turned = self.nodes.copy()
        turned[:, :-1] *= -1
        _, other = KDTree(self.nodes).query(turned)
        column = np.searchsorted(kept, tie.of)
        partner, factor = column[other[kept]], np.conj(tie.phase[other[kept]])
        use = ~self.bottom[kept]
        sides = [full @ fixed_by_turn(partner, s * factor, use) for s in [-1.0] * (dim - 1) + [1.0]]
        basis = sparse.hstack([on_component(side, i, dim) for i, side in enumerate(sides)], "csc")
        for axis, sign in enumerate(mirrors):
            basis = self._mirrored(basis, axis, sign)
        return sparse.csr_matrix(basis)

    def _mirrored(self, basis: sparse.csc_matrix, axis: int, sign: int) -> sparse.csc_matrix:
        """The part of a basis that a mirror across an axis leaves as it is, but for a sign."""
        dim = self.nodes.shape[1]
        flipped = self.nodes.copy()
        flipped[:, axis] *= -1
        _, other = KDTree(self.nodes).query(flipped)
        signs = sign * np.where(np.arange(dim) == axis, -1.0, 1.0)
        places = (other[:, None] * dim + np.arange(dim)).ravel()
        image = sparse.diags(np.tile(signs, len(other))) @ sparse.csr_matrix(basis)[places]
        partner = sparse.csc_matrix(basis.conj().T @ image)
        partner.data[np.abs(partner.data) < 0.5] = 0
        partner.eliminate_zeros()
        assert partner.nnz == basis.shape[1], "the mesh is not symmetric"
        columns = np.arange(basis.shape[1])
        keep = (columns < partner.indices) | (
            (columns == partner.indices) & (partner.data.real > 0)
        )
        return sparse.csc_matrix(basis + image)[:, keep]


def extruded(section: CrossSection, z: np.ndarray) -> mesh.Mesh:
    """Mesh of a cell: its cross-section at each depth z."""
    count, dim = len(section.points), section.points.shape[1]
    points = np.concatenate(
        [np.hstack([section.points, np.full((count, 1), depth)]) for depth in z]
    )
    cells = np.concatenate(
        [
            np.hstack([section.cells + layer * count, section.cells + (layer + 1) * count])
            for layer in range(len(z) - 1)
        ]
    )
    shape = {1: "quadrilateral", 2: "hexahedron"}[dim]
    element = basix.ufl.element("Lagrange", shape, 1, shape=(dim + 1,))
    return mesh.create_mesh(MPI.COMM_SELF, cells.astype(np.int64), element, points)
