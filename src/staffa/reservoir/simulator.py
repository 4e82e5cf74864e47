"""Protocol of a reservoir simulator, and the model that it is given."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from staffa.records.circulation import Circulation
from staffa.reservoir.grid import Grid


@dataclass(frozen=True, kw_only=True)
class ConstantWater:
    """Water of constant properties.

    Attributes
    ----------
    rho : density (kg/m^3).
    c : specific heat (J/(kg K)).
    mu : viscosity (Pa s).
    k : conductivity (W/(m K)).
    """

    rho: float
    c: float
    mu: float
    k: float = 0.6


@dataclass(frozen=True, kw_only=True)
class Well:
    """One well.

    Attributes
    ----------
    name : its name.
    cells : indices of the cells that it opens to, shape (n,).
    rate : mass rate into the rock (kg/s), negative for production; None: `pressure` is given.
    pressure : pressure in the well (Pa); None: `rate` is given.
    T : temperature of injected water (K); None for a producer.
    radius : radius of the borehole (m).
    """

    name: str
    cells: tuple[int, ...]
    rate: float | None = None
    pressure: float | None = None
    T: float | None = None
    radius: float = 0.1


@dataclass(frozen=True, kw_only=True)
class Fracture:
    """A fracture along a side of the body: half of it lies in a row of cells beyond that side.

    Attributes
    ----------
    side : axis of the side's normal, and -1 for its lower end or 1 for its upper one.
    opening : opening of the whole fracture (m).
    height : height of the whole fracture's cells (m): the row of cells is half as high.
    """

    side: tuple[int, int]
    opening: float
    height: float


@dataclass(frozen=True, kw_only=True)
class ReservoirModel:
    """Rock, water and wells of a reservoir, in SI units.

    Attributes
    ----------
    grid : cells.
    permeability : permeability (m^2) of each cell, the same in all directions, shape (n_cells,); or
        along each axis, shape (n_cells, 3).
    porosity : porosity of each cell, shape (n_cells,).
    conductivity : conductivity of rock with its water (W/(m K)) in each cell, shape (n_cells,).
    rho_c : heat capacity of the grains per volume (J/(m^3 K)), in each cell, shape (n_cells,).
    T : temperature before the first step (K), shape (n_cells,).
    p : pressure before the first step (Pa), shape (n_cells,).
    water : properties of the water; None for the IAPWS formulation.
    wells : the wells.
    tolerance : error of a step of the simulator, over the temperature drop from rock to injection.
    gravity : acceleration along the axes (m/s^2), shape (3,).
    fractures : fractures along sides of the body.
    """

    grid: Grid
    permeability: np.ndarray
    porosity: np.ndarray
    conductivity: np.ndarray
    rho_c: np.ndarray
    T: np.ndarray
    p: np.ndarray
    water: ConstantWater | None
    wells: Sequence[Well]
    tolerance: float = 1e-3
    gravity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    fractures: Sequence[Fracture] = ()

    def capacity(self, water: ConstantWater) -> np.ndarray:
        """Return the heat capacity of each cell with its water (J/(m^3 K)), shape (n_cells,)."""
        of_water = self.porosity * water.rho * water.c
        return np.asarray((1 - self.porosity) * self.rho_c + of_water)


@dataclass(frozen=True, kw_only=True)
class Flow:
    """State of a reservoir at one time: all that a simulator goes on from.

    Attributes
    ----------
    hidden : numbers of the simulator itself, shape (n,). The same numbers give the same next step,
        to the last bit, also in another process.
    T : temperature (K) of each cell, shape (n_cells,).
    p : pressure (Pa) of each cell, shape (n_cells,).
    """

    hidden: np.ndarray
    T: np.ndarray
    p: np.ndarray


class Simulator(Protocol):
    """A reservoir simulator as a pure function of a state that its caller owns.

    Not collective: it lives on one rank, which tells the others.
    """

    name: str
    """Name and version of the simulator."""

    def start(self) -> Flow:
        """Return the state before the first step."""
        ...

    def advance(
        self, flow: Flow, permeability: np.ndarray | None, duration: float
    ) -> tuple[Flow, Circulation, int]:
        """Return the state after a time, the account of it, and the number of inner steps.

        Parameters
        ----------
        flow : state to begin with.
        permeability : permeability (m^2) of each cell, shape (n_cells,) or (n_cells, 3); None for
            the model's.
        duration : time to advance (s).

        Raises
        ------
        SolveError
            It did not converge. A shorter step is tried.
        StoppedError
            It does not answer any more.
        """
        ...

    def close(self) -> None:
        """End it."""
        ...
