"""A small body whose mesh follows the cracks, and a look at the cells of its steps."""

from dataclasses import dataclass

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np

from staffa.backend.vectors import readable
from staffa.case.reading.read import parse_case
from staffa.case.schema.case import Case
from staffa.evolution.system import System
from staffa.geometry.edges import cell_edges
from staffa.io.run_directory import Run
from staffa.io.vtkhdf import read_vtkhdf
from staffa.model.refinement import COARSE

REFINED = """
title = "A plate cooled from below"
[domain]
size = [1.0, 1.0]
h = 0.03125
cells = "triangle"
refine = { coarsest = "8 h", ahead = "0.5 ell" }
[damage]
ell = 0.1
[toughness]
amplitude = 0.1
seed = 3
[temperature]
profile = "half-space"
severity = 20.0
[time]
tau = [0.002, 0.01, 0.04, 0.2]
[output]
steps = "all"
at = []
"""


def refining(*settings: str) -> Case:
    """Return the case, with settings put over it."""
    return parse_case(REFINED, settings)


@dataclass(frozen=True, kw_only=True)
class Cells:
    """Cells of a step as its file of fields has them.

    Attributes
    ----------
    corners : places of their corners (m), shape (n, dim + 1, dim).
    alpha : damage there, shape (n, dim + 1).
    coarse : True for those that are not among the finest, shape (n,).
    """

    corners: np.ndarray
    alpha: np.ndarray
    coarse: np.ndarray

    @property
    def slope(self) -> np.ndarray:
        """Slope of the damage in each cell (1/m), shape (n,)."""
        legs = self.corners[:, 1:] - self.corners[:, :1]
        rise = self.alpha[:, 1:] - self.alpha[:, :1]
        return np.linalg.norm(np.linalg.solve(legs, rise[..., None])[..., 0], axis=1)

    def damage_at(self, point: tuple[float, ...]) -> float:
        """Return the damage at a point (m) of the body."""
        legs = self.corners[:, 1:] - self.corners[:, :1]
        parts = np.linalg.solve(legs.transpose(0, 2, 1), (point - self.corners[:, 0])[..., None])
        parts = np.insert(parts[..., 0], 0, 1 - parts[..., 0].sum(axis=1), axis=1)
        cell = parts.min(axis=1).argmax()
        return float(parts[cell] @ self.alpha[cell])

    @property
    def points(self) -> list[list[float]]:
        """Places of their corners (m), to twelve digits, each as often as it is a corner."""
        return (self.corners.reshape(-1, self.corners.shape[2]).round(12) + 0.0).tolist()

    @property
    def middles(self) -> np.ndarray:
        """Their middles in an order that depends on these alone (m), shape (n, dim)."""
        found = self.corners.mean(axis=1)
        return found[np.lexsort(found.round(9).T)]


def cells_of(run: Run, fields: str, finest: float) -> Cells:
    """Return the cells of a step.

    Parameters
    ----------
    run : the run.
    fields : file of the step's fields.
    finest : mean edge of the finest cells (m).
    """
    grid, values = read_vtkhdf(run.path / fields)
    corners = grid.points[grid.cells][..., : grid.cells.shape[1] - 1]
    return Cells(
        corners=corners,
        alpha=values["alpha"][grid.cells],
        coarse=cell_edges(corners) > COARSE * finest,
    )


def mean_edge_of_crossed(h: float) -> float:
    """Return the mean edge (m) of the triangles of a square with sides of h and two diagonals."""
    return (1 + 2**0.5) * h / 3


def largest_drive(system: System) -> float:
    """Return the energy that drives the damage, over its threshold, where it is largest."""
    damage = system.alternation.damage
    force = damage.unit.duplicate()
    damage.gradient(force)
    found = float((1.0 - readable(force) / readable(damage.unit)).max())
    force.destroy()
    return found
