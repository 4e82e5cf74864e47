"""A crack driven by the mode I field of a moving tip: it follows, at its speed and at Gc."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from staffa.evolution.effective_toughness import effective_gc
from staffa.evolution.march import march
from staffa.evolution.problem import Problem
from staffa.evolution.system import System, build
from staffa.measure.tip import BEYOND_COHESIVE, THRESHOLDS, reach, tip_distances
from staffa.model.fields import vertices
from staffa.model.supports import SideSupport, no_displacement
from staffa.physics.damage import LAWS, DamageLaw, cohesive
from support.bodies import body, rock

NU = 0.2
WARM_UP = 4  # cells that the tip moves before it is followed: the crack starts 3 ell behind


def mode_one(x: np.ndarray, K: float, *, axis: int) -> np.ndarray:
    """A component of the displacement around a crack along x < 0, E = 1, plane stress."""
    r, theta = np.hypot(x[0], x[1]), np.arctan2(x[1], x[0])
    along = (np.cos, np.sin)[axis](theta / 2)
    size = K * (1 + NU) * np.sqrt(r / (2 * np.pi))
    return size * ((3 - NU) / (1 + NU) - np.cos(theta)) * along


@dataclass(frozen=True, kw_only=True)
class Ride:
    """A tip that moved, and the crack that followed it, at each step after the first ones.

    tip: where it was. ahead: of each threshold, where the last vertex above it lay, shape (steps,
    thresholds). surface: energy of the whole crack. factor: the toughness that it is loaded for.
    """

    tip: np.ndarray
    ahead: np.ndarray
    surface: np.ndarray
    factor: float
    h: float

    @property
    def speed(self) -> np.ndarray:
        """Speed of the crack over that of the tip, for each threshold."""
        return np.polyfit(self.tip, self.ahead, 1)[0]

    @property
    def toughness(self) -> float:
        """Energy of a unit of the crack, over Gc."""
        return float(np.polyfit(self.tip, self.surface, 1)[0])

    @property
    def beyond(self) -> np.ndarray:
        """Distance of the tip beyond each threshold, less half a cell."""
        return (self.tip[:, None] - self.ahead).mean(axis=0) - self.h / 2


def ride(
    law: str | DamageLaw,
    *,
    cells_per_ell: float,
    radius: float,
    cells: int,
    on_a_side: float = 0.0,
    look: Callable[[Problem, System], None] = lambda problem, system: None,
    change: Callable[[Problem], Problem] = lambda problem: problem,
) -> Ride:
    """Follow a crack for a number of cells, five steps in each, once it moves.

    on_a_side: the toughness over Gc that a crack on a plane of symmetry is loaded for; of the
    plate there is only the part above it. 0 for a crack within a whole plate. look: called at each
    step that is followed. change: makes another problem of the plate, with other solvers say.
    """
    h = 1.0 / cells_per_ell
    rows = round(radius / h) if on_a_side else 2 * round(radius / h) + 1  # odd: a middle row
    height, start = rows * h, radius
    line = 0.0 if on_a_side else height / 2
    material = rock(ell=1.0, law=LAWS[law] if isinstance(law, str) else law, nu=NU)
    factor = on_a_side or effective_gc(material, dim=2, h=h, cells="quadrilateral")

    def moved(axis: int, x: np.ndarray, t: float) -> np.ndarray:
        tip = np.array([[start + t], [line], [0.0]])
        return mode_one(x - tip, np.sqrt(factor), axis=axis)

    def cracked(x: np.ndarray) -> np.ndarray:
        near = (1.01 if on_a_side else 0.51) * h
        return (np.abs(x[1] - line) < near) & (x[0] < start - 3)

    components = {axis: partial(moved, axis) for axis in (0, 1)}
    sides = {side: components for side in ("left", "right", "bottom", "top")}
    if on_a_side:
        sides["bottom"] = {1: no_displacement}
    problem = change(
        body(
            (round(3 * radius / h) * h, height),
            h,
            material=replace(material, cracked=cracked),
            sides=tuple(SideSupport(side=side, components=c) for side, c in sides.items()),
            times=tuple(h * np.arange(1, 5 * (cells + WARM_UP) + 1) / 5),
        )
    )
    system = build(problem)
    x, alpha = vertices(system.spaces.alpha), system.state.alpha.x.array
    tip, ahead, surface = [], [], []
    try:
        for step in march(problem, system):
            if step.index >= 5 * WARM_UP:
                look(problem, system)
                tip.append(start + step.time)
                ahead.append([x[alpha > threshold, 0].max() for threshold in THRESHOLDS])
                surface.append(step.energies.surface * (2 if on_a_side else 1))
    finally:
        system.destroy()
    return Ride(
        tip=np.array(tip),
        ahead=np.array(ahead),
        surface=np.array(surface),
        factor=factor,
        h=h,
    )


@pytest.mark.long
def test_a_crack_follows_the_tip_that_drives_it_and_costs_gc() -> None:
    found = ride("AT1", cells_per_ell=4, radius=7, cells=10)
    speed = found.speed[THRESHOLDS.index(0.8)]
    assert speed == pytest.approx(1, abs=0.03), f"the crack runs at {speed:.3f} of the tip's speed"
    # The edge is where the field of a sharp crack holds but for the profile's width over radius.
    cost = found.toughness / found.factor
    assert cost == pytest.approx(1, abs=0.03), f"it costs {cost:.3f} of the effective Gc"
    assert found.beyond == pytest.approx(tip_distances("AT1", h=1 / 4), abs=0.05)


@pytest.mark.long
def test_a_cohesive_crack_follows_the_tip_that_drives_it_and_costs_gc() -> None:
    law = cohesive(irwin=4 / 3, ell=1.0)
    found = ride(law, cells_per_ell=4, radius=7, cells=16)
    assert found.speed[THRESHOLDS.index(0.8)] == pytest.approx(1, abs=0.03)
    assert found.toughness / found.factor == pytest.approx(1, abs=0.03)
    assert found.beyond == pytest.approx(tip_distances(law, h=1 / 4), abs=0.05)


def test_a_cohesive_crack_has_the_tip_of_its_irwin_length() -> None:
    for softening, rows in BEYOND_COHESIVE.items():
        for irwin, expected in rows.items():
            law = cohesive(irwin=irwin, ell=1.0, softening=softening)
            assert tip_distances(law, h=1 / 4) == pytest.approx(expected)
        longest = cohesive(irwin=2 * max(rows), ell=1.0, softening=softening)
        assert tip_distances(longest, h=1 / 4) is None, "never measured"
        assert reach(longest, threshold=0.8, ell=1.0, h=0.25) is None


def test_the_sharp_tip_is_half_a_cell_further_on_coarser_cells() -> None:
    reached = [reach("AT1", threshold=0.8, ell=1.0, h=h) for h in (0.25, 0.125)]
    assert reached == pytest.approx([0.875, 0.8125])


def test_damage_near_one_ends_still_earlier_on_coarser_cells() -> None:
    reached = [reach("AT1", threshold=0.95, ell=1.0, h=h) for h in (1 / 3, 1 / 8)]
    # Measured in ell, without h/2, in a plate of 16 ell: 1.300 and 1.087.
    assert reached == pytest.approx([1.300 + 1 / 6, 1.087 + 1 / 16], abs=0.01)
    coarse = [reach("AT1", threshold=0.95, ell=1.0, h=h) for h in (1.0, 2.0)]
    assert coarse[1] - coarse[0] == pytest.approx(0.5), "h/2 alone: never measured"


def test_no_sharp_tip_is_known_of_what_was_not_measured() -> None:
    assert reach("mine", threshold=0.8, ell=1.0, h=0.25) is None
    assert reach("AT1", threshold=0.3, ell=1.0, h=0.25) is None, "never measured"
