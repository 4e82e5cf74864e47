"""Lanczos' method on the second derivative of the energy: a search for negative curvature.

With A the second derivative and P its preconditioner, the smallest Ritz value of P^-1 A falls to
the smallest eigenvalue as the Krylov space grows. A negative value belongs to a direction of
negative curvature. If P eliminates the displacement exactly and inverts the damage's block, an
eigenvalue is 1 - mu: a sweep of alternate minimization multiplies an error along its eigenvector by
mu, and leaves the state if mu > 1.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from staffa.backend.stack import PETSc

import numpy as np
from scipy.linalg import eigh_tridiagonal

from staffa.backend.vectors import readable
from staffa.minimize.coupled import CoupledModel, destroy_pairs

# The space is complete if a new direction is shorter than this, over the one before.
COMPLETE = 1e-12
# An eigenvalue lies within the residual of a Ritz value: the search may end if the residual is this
# fraction of the value, but not before the second number of directions, so that all can appear.
KNOWN, FEWEST = 0.5, 8


@dataclass(frozen=True, kw_only=True)
class Softest:
    """Softest direction that was found.

    Attributes
    ----------
    value : smallest Ritz value, dimensionless; negative for negative curvature.
    b : damage of the direction, owned entries, with a largest |b| of one; empty unless the value is
        below minus the tolerance.
    iterations : number of applications of the second derivative.
    """

    value: float
    b: np.ndarray
    iterations: int


def softest(
    model: CoupledModel, start: PETSc.Vec, *, iterations: int, tolerance: float
) -> Softest | None:
    """Search for a direction of negative curvature. Collective.

    The search ends early if the smallest Ritz value is known to half of itself.

    Parameters
    ----------
    model : model of the energy around the state, see `CoupledModel.move_to`.
    start : first force, a pair that is zero where nothing moves.
    iterations : largest number of iterations.
    tolerance : the direction is computed if its value is below minus this.

    Returns
    -------
    The softest direction; None if no damage can move.
    """
    diagonal: list[float] = []
    side: list[float] = []
    value, weights = np.inf, np.zeros(0)
    for _, curvature, length in _lanczos(model, start):
        diagonal.append(curvature)
        smallest, vectors = eigh_tridiagonal(diagonal, side, select="i", select_range=(0, 0))
        value, weights = float(smallest[0]), vectors[:, 0]
        known = length * abs(weights[-1]) <= KNOWN * abs(value) and len(diagonal) >= FEWEST
        if known or len(diagonal) == iterations:
            break
        side.append(length)
    if not diagonal:
        return None
    if not value < -tolerance:
        return Softest(value=value, b=np.zeros(0), iterations=len(diagonal))
    b = _direction(model, start, weights)
    return Softest(value=value, b=b, iterations=2 * len(diagonal))


def _direction(model: CoupledModel, start: PETSc.Vec, weights: np.ndarray) -> np.ndarray:
    """Return the weighted sum of the damage of the directions of a second, equal iteration."""
    found = model.damage.unit.duplicate()
    found.set(0.0)
    # One direction more would cost an iteration.
    for weight, (way, _, _) in zip(weights, _lanczos(model, start), strict=False):
        found.axpy(float(weight), way.getNestSubVecs()[1])
    b = readable(found) / found.norm(PETSc.NormType.NORM_INFINITY)
    found.destroy()
    return np.asarray(b)


def _lanczos(model: CoupledModel, start: PETSc.Vec) -> Iterator[tuple[PETSc.Vec, float, float]]:
    """Yield directions orthonormal in P, the curvature along each, and its coupling to the next.

    The yielded pair is overwritten when the iteration continues.
    """
    pairs = [model.pair() for _ in range(5)]
    last, force, way, next_force, next_way = pairs
    try:
        last.set(0.0)
        start.copy(force)
        model.precondition(force, way)
        length, least = np.sqrt(max(force.dot(way), 0.0)), 0.0
        while length > least:
            least = COMPLETE  # from the second direction on lengths are dimensionless
            force.scale(1 / length)
            way.scale(1 / length)
            model.apply(way, next_force)
            curvature = way.dot(next_force)
            next_force.axpy(-curvature, force)
            next_force.axpy(-length, last)
            model.precondition(next_force, next_way)
            length = np.sqrt(max(next_force.dot(next_way), 0.0))
            yield way, float(curvature), float(length)
            last, force, way, next_force, next_way = force, next_force, next_way, last, way
    finally:
        destroy_pairs(*pairs)
