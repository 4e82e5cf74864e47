"""Crack faces that touch: normals are renewed before a step, friction within it.

A step has an energy, since the normals of the faces, and the shear stress that friction carries,
are frozen during a minimization. That stress is the friction coefficient times the pressure between
the faces in the last minimum. The minimization is repeated until both agree.
"""

from collections.abc import Callable

import numpy as np

from staffa.backend.parallel import any_over_ranks, max_over_ranks, sum_over_ranks
from staffa.errors import SolveError
from staffa.evolution.equilibrate import Loads
from staffa.evolution.system import System
from staffa.minimize.alternate import equilibrium
from staffa.model.contact import CrackFaces

# The friction agrees if the stress that faces carry changes by less than this fraction of the
# largest one in the step; and the largest number of minimizations.
AGREEMENT, PASSES = 1e-3, 100
# Largest and smallest factor on a change of the stress: larger than 1 if the changes form a
# geometric series, smaller if they alternate.
LONGEST, SHORTEST = 50.0, 0.2


def renew(system: System, loads: Loads) -> float:
    """Renew the normals at the loads of the step before, and return the energy change. Collective.

    Slip up to here is that of earlier steps. The displacement is in equilibrium again.
    """
    faces, energy = system.energy.faces, system.energy
    if faces is None:
        return 0.0
    before = energy.total()
    if faces.rubs:
        faces.stick()
    faces.turn()
    equilibrium(system.alternation, loads.values)
    return energy.total() - before


def rub(system: System, minimize: Callable[[], bool]) -> float:
    """Minimize with the friction from the current pressure, until both agree. Collective.

    Parameters
    ----------
    system : the system.
    minimize : finds a minimum with the current friction; False ends the iteration.

    Returns
    -------
    Sum of the energy changes by new friction alone.

    Raises
    ------
    SolveError
        They do not agree after `PASSES` minimizations.
    """
    faces, energy = system.energy.faces, system.energy
    if faces is None or not faces.rubs:
        return 0.0
    change, series = 0.0, Series(system)
    for _ in range(PASSES):
        pressed = faces.split.friction * faces.mean("pressure")
        if series.is_over(faces, pressed):
            return change
        before = energy.total()
        faces.bear(series.next(faces, pressed))
        change += energy.total() - before
        if not minimize():
            return change
    raise SolveError(
        f"the friction between the faces of cracks and their pressure do not agree after {PASSES} "
        f"minimizations; take shorter time steps, or a smaller damage.friction"
    )


class Series:
    """Sequence of shear stresses that friction carries, with the factor on the next change.

    If friction and pressure depend on one another their changes form a geometric series, whose
    limit is estimated from its last two terms (Aitken's method for vectors, Irons and Tuck 1969).
    """

    def __init__(self, system: System) -> None:
        self._comm, self._largest = system.energy.comm, 0.0
        self._last: np.ndarray | None = None
        self._length = 1.0
        self._own = slice(system.spaces.cell.dofmap.index_map.size_local)

    def is_over(self, faces: CrackFaces, pressed: np.ndarray) -> bool:
        """Return True if faces carry the stress that the pressure allows.

        Parameters
        ----------
        faces : the crack faces.
        pressed : shear stress that the pressure allows (Pa), cell by cell.
        """
        stress, bound = faces.mean("stress"), faces.bound
        faced = faces.faced[self._own]
        carried, allowed = np.minimum(bound, stress), np.minimum(pressed, stress)
        off = np.where(faced, np.abs(allowed - carried)[self._own], 0.0)
        there = np.where(faced, np.maximum(pressed, carried)[self._own], 0.0)
        self._largest = max(self._largest, max_over_ranks(self._comm, there))
        return max_over_ranks(self._comm, off) <= AGREEMENT * self._largest

    def next(self, faces: CrackFaces, pressed: np.ndarray) -> np.ndarray:
        """Return the stress (Pa) that faces shall carry next, cell by cell.

        Parameters
        ----------
        faces : the crack faces.
        pressed : shear stress that the pressure allows (Pa), cell by cell.
        """
        bound = faces.bound
        free = np.isfinite(bound)
        change = np.where(free & faces.faced, pressed - np.where(free, bound, 0.0), 0.0)
        started = not any_over_ranks(self._comm, bool(np.any(faces.faced & ~free)))
        if self._last is not None:
            bend = (change - self._last)[self._own]
            square, along = sum_over_ranks(
                self._comm, np.array([bend @ bend, self._last[self._own] @ bend])
            )
            guess = -self._length * along / square if square > 0 else 1.0
            self._length = min(max(guess, SHORTEST), LONGEST) if guess > 0 else 1.0
        self._last = change if started else None
        return np.where(free, np.maximum(bound + self._length * change, 0.0), pressed)
