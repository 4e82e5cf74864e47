"""A sharp straight crack in a strip that a cold front runs along, by finite elements.

The strip is infinite, of width W, with free edges, in plane stress. Its change of temperature is
that of a front which moves along x at speed V into the hot part: -dT in the bath, x < 0, and
-dT exp(-V x/kappa) ahead of it, the steady solution of advection and diffusion (Yuse and Sano,
Nature 362, 329, 1993). A semi-infinite crack lies on the center line, from the cold side to its
tip at x. Units: lengths over W, temperatures over dT, energies per area over E (expansion dT)^2 W.
In these the energy release rate g depends on the place of the tip and on the Peclet number
P = W V/kappa alone: stresses of a simply connected plane body with free edges do not depend on nu.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.interpolate import InterpolatedUnivariateSpline
from scipy.linalg import cholesky, solve_triangular
from scipy.optimize import brentq, nnls
from scipy.sparse.linalg import splu

from verification.pairs.sharp_pair import SHIFT, element

BEHIND, AHEAD = 2.0, 1.0  # extent of the places of the tip that are looked at, over W
CONTACT = (-0.2, 0.5)  # places of the tip that are looked at where faces may touch, over W
ARMS, REST = 3.0, 12.0  # of the cracked arms behind these, and of the strip ahead of them


def front(peclet: float) -> Callable[[np.ndarray], np.ndarray]:
    """Return the change of temperature over dT as a function of x/W."""
    return lambda x: -np.exp(-peclet * np.maximum(x, 0.0))


@dataclass(frozen=True, kw_only=True)
class Release:
    """Energy release rate of the crack against the place of its tip.

    Attributes
    ----------
    x : places of the tip over W, counted from the front, shape (n,).
    g : energy release rate there over E (expansion dT)^2 W, negative where the faces of the crack
        overlap behind the tip (K_I < 0), shape (n,).
    """

    x: np.ndarray
    g: np.ndarray

    @property
    def largest(self) -> tuple[float, float]:
        """Return the place of the largest release rate, and that rate."""
        curve = InterpolatedUnivariateSpline(self.x, self.g, k=4)
        at = [x for x in curve.derivative().roots() if self.x[0] < x < self.x[-1]]
        best = max(at, key=lambda x: float(curve(x)))
        return float(best), float(curve(best))

    @property
    def threshold(self) -> float:
        """Return the least W/ell0 = E (expansion dT)^2 W/Gc at which the crack grows."""
        return 1 / self.largest[1]

    def steady(self, times: float) -> float:
        """Return the place of the tip at G = Gc where G falls ahead of it.

        Parameters
        ----------
        times : W/ell0 over its threshold, above 1.
        """
        curve = InterpolatedUnivariateSpline(self.x, self.g, k=3)
        peak, most = self.largest
        return float(brentq(lambda x: float(curve(x)) - most / times, peak, self.x[-1]))


class Strip:
    """The upper half of the strip: square cells around the tip, longer ones away from it."""

    def __init__(self, rows: int) -> None:
        """Assemble and factorize it.

        Parameters
        ----------
        rows : cells across half of the width.
        """
        self.h = h = 0.5 / rows
        tips = h * np.arange(-round(BEHIND / h), round(AHEAD / h) + 1)
        arms, rest = _growing(h, ARMS), _growing(h, REST)
        self.x = x = np.concatenate([tips[0] - arms[::-1], tips, tips[-1] + rest])
        node = np.arange(len(x) * (rows + 1)).reshape(len(x), -1)
        stiffness, self.thermal = _assembled(node, np.diff(x), h)
        first = len(arms)
        self.line = 2 * node[first : first + len(tips), 0] + 1
        held = np.concatenate([2 * node[first + len(tips) :, 0] + 1, [2 * node[-1, 0]], self.line])
        self.free = np.setdiff1d(np.arange(2 * node.size), held)
        self.factor = splu(stiffness[self.free][:, self.free].tocsc())
        self.across = stiffness[self.free][:, self.line].toarray()
        condensed = stiffness[self.line][:, self.line].toarray()
        self.lower = cholesky(
            condensed - self.across.T @ self.factor.solve(self.across), lower=True
        )
        self.tips, self.nodes_across = tips, rows + 1

    def released(self, change: Callable[[np.ndarray], np.ndarray]) -> Release:
        """Return the energy release rate by the place of the tip.

        Each node of the crack line that is let go, the ones behind it first, releases energy: the
        square of one entry of the solution with the Cholesky factor of the condensed stiffness.

        Parameters
        ----------
        change : change of temperature over dT as a function of x/W.
        """
        root = self._pull(change)
        # Of both halves, over the length h by which the crack grew, at the middle of it.
        return Release(x=self.tips + (0.5 - SHIFT) * self.h, g=root * abs(root) / self.h)

    def released_in_contact(self, change: Callable[[np.ndarray], np.ndarray]) -> Release:
        """Return the same of a crack whose faces touch without friction and do not overlap.

        The energy is least among openings of 0 or more: non-negative least squares.

        Parameters
        ----------
        change : change of temperature over dT as a function of x/W.
        """
        root = self._pull(change)
        counts = np.arange(*np.searchsorted(self.tips, CONTACT))
        gained = []
        for count in counts:
            _, left = nnls(self.lower[:count, :count].T, root[:count])
            gained.append(0.5 * (root[:count] @ root[:count] - left**2))
        x = self.tips[counts[:-1]] + (0.5 - SHIFT) * self.h
        return Release(x=x, g=2 * np.diff(gained) / self.h)

    def _pull(self, change: Callable[[np.ndarray], np.ndarray]) -> np.ndarray:
        """Return the force on the held crack line, solved with the Cholesky factor."""
        force = self.thermal @ np.repeat(change(self.x), self.nodes_across)
        pull = force[self.line] - self.across.T @ self.factor.solve(force[self.free])
        return np.asarray(solve_triangular(self.lower, pull, lower=True))


def _growing(h: float, extent: float) -> np.ndarray:
    """Return distances from the end of the square cells, in steps that grow by a tenth to 0.1."""
    steps = np.minimum(h * 1.1 ** np.arange(1, 400), 0.1)
    found = np.cumsum(steps)
    return found[: int(np.searchsorted(found, extent)) + 1]


def _assembled(
    node: np.ndarray, dx: np.ndarray, h: float
) -> tuple[sparse.csc_matrix, sparse.csr_matrix]:
    """Return the stiffness of the half strip, and its thermal force by nodal temperature."""
    rows: list[tuple[np.ndarray, ...]] = []
    for i, length in enumerate(dx):
        block, force = element(float(length), h)
        cell = np.stack([node[i, :-1], node[i + 1, :-1], node[i + 1, 1:], node[i, 1:]], 1)
        dof = np.stack([2 * cell, 2 * cell + 1], 2).reshape(-1, 8)
        rows.append(
            (
                *(np.repeat(dof, 8, 1), np.tile(dof, (1, 8)), np.tile(block.ravel(), len(cell))),
                *(np.repeat(dof, 4, 1), np.tile(cell, (1, 8)), np.tile(force.ravel(), len(cell))),
            )
        )
    columns = zip(*rows, strict=True)
    i, j, k, m, n, f = (np.concatenate([part.ravel() for part in parts]) for parts in columns)
    count = 2 * node.size
    stiffness = sparse.csc_matrix((k, (i, j)), shape=(count, count))
    return stiffness, sparse.csr_matrix((f, (m, n)), shape=(count, node.size))
