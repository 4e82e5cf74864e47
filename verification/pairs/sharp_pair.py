"""Two sharp cracks on planes of symmetry, one tougher: growth at G = Gc by finite elements.

The body is factorized once and its crack lines once: this gives the energy for every pair of
lengths. Half-space units of the case `two-cracks`: severity 54, plane stress, ends fixed.
"""

import numpy as np
from scipy import sparse
from scipy.interpolate import RectBivariateSpline
from scipy.linalg import cholesky, solve_triangular
from scipy.sparse.linalg import splu

from staffa.loads.closed_form import Face, Slab

P, NU, SEVERITY = 0.1285, 0.2, 54.0
DEEPEST = 0.2  # of the crack lines
# A crack of these elements is longer than its released nodes tell, in h: .1416, .1411, .1408 at the
# bifurcation on 32, 64 and 128 columns tend to .1406.
SHIFT = 0.25


def element(hx: float, hy: float) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness (8, 8) and thermal force by nodal temperature (8, 4) of a bilinear cell, E = 1."""
    elastic = np.array([[1, NU, 0], [NU, 1, 0], [0, 0, (1 - NU) / 2]]) / (1 - NU**2)
    stiffness, thermal = np.zeros((8, 8)), np.zeros((8, 4))
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    for x, y in corners / np.sqrt(3):
        shape = 0.25 * (1 + x * corners[:, 0]) * (1 + y * corners[:, 1])
        dx = 0.25 * corners[:, 0] * (1 + y * corners[:, 1]) * 2 / hx
        dy = 0.25 * corners[:, 1] * (1 + x * corners[:, 0]) * 2 / hy
        strain = np.zeros((3, 8))
        strain[0, 0::2], strain[1, 1::2], strain[2, 0::2], strain[2, 1::2] = dx, dy, dy, dx
        weight = hx * hy / 4
        stiffness += weight * strain.T @ elastic @ strain
        thermal += weight * np.outer(strain.T @ elastic @ np.array([1.0, 1.0, 0.0]), shape)
    return stiffness, thermal


class Body:
    """A cell between two crack lines; cells of edge h down to DEEPEST, longer ones below."""

    def __init__(self, columns: int, height: float) -> None:
        self.h = h = P / columns
        self.height = height
        fine = h * np.arange(round(DEEPEST / h) + 1)
        steps = h * 1.1 ** np.arange(1, 200)
        below = fine[-1] + np.cumsum(steps)
        below = below[: int(np.searchsorted(below, height)) + 1]
        below = fine[-1] + (below - fine[-1]) * (height - fine[-1]) / (below[-1] - fine[-1])
        y = np.concatenate([fine, below])
        node = np.arange((columns + 1) * len(y)).reshape(len(y), -1)
        count = 2 * node.size
        entries: list[list[np.ndarray]] = [[], [], [], [], [], []]
        for j in range(len(y) - 1):
            block, force = element(h, y[j + 1] - y[j])
            cell = np.stack([node[j, :-1], node[j, 1:], node[j + 1, 1:], node[j + 1, :-1]], 1)
            dof = np.stack([2 * cell, 2 * cell + 1], 2).reshape(-1, 8)
            new = (
                np.repeat(dof, 8, 1),
                np.tile(dof, (1, 8)),
                np.tile(block.ravel(), len(cell)),
                np.repeat(dof, 4, 1),
                np.tile(cell, (1, 8)),
                np.tile(force.ravel(), len(cell)),
            )
            for kept, values in zip(entries, new, strict=True):
                kept.append(values.ravel())
        row, column, value, m, n, f = (np.concatenate(values) for values in entries)
        stiffness = sparse.csc_matrix((value, (row, column)), shape=(count, count))
        self.thermal = sparse.csr_matrix((f, (m, n)), shape=(count, node.size))
        held = np.concatenate([2 * node[:, 0], 2 * node[:, -1], [2 * node[-1, 0] + 1]])
        self.line = np.concatenate([2 * node[: len(fine), 0], 2 * node[: len(fine), -1]])
        self.free = np.setdiff1d(np.arange(count), held)
        self.factor = splu(stiffness[self.free][:, self.free].tocsc())
        self.across = stiffness[self.free][:, self.line].toarray()
        self.condensed = stiffness[self.line][:, self.line].toarray()
        self.condensed -= self.across.T @ self.factor.solve(self.across)
        self.depth, self.nodes = np.repeat(y, columns + 1), len(fine)

    def pull(self, tau: float) -> np.ndarray:
        """Force on the crack lines while they are held."""
        slab = Slab(
            dT=SEVERITY, kappa=1.0, face=Face(axis=1, position=0.0, inward=1), L=self.height
        )
        x = np.stack([0 * self.depth, self.depth, 0 * self.depth])
        force = self.thermal @ slab.temperature(x, tau**2 / 4)
        return force[self.line] - self.across.T @ self.factor.solve(force[self.free])

    def released(self, taus: np.ndarray, counts: np.ndarray) -> np.ndarray:
        """Energy released by cracks of these numbers of nodes, shape (taus, counts, counts)."""
        pull = np.stack([self.pull(float(tau)) for tau in taus], 1)
        found = []
        for count in counts:
            order = np.r_[np.arange(count), self.nodes + np.arange(counts[-1])]
            lower = cholesky(self.condensed[np.ix_(order, order)], lower=True)
            gained = 0.5 * np.cumsum(solve_triangular(lower, pull[order], lower=True) ** 2, axis=0)
            found.append(gained[count + counts - 1].T)
        return np.stack(found, 1)


def growth(
    contrasts: tuple[float, ...], height: float = 1.0, columns: int = 64
) -> dict[float, np.ndarray]:
    """tau and the lengths of the weaker and the tougher crack, shape (n, 3), by contrast."""
    body, taus = Body(columns, height), np.arange(0.06, 0.1201, 0.00025)
    counts = np.arange(round(0.06 / body.h), round(0.19 / body.h) + 1)
    a, da = body.h * counts, 2e-5
    now = {contrast: np.array([0.08, 0.08]) for contrast in contrasts}
    rows: dict[float, list[list[float]]] = {contrast: [] for contrast in contrasts}
    for tau, energy in zip(taus, body.released(taus, counts), strict=True):
        spline = RectBivariateSpline(a, a, energy, kx=5, ky=5)
        for contrast, at in now.items():
            # The cell holds one half of each crack.
            while at.max() < 0.18:
                g = 2 * np.array([spline(*at, dx=1)[0, 0], spline(*at, dy=1)[0, 0]])
                g /= np.array([1.0, 1.0 + contrast])
                if g.max() <= 1:
                    break
                at[np.argmax(g)] += da
            rows[contrast].append([float(tau), *(at - SHIFT * body.h)])
    return {contrast: np.array(found) for contrast, found in rows.items()}
