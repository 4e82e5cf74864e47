"""Bodies that heat flows through, shared by tests and verifications."""

from collections.abc import Mapping

from staffa.backend.stack import MPI

import numpy as np

from staffa.heat.thermal_body import Conduction
from staffa.heat.transient import HeatEquation
from staffa.model.domain import Part, block
from staffa.model.fields import linear_spaces, vertices
from staffa.records.step import Heat


def tensor(*k: float) -> tuple[tuple[float, ...], ...]:
    """Conductivities along the axes."""
    return tuple(tuple(row) for row in np.diag(k).tolist())


def turned(k: tuple[tuple[float, ...], ...], degrees: float) -> tuple[tuple[float, ...], ...]:
    """A tensor turned about the last axis (about the only one in 2-D)."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    Q = np.eye(len(k))
    Q[:2, :2] = [[c, -s], [s, c]]
    return tuple(tuple(row) for row in (Q @ np.array(k) @ Q.T).tolist())


def still(x: np.ndarray) -> np.ndarray:
    """0 at every point."""
    return np.zeros(x.shape[1])


class Heated:
    """A block and its heat equation, marched along.

    T: temperature change (K), and alpha: damage, at the vertices `x`, ghosts included.
    """

    def __init__(
        self,
        size: tuple[float, ...],
        h: float,
        conduction: Conduction,
        *,
        cells: str = "quadrilateral",
        comm: MPI.Comm = MPI.COMM_SELF,
        axial: bool = False,
        hole: float = 0.0,
        parts: Mapping[str, Part] | None = None,
    ) -> None:
        domain = block(comm, size=size, h=h, cells=cells, axial=axial, hole=hole, parts=parts or {})
        spaces = linear_spaces(domain)
        self.equation = HeatEquation(domain, spaces, conduction)
        self.x = vertices(spaces.alpha).T
        self.T = self.equation.start()
        self.alpha = np.zeros_like(self.T)
        self.time = 0.0

    def to(self, time: float) -> Heat:
        """March to a time (s)."""
        self.T, heat = self.equation.advance(self.T, self.alpha, self.time, time)
        self.time = time
        return heat


def broken_layer(distance: np.ndarray, *, ell: float, h: float) -> np.ndarray:
    """Damage of AT1 at a distance (m) from the middle of a layer of broken cells."""
    beyond = np.maximum(np.abs(distance) - h / 2, 0.0)
    return np.maximum(1 - beyond / (2 * ell), 0.0) ** 2
