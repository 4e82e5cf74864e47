"""The straight path from one state to another, and the power of the loads along it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np

from staffa.backend.parallel import sum_over_ranks
from staffa.backend.vectors import readable
from staffa.minimize.alternate import Alternation
from staffa.model.energy import Energy

# A part of the path is halved so often at most.
HALVINGS = 10


def power_of_loads(energy: Energy, start: float, end: float) -> float:
    """Change of the external loads' energy between two times at the current state; the loads stay.

    Where the volume in cracks is given, its growth counts times the pressure. Collective.
    """
    external, kept = energy.external, energy.external.kept()
    external.at(end)
    late = energy.loads()
    external.at(start)
    change = late - energy.loads()
    external.put_back(kept)
    return change


def integral(
    slope: Callable[[float], float],
    ends: tuple[float, float],
    values: tuple[float, float, float],
    accuracy: float,
    halvings: int = HALVINGS,
) -> float:
    """Integral between two ends, by Simpson's rule on halves that are halved where it is needed.

    values: at the ends and halfway between them. accuracy: by how much Simpson's rule on a part may
    differ from that on its halves.
    """
    a, b = ends
    first, middle, last = values
    left, right = slope(a + (b - a) / 4), slope(b - (b - a) / 4)
    whole = (b - a) / 6 * (first + 4 * middle + last)
    halves = (b - a) / 12 * (first + 4 * left + 2 * middle + 4 * right + last)
    if not halvings or not abs(halves - whole) > accuracy:  # also where it is not finite
        return halves
    half = (a + b) / 2
    share = accuracy / 2  # the errors of both add up
    return integral(slope, (a, half), (first, left, middle), share, halvings - 1) + integral(
        slope, (half, b), (middle, right, last), share, halvings - 1
    )


@dataclass(frozen=True, kw_only=True)
class PathPoint:
    """A state on the path: displacement and temperature change, ghosts included; what the external
    loads keep."""

    u: np.ndarray
    T: np.ndarray
    loads: np.ndarray


class Path:
    """The straight path from the current state to a later one, displacements and loads alike.

    Both ends are in equilibrium, the states between them are not. The slope of the energy along it
    is known from its first derivatives, whatever rock answers strains with; its integral is the
    work of the loads, since at the ends displacements that are free do none. Nothing is solved for.
    Everything is collective.
    """

    def __init__(self, energy: Energy, parts: Alternation) -> None:
        """energy: its `direction` is the temperature change along the path (K)."""
        self.energy, self.parts = energy, parts
        self.start = self._at_hand()

    def bend(self, *, accuracy: float) -> float:
        """Integral of the slope up to the current state, less the mean of its ends.

        By Simpson's rule on parts that are halved where that changes it by more than `accuracy` (an
        energy): the slope has a kink where a part of the rock changes its answer. The current state
        stays.
        """
        end = self._at_hand()
        slope = partial(self._slope, end)
        try:
            ends, middle = (slope(0.0), slope(1.0)), slope(0.5)
            mean = sum(ends) / 2
            bend = 2 / 3 * (middle - mean)
            if abs(bend) <= accuracy:
                return bend
            return integral(slope, (0.0, 1.0), (ends[0], middle, ends[1]), accuracy) - mean
        finally:
            self._go_to(end)

    def slope_at_start(self) -> float:
        """Derivative of the energy along the path where it begins; the current state stays."""
        end = self._at_hand()
        try:
            return self._slope(end, 0.0)
        finally:
            self._go_to(end)

    def _slope(self, end: PathPoint, s: float) -> float:
        """Derivative of the energy along the path, at a fraction s of it."""
        energy, start, external = self.energy, self.start, self.energy.external
        here = PathPoint(
            **{name: (1 - s) * a + s * getattr(end, name) for name, a in vars(start).items()}
        )
        self._go_to(here)
        slope = power_of_loads(energy, start.loads[0], end.loads[0])
        external.between(start.loads, end.loads, s)
        slope += energy.thermal_power() + self._of_displacement(end)
        filled = external.forces.crack_volume
        if filled is not None:  # the pressure is found with the displacement, and changes with it
            given = (1 - s) * filled(start.loads[0]) + s * filled(end.loads[0])
            slope += (end.loads[1] - start.loads[1]) * (given - energy.crack_volume())
        return slope

    def _of_displacement(self, end: PathPoint) -> float:
        """The part of the slope that is due to the displacement."""
        forces = self.parts.elastic.rhs
        self.parts.forces(forces)
        own = slice(forces.getLocalSize())
        return sum_over_ranks(
            self.energy.comm, float(readable(forces) @ (end.u - self.start.u)[own])
        )

    def _at_hand(self) -> PathPoint:
        state, external = self.energy.state, self.energy.external
        return PathPoint(u=state.u.x.array.copy(), T=state.T.x.array.copy(), loads=external.kept())

    def _go_to(self, place: PathPoint) -> None:
        state = self.energy.state
        state.u.x.array[:], state.T.x.array[:] = place.u, place.T
        self.energy.external.put_back(place.loads)
