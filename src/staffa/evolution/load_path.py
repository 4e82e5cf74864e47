"""Linear path from one state to another, and the power of the loads along it."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np

from staffa.backend.parallel import sum_over_ranks
from staffa.backend.vectors import readable
from staffa.minimize.alternate import Alternation
from staffa.model.energy import Energy

# Most halvings of a part of the path.
HALVINGS = 10


def power_of_loads(energy: Energy, start: float, end: float) -> float:
    """Return the change of the load energy between two times at the current state.

    The loads do not change. If the volume in cracks is given, its growth counts times the pressure.
    Collective.

    Parameters
    ----------
    energy : the energy.
    start : first time (s).
    end : second time (s).
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
    """Integrate between two ends by Simpson's rule, on halves that are halved where needed.

    Parameters
    ----------
    slope : function to integrate.
    ends : the two ends.
    values : its values at the start, halfway and at the end.
    accuracy : largest difference of Simpson's rule on a part from that on its halves.
    halvings : how often a part may still be halved.
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
    """State on the path.

    Attributes
    ----------
    u : displacement (m), ghosts included.
    T : temperature change (K), ghosts included.
    p : pressure of the fluid (Pa), ghosts included.
    loads : time and pressure of the external loads.
    """

    u: np.ndarray
    T: np.ndarray
    p: np.ndarray
    loads: np.ndarray


class Path:
    """Linear path from the current state to a later one, in displacements and loads.

    Both ends are in equilibrium; the states between them are not. The slope of the energy along the
    path follows from its first derivatives, for any elasticity. Its integral is the work of the
    loads, since free displacements do no work at the ends. Nothing is solved. All methods are
    collective.
    """

    def __init__(self, energy: Energy, parts: Alternation) -> None:
        """Start at the current state; `energy.direction` is the temperature change (K)."""
        self.energy, self.parts = energy, parts
        self.start = self._current()

    def bend(self, *, accuracy: float) -> float:
        """Return the integral of the slope up to the current state, less the mean of its ends.

        By Simpson's rule on parts that are halved where that changes the result by more than
        `accuracy` (an energy): the slope has a kink where rock changes between tension and
        compression. The current state does not change.
        """
        end = self._current()
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
        """Return the derivative of the energy at the start; the current state is unchanged."""
        end = self._current()
        try:
            return self._slope(end, 0.0)
        finally:
            self._go_to(end)

    def _slope(self, end: PathPoint, s: float) -> float:
        """Return the derivative of the energy along the path, at a fraction s of it."""
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
        """Return the part of the slope from the displacement."""
        forces = self.parts.elastic.rhs
        self.parts.forces(forces)
        own = slice(forces.getLocalSize())
        return sum_over_ranks(
            self.energy.comm, float(readable(forces) @ (end.u - self.start.u)[own])
        )

    def _current(self) -> PathPoint:
        state, external = self.energy.state, self.energy.external
        fields = {name: getattr(state, name).x.array.copy() for name in ("u", "T", "p")}
        return PathPoint(**fields, loads=external.kept())

    def _go_to(self, place: PathPoint) -> None:
        state = self.energy.state
        for name in ("u", "T", "p"):
            getattr(state, name).x.array[:] = getattr(place, name)
        self.energy.external.put_back(place.loads)
