"""Closed-form engine: one fracture along a side, without any other program."""

from dataclasses import replace

import numpy as np

from staffa.errors import InputError
from staffa.records.circulation import Circulation, WellAccount
from staffa.reservoir.fracture_heat import FractureHeat
from staffa.reservoir.simulator import ConstantWater, Flow, Fracture, ReservoirModel, Well

ZERO = 273.15  # K, at which water has no heat, as in open-DARTS
SAME = 1e-9  # of numbers that are to be equal


class SingleFracture:
    """Water from end to end of a fracture along one side, and conduction into the rock beside it.

    The reservoir ends insulated at its side opposite the fracture, so the solution is that of
    parallel fractures twice as far apart, and that of a single one until the drop gets there.
    Permeability has no effect: the opening of the fracture and the rate are those of the model.
    The heat that wells bring is the closed form's; the heat stored is a sum over the cells, so the
    imbalance tells how well the cells resolve the solution. Heat of friction in the fracture, the
    pressure drop times the volume of the water, is left out on both sides.

    Parameters
    ----------
    model : the reservoir.

    Raises
    ------
    InputError
        The closed form does not describe it.
    """

    name = "closed form of a single fracture"

    def __init__(self, model: ReservoirModel) -> None:
        self.model = model
        self.water, self.fracture = _constant(model), _one_fracture(model)
        self.injector, self.producer = _two_wells(model)
        self.along, reversed_ = self._direction()
        grid, (side, end) = model.grid, self.fracture.side
        edges, sides = grid.edges[self.along], grid.edges[side]
        self.length = float(edges[-1] - edges[0])
        place = grid.nodes[:, self.along]
        self.x = edges[-1] - place if reversed_ else place - edges[0]
        wall = sides[1] if end < 0 else sides[-2]
        self.y = np.abs(grid.nodes[:, side] - wall)
        other = next(axis for axis in range(3) if axis not in (self.along, side))
        self.width = float(grid.edges[other][-1] - grid.edges[other][0])
        self.row = grid.row(self.fracture.side)
        self.capacity = model.capacity(self.water)
        depth = float(abs((sides[-1] if end < 0 else sides[0]) - wall))
        self.heat = self._heat(depth)
        self.drop = float(model.T[0] - (self.injector.T or 0.0))

    def start(self) -> Flow:
        """Return the state before the first step, at the pressure of the rock; see `Simulator`."""
        first = self._flow(0.0)
        return replace(first, p=np.array(self.model.p, dtype=float))

    def advance(
        self, flow: Flow, permeability: np.ndarray | None, duration: float
    ) -> tuple[Flow, Circulation, int]:
        """Return the state after a time, its account, and one inner step; see `Simulator`.

        Parameters
        ----------
        flow : state to begin with.
        permeability : has no effect.
        duration : time to advance (s).
        """
        before = float(flow.hidden[0])
        after = self._flow(before + duration)
        changes = self.model.grid.volumes * self.capacity * (after.T - flow.T)
        account = Circulation(
            duration=duration,
            wells=self._accounts(before, before + duration),
            heat_stored=float(changes.sum()),
        )
        return after, account, 1

    def close(self) -> None:
        """Do nothing: there is no process."""

    def _flow(self, t: float) -> Flow:
        T = self.model.T - self.drop * self.heat.drop(self.x, self.y, t)
        p = np.array(self.model.p, dtype=float)
        at_outlet = p[list(self.producer.cells)].mean()
        pressed = self._pressures()
        p[self.row] += pressed[1] - at_outlet
        p[self.row] += (pressed[0] - pressed[1]) * (1 - self.x[self.row] / self.length)
        return Flow(hidden=np.array([t]), T=T, p=p)

    def _pressures(self) -> tuple[float, float]:
        """Return the pressures of injector and producer (Pa)."""
        given = self.producer.pressure
        if given is None:
            given = float(self.model.p[list(self.producer.cells)].mean())
        volume = (self.injector.rate or 0.0) / self.water.rho
        # Of half the fracture: the flow of a half through half of w^3/12.
        resistance = 24 * self.water.mu * self.length / (self.fracture.opening**3 * self.width)
        return given + resistance * volume, given

    def _accounts(self, start: float, end: float) -> dict[str, WellAccount]:
        """Return the accounts of the wells between two times (s)."""
        rate, c = self.injector.rate or 0.0, self.water.c
        pressed = self._pressures()
        mass = rate * (end - start)
        warm = [self.model.T[0] - ZERO, (self.injector.T or 0.0) - ZERO]
        missed = self.heat.integral(self.length, end) - self.heat.integral(self.length, start)
        brought = mass * c * warm[1]
        taken = mass * c * warm[0] - rate * c * self.drop * missed
        at_end = self.heat.drop(np.array([self.length]), np.zeros(1), end)[0]
        cold = float(self.model.T[0] - self.drop * at_end)
        first, last = self.injector, self.producer
        return {
            first.name: WellAccount(
                mass=mass, heat=brought, T=float(first.T or 0.0), pressure=pressed[0]
            ),
            last.name: WellAccount(mass=-mass, heat=-taken, T=cold, pressure=pressed[1]),
        }

    def _heat(self, depth: float) -> FractureHeat:
        """Return the closed form.

        Parameters
        ----------
        depth : distance from the fracture to the opposite end of the reservoir (m).
        """
        model = self.model
        rock = np.setdiff1d(np.arange(model.grid.size), self.row)
        area = self.length * self.width
        capacity = (self.capacity * model.grid.volumes)[self.row].sum() / area
        return FractureHeat(
            carried=(self.injector.rate or 0.0) * self.water.c / self.width,
            stored=float(capacity),
            k=_same(model.conductivity[rock], "one conductivity"),
            rho_c=_same(self.capacity[rock], "one heat capacity"),
            depth=depth,
        )

    def _direction(self) -> tuple[int, bool]:
        """Return the axis from well to well, and whether the injector is at its upper end."""
        _same(self.model.T, "one temperature before the first step")
        grid = self.model.grid
        row = grid.row(self.fracture.side)
        for axis in range(grid.dim):
            if axis == self.fracture.side[0]:
                continue
            place = grid.centers[row, axis]
            ends = [set(row[place == place.min()]), set(row[place == place.max()])]
            for reversed_ in (False, True):
                wells = [self.injector, self.producer][:: -1 if reversed_ else 1]
                if [set(well.cells) for well in wells] == ends and ends[0] != ends[1]:
                    return axis, reversed_
        raise _refused("wells at both ends of the fracture, which open to all of its width")


def _constant(model: ReservoirModel) -> ConstantWater:
    if model.water is None:
        raise _refused("water of constant properties, { rho, c, mu }")
    return model.water


def _one_fracture(model: ReservoirModel) -> Fracture:
    if len(model.fractures) != 1:
        raise _refused(f"one fracture along a side, and there are {len(model.fractures)}")
    return model.fractures[0]


def _two_wells(model: ReservoirModel) -> tuple[Well, Well]:
    """Return the injector, of known rate and temperature, and the producer."""
    injectors = [w for w in model.wells if w.rate is not None and w.rate > 0 and w.T is not None]
    producers = [w for w in model.wells if w.T is None]
    if len(model.wells) != 2 or len(injectors) != 1 or len(producers) != 1:
        raise _refused("two wells, an injector with rate and T, and a producer")
    given = producers[0].rate
    if given is not None and abs(given + (injectors[0].rate or 0.0)) > SAME * abs(given):
        raise _refused("as much water out of the producer as into the injector")
    return injectors[0], producers[0]


def _same(values: np.ndarray, needed: str) -> float:
    """Return the one value of all cells, or refuse."""
    if np.ptp(values) > SAME * np.abs(values).max():
        raise _refused(needed)
    return float(values[0])


def _refused(needed: str) -> InputError:
    return InputError(
        f'The simulator "single" is a closed form and needs {needed}; '
        'take simulator = "darts" for anything else.'
    )
