"""Touching crack faces: their normals, and the slip of earlier steps; both frozen in a step.

A cell is broken if its mean damage is at least `BROKEN`. Its normal is that of the given crack
that contains it, or else the direction in which the broken cells around it spread least. Cells
beside it have the same normal: its damage reaches them. `physics.split.Contact` is the energy of
such cells.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import ufl
from dolfinx import fem
from scipy.spatial import cKDTree

from staffa.backend import jit
from staffa.backend.parallel import gather, on_root, sum_over_ranks
from staffa.errors import StaffaError
from staffa.model.domain import middles
from staffa.model.initial_cracks import FlatCrack
from staffa.physics.split import Contact, shear_modulus
from staffa.physics.strained import Faces, Strained, negative

# Least mean damage of a cell that a crack crosses.
BROKEN = 0.95
# Broken cells within this distance (in ell) give the direction of a crack that has grown. With half
# of it, normals were off by 6 degrees on unstructured cells; with this by 2.
AROUND = 3.0
# Cells within this distance (in ell) of a broken cell have its normal.
ASIDE = 1.0
# Cells whose center is within this distance (in h) of a given crack, across it and beyond its rim,
# belong to it.
BESIDE = 2.0
# Least ratio of the spread of broken cells along a plane to that across it, for a crack.
LONG = 2.0
# Square of a negligible shear strain, added so that the size has a derivative at zero.
NONE = 1e-30


class CrackFaces:
    """Normals of cracks, and the fields that friction needs, cell by cell. Collective.

    Attributes
    ----------
    field : of each cell its normal, 0 far from cracks, and 1 if it is broken (else 0); with
        friction also the slip strain of earlier steps along the axes, its work per volume (J/m^3),
        the largest shear stress that friction carries (Pa), and 0 if it carries any (else 1).
    split : the energy split.
    comm : communicator of the mesh.
    dim : 2 or 3.
    """

    def __init__(
        self,
        alpha: fem.Function,
        split: Contact,
        *,
        ell: float,
        h: float,
        given: Sequence[FlatCrack],
    ) -> None:
        """Create the fields.

        Parameters
        ----------
        alpha : the damage.
        split : the energy split.
        ell : regularization length (m).
        h : mesh size (m).
        given : cracks whose normals are known.
        """
        mesh = alpha.function_space.mesh
        self.comm, self.split, self._alpha, self._given = mesh.comm, split, alpha, given
        self._ell, self._h, self.dim = ell, h, mesh.geometry.dim
        self._width = 2 * self.dim + 4 if split.friction else self.dim + 1
        space = fem.functionspace(mesh, ("Discontinuous Lagrange", 0, (self._width,)))
        self.field = fem.Function(space, name="faces")
        self._own = space.dofmap.index_map.size_local
        self._middles = middles(mesh).T
        if not np.array_equal(space.dofmap.list[:, 0], np.arange(len(self._middles))):
            raise StaffaError("cells and constants in them are numbered differently on this mesh")

    @property
    def rubs(self) -> bool:
        """True if there is friction."""
        return bool(self.split.friction)

    def felt(
        self, e: ufl.core.expr.Expr, strained: Callable[[ufl.core.expr.Expr], Strained]
    ) -> Strained:
        """Return an elastic strain together with the strain of the faces.

        Parameters
        ----------
        e : the elastic strain.
        strained : function that returns a strain as the rock's split takes it.
        """
        plane, (normal, sheared) = range(self.dim), self._parted(e)
        n = [self.field[i] for i in plane]
        size = e.ufl_shape[0]

        def entry(i: int, j: int) -> ufl.core.expr.Expr:
            if max(i, j) >= self.dim:
                return e[i, j]
            return e[i, j] - (n[i] * sheared[j] + sheared[i] * n[j]) / 2

        unsheared = ufl.as_tensor([[entry(i, j) for j in range(size)] for i in range(size)])
        faces = Faces(broken=self.field[self.dim], normal=normal, unsheared=strained(unsheared))
        if self.rubs:
            since = sheared - self._earlier
            faces = replace(
                faces,
                shear=ufl.sqrt(ufl.dot(since, since) + NONE),
                bound=self.field[self._width - 2],
                free=self.field[self._width - 1],
            )
        return replace(strained(e), faces=faces)

    @property
    def _earlier(self) -> ufl.core.expr.Expr:
        """Slip of earlier steps, a vector."""
        return ufl.as_vector([self.field[self.dim + 1 + i] for i in range(self.dim)])

    def _parted(self, e: ufl.core.expr.Expr) -> tuple[ufl.core.expr.Expr, ufl.core.expr.Expr]:
        """Return the strain across the faces, and the shear strain along them, a vector."""
        plane = range(self.dim)
        n = [self.field[i] for i in plane]
        across = [sum(e[i, j] * n[j] for j in plane) for i in plane]
        normal = sum(n[i] * across[i] for i in plane)
        return normal, ufl.as_vector([2 * (across[i] - normal * n[i]) for i in plane])

    def measure(
        self,
        e: ufl.core.expr.Expr,
        strained: Strained,
        stress: ufl.core.expr.Expr,
        g: ufl.core.expr.Expr,
        dx: ufl.Measure,
    ) -> None:
        """Compile the forms that friction needs.

        Parameters
        ----------
        e : the elastic strain.
        strained : the strain as `felt` returns it.
        stress : stress of the rock (Pa).
        g : fraction of the stiffness that is left.
        dx : measure of the body.
        """
        mesh = self.field.function_space.mesh
        scalars = fem.functionspace(mesh, ("Discontinuous Lagrange", 0))
        vectors = fem.functionspace(mesh, ("Discontinuous Lagrange", 0, (self.dim,)))
        assert strained.faces is not None and strained.principal is not None
        one, way = ufl.TestFunction(scalars), ufl.TestFunction(vectors)
        normal, sheared = self._parted(e)
        G, shear = shear_modulus(strained), strained.faces.shear
        plane = range(self.dim)
        n = [self.field[i] for i in plane]
        across = sum(n[i] * stress[i, j] * n[j] for i in plane for j in plane)
        self._forms = {
            "size": one * dx,
            "normal": normal * one * dx,
            "pressure": negative(across) * one * dx,
            "stress": G * shear * one * dx,
            "work": self.split.rubbed(strained, g) * one * dx,
            "sheared": ufl.dot(sheared, way) * dx,
            "slip": self.split.slip(strained) / shear * ufl.dot(sheared - self._earlier, way) * dx,
        }
        self._forms = {name: jit.form(form, mesh.comm) for name, form in self._forms.items()}
        self._sums = {False: fem.Function(scalars), True: fem.Function(vectors)}
        self._sizes = self._integrals("size")

    def _integrals(self, name: str) -> np.ndarray:
        """Return integrals over each cell, ghosts included, shape (n,) or (n, dim)."""
        vector = name in ("sheared", "slip")
        sums = self._sums[vector]
        sums.x.array[:] = 0.0
        fem.assemble_vector(sums.x.array, self._forms[name])
        sums.x.scatter_forward()
        found = sums.x.array.copy()
        return np.asarray(found.reshape(-1, self.dim) if vector else found)

    def mean(self, name: str) -> np.ndarray:
        """Return the mean of a quantity of `measure` over each cell, ghosts included."""
        found = self._integrals(name)
        return np.asarray(found / (self._sizes if found.ndim == 1 else self._sizes[:, None]))

    def friction(self) -> tuple[float, float]:
        """Return the work of friction since `stick`, and before it (J, in 2-D J/m)."""
        if not self.rubs:
            return 0.0, 0.0
        own = slice(self._own)
        before = float(self._sizes[own] @ self._rows[own, -3])
        found = np.array([self._integrals("work")[own].sum(), before])
        since, before = sum_over_ranks(self.comm, found)
        return float(since), float(before)

    @property
    def _rows(self) -> np.ndarray:
        return np.asarray(self.field.x.array.reshape(-1, self._width))

    @property
    def faced(self) -> np.ndarray:
        """True in each cell that has a normal, ghosts included."""
        return np.any(self._rows[:, : self.dim] != 0, axis=1)

    @property
    def bound(self) -> np.ndarray:
        """Largest shear stress (Pa) that friction carries in each cell, ghosts included.

        It is infinite if friction carries any stress.
        """
        return np.where(self._rows[:, -1] > 0, self._rows[:, -2], np.inf)

    def bear(self, bound: np.ndarray) -> None:
        """Set the largest shear stress (Pa) that friction carries, as `bound` returns it."""
        free = np.isfinite(bound)
        self._rows[:, -2], self._rows[:, -1] = np.where(free, bound, 0.0), free

    def turn(self) -> None:
        """Find the cells of cracks and their normals from the current damage."""
        rows, before = self._rows, self.faced
        damage = self._alpha.x.array[self._alpha.function_space.dofmap.list].mean(axis=1)
        own = np.flatnonzero(damage[: self._own] >= BROKEN)
        there, normals = self._normals(self._middles[own])
        rows[:, : self.dim + 1] = 0.0
        rows[own, self.dim] = 1.0
        if len(there):
            reach = ASIDE * self._ell + self._h
            apart, nearest = cKDTree(there).query(self._middles, distance_upper_bound=reach)
            near = np.isfinite(apart)
            rows[near, : self.dim] = normals[nearest[near]]
        rows[~self.faced, self.dim] = 0.0
        self.field.x.scatter_forward()
        if self.rubs:
            self._take_up_slip(before)

    def _take_up_slip(self, before: np.ndarray) -> None:
        """Project the slip on the faces; a newly broken layer starts without shear stress."""
        rows, slip = self._rows, self._rows[:, self.dim + 1 : 2 * self.dim + 1]
        n = rows[:, : self.dim]
        slip -= np.einsum("ij,ij->i", slip, n)[:, None] * n
        slip[~before] = 0.0
        new = ~before & (rows[:, self.dim] > 0)
        slip[new] = self.mean("sheared")[new]

    def _normals(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the centers of broken cells with a normal, and the normals; equal on all ranks.

        Parameters
        ----------
        x : centers of this rank's broken cells (m), shape (n, 3).
        """
        parts = gather(self.comm, x)

        def found() -> tuple[np.ndarray, np.ndarray]:
            assert parts is not None
            there = np.concatenate(parts)
            there = there[np.lexsort(there.T)]
            normals = normals_of(there[:, : self.dim], AROUND * self._ell)
            for crack in self._given:
                inside = _within(crack, there, BESIDE * self._h)
                normals[inside] = crack.normal[: self.dim]
            known = np.any(normals != 0, axis=1)
            return there[known], normals[known]

        return on_root(self.comm, found)

    def stick(self) -> None:
        """Add the slip since the last call to that of earlier steps, and set the friction bounds.

        Friction holds all faces that have not slipped, and none that are open. Other faces keep the
        current bound.
        """
        slip, bound = self.mean("slip"), self.bound
        slid = np.any(slip != 0, axis=1)
        self._rows[:, -3] += self.mean("work")
        self._rows[:, self.dim + 1 : 2 * self.dim + 1] += slip
        apart = self.mean("normal") > 0
        self.bear(np.where(apart, 0.0, np.where(slid, bound, np.inf)))

    def forget_work(self) -> None:
        """Count the work of friction from now on."""
        self._rows[:, -3] = 0.0


def normals_of(x: np.ndarray, reach: float) -> np.ndarray:
    """Return unit vectors in which the points around each point spread least, shape (n, dim).

    A vector is 0 if the points do not lie along a line or a plane.

    Parameters
    ----------
    x : points (m), shape (n, dim).
    reach : distance up to which points count (m).
    """
    n, dim = x.shape
    one, other = (
        cKDTree(x).query_pairs(reach, output_type="ndarray").T if n else np.zeros((2, 0), int)
    )
    offset = x[other] - x[one]
    weight = (1 - np.einsum("ij,ij->i", offset, offset) / reach**2) ** 2
    i = np.concatenate([one, other])
    weight, offset = np.tile(weight, 2), np.concatenate([offset, -offset])

    def summed(values: np.ndarray) -> np.ndarray:
        return np.bincount(i, weights=values, minlength=n)

    mass = 1 + summed(weight)
    mean = np.stack([summed(weight * offset[:, k]) for k in range(dim)], axis=1) / mass[:, None]
    spread = np.empty((n, dim, dim))
    for a in range(dim):
        for b in range(dim):
            square = summed(weight * offset[:, a] * offset[:, b]) / mass
            spread[:, a, b] = square - mean[:, a] * mean[:, b]
    squares, directions = np.linalg.eigh(spread)
    flat = squares[:, 1] > LONG**2 * squares[:, 0]
    return np.where(flat[:, None], directions[:, :, 0], 0.0)


def _within(crack: FlatCrack, x: np.ndarray, margin: float) -> np.ndarray:
    """Return True for points, shape (n, 3), within a margin (m) of a crack."""
    offset = x - np.array(crack.center)
    across = offset @ np.array(crack.normal)
    along = np.sqrt(np.maximum(np.einsum("ij,ij->i", offset, offset) - across**2, 0.0))
    return np.asarray((np.abs(across) <= margin) & (along <= crack.radius + margin))
