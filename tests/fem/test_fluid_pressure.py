"""Pressure of a fluid that comes with the temperature: in pores, in cracks, on sides."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from staffa.case.reading.read import parse_case
from staffa.errors import InputError, SolveError
from staffa.evolution.march import march
from staffa.evolution.problem import Backtracking, Problem, Solvers
from staffa.evolution.session import Session, interpolated
from staffa.evolution.snapshot import restore, snapshot
from staffa.evolution.system import System, build
from staffa.loads.closed_form import NoLoad
from staffa.loads.forces import Forces, Traction
from staffa.model.domain import block
from staffa.model.fields import vertices
from staffa.model.initial_cracks import FlatCrack
from staffa.model.supports import SideSupport, no_displacement
from staffa.physics.split import SPLITS
from staffa.records.step import Step, Stop
from staffa.setup import build as case_to
from staffa.setup.user_objects import Given, recorded, require_same
from support.bodies import body, rock
from support.circulation_cases import wall

E, NU = 2.0, 0.25
FLOOR = SideSupport(side="bottom", components={1: no_displacement})
LEFT = SideSupport(side="left", components={0: no_displacement})


@dataclass(frozen=True)
class Water:
    """p = start + rate t (1 + slope x), and T = -cooling t."""

    start: float = 0.0
    rate: float = 0.0
    slope: float = 0.0
    cooling: float = 0.0

    def temperature(self, x: np.ndarray, t: float) -> np.ndarray:
        return np.full(x.shape[1], -self.cooling * t)

    def pressure(self, x: np.ndarray, t: float) -> np.ndarray:
        return self.start + self.rate * t * (1 + self.slope * x[0])


def strong(**changes):
    """Rock that nothing here breaks."""
    return rock(E=E, nu=NU, ell=0.2, Gc=1e6, residual_stiffness=1e-12, **changes)


def last(problem: Problem) -> tuple[System, Step]:
    system = build(problem)
    steps = list(march(problem, system))
    assert not any(step.audit.violations for step in steps)
    return system, steps[-1]


@pytest.mark.parametrize(("biot", "balanced"), [(0.5, True), (1.0, False)])
def test_a_free_body_swells_with_the_pressure_in_its_pores(biot: float, balanced: bool) -> None:
    """The strain of a free body is b (p - p_0)/(3 K) in each direction, from its state at rest."""
    start, rise = 0.3, 0.2
    forces = Forces(fluid=True, biot=biot, balanced=balanced)
    problem = body(
        (0.5, 0.5, 0.5),
        0.25,
        material=strong(state="solid"),
        load=Water(start=start, rate=rise),
        forces=forces,
        times=(0.5, 1.0),
    )
    system, step = last(problem)
    x = vertices(system.spaces.alpha)
    u = system.state.u.x.array.reshape(-1, 3)
    strain = biot * rise * (1 - 2 * NU) / E
    apart = (u[:, None] - u[None]) - strain * (x[:, None] - x[None])
    assert np.abs(apart + np.transpose(apart, (0, 1, 2))).max() < 1e-9
    assert step.audit.balance < 1e-10
    system.destroy()


def test_all_pressure_acts_where_the_total_stress_is_given() -> None:
    """Effective stress at rest is the total one and b p; both descriptions strain alike then."""
    biot, start = 0.8, 0.3
    held = tuple(
        SideSupport(side=side, components=dict.fromkeys(range(2), no_displacement))
        for side in ("left", "right", "bottom", "top")
    )

    def total(x: np.ndarray) -> np.ndarray:
        return np.full((6, x.shape[1]), -0.5) * np.array([1, 1, 1, 0, 0, 0])[:, None]

    problem = body(
        (1.0, 0.5),
        0.25,
        sides=held,
        material=strong(state="plane strain"),
        load=Water(start=start, rate=0.1),
        forces=Forces(fluid=True, biot=biot, balanced=False, prestress=total),
    )
    system, _ = last(problem)
    stress = system.energy.stress()
    effective = -0.5 + biot * start
    assert stress[:, 0, 0] == pytest.approx(effective - biot * 0.4, rel=1e-9)
    density = 3 * (1 - 2 * NU) / (2 * E) * effective**2
    assert system.energy.stored() == pytest.approx(density * 0.5, rel=1e-9)
    system.destroy()


def cracked(load: Water, forces: Forces, split: str = "none", **more) -> Problem:
    """Half of a plate with a crack in the middle."""
    crack = FlatCrack(center=(0.0, 0.5125, 0.0), normal=(0.0, 1.0, 0.0), radius=0.3)
    material = rock(
        E=1.0, nu=0.2, ell=0.15, state="plane strain", cracks=(crack,), split=SPLITS[split]
    )
    return body(
        (1.0, 1.0), 0.05, sides=(LEFT,), material=material, load=load, forces=forces, **more
    )


@pytest.mark.parametrize(("split", "balanced"), [("none", False), ("no-tension", True)])
def test_in_cracks_it_is_a_pressure_in_cracks(split: str, balanced: bool) -> None:
    """A fluid without pores is a crack pressure that is known beforehand."""
    times = (0.5, 1.0)
    given, known = last(
        cracked(Water(), Forces(crack_pressure=lambda t: 0.2 * t), split, times=times)
    )
    fluid = Forces(fluid=True, biot=0.0, balanced=balanced)
    system, step = last(cracked(Water(rate=0.2), fluid, split, times=times))
    assert step.energies.total == pytest.approx(known.energies.total, rel=1e-6)
    assert system.energy.crack_volume() == pytest.approx(given.energy.crack_volume(), rel=1e-5)
    assert step.measures.fluid.pressure == pytest.approx(0.2, rel=1e-12)
    assert step.audit.balance < 1e-6 and step.audit.work == pytest.approx(
        known.audit.work, rel=1e-4
    )
    for one in (given, system):
        one.destroy()


def test_a_field_of_place_and_time_in_cracks_does_the_same_as_a_fluid() -> None:
    water = Water(rate=0.2, slope=0.7)
    one, step = last(
        cracked(Water(), Forces(crack_field=water.pressure), "no-tension", times=(0.5, 1.0))
    )
    two, same = last(cracked(water, Forces(fluid=True, biot=0.0), "no-tension", times=(0.5, 1.0)))
    assert same.energies.total == pytest.approx(step.energies.total, rel=1e-9)
    assert same.energies.loads == pytest.approx(step.energies.loads, rel=1e-9)
    for system in (one, two):
        system.destroy()


def test_pores_of_place_and_time_do_the_same_as_a_fluid() -> None:
    water = Water(start=0.1, rate=0.2, slope=0.7)
    total = Forces(prestress=lambda x: np.zeros((6, x.shape[1])), biot=0.6)
    known = replace(total, pore_pressure=water.pressure)
    pores = cracked(Water(), known, times=(0.5, 1.0))
    # Beside pores, a fluid is in cracks too.
    pores = replace(pores, forces=replace(known, crack_field=water.pressure))
    fluid = cracked(water, replace(total, fluid=True, balanced=False), times=(0.5, 1.0))
    one, step = last(pores)
    two, same = last(fluid)
    assert same.energies.total == pytest.approx(step.energies.total, rel=1e-9)
    assert np.abs(one.state.u.x.array - two.state.u.x.array).max() < 1e-9
    for system in (one, two):
        system.destroy()


def test_it_presses_on_sides() -> None:
    """The sides that it wets feel it as a pressure that varies along them."""
    water = Water(rate=0.2, slope=0.7)
    fields = {"sides": (LEFT, FLOOR), "material": strong(state="plane stress"), "times": (1.0,)}
    pressed = Forces(sides=(Traction(side="top", pressure=water.pressure),))
    wet = Forces(fluid=True, fluid_sides=("top",), biot=0.0)
    one, step = last(body((1.0, 0.5), 0.25, forces=pressed, **fields))
    two, same = last(body((1.0, 0.5), 0.25, forces=wet, load=water, **fields))
    assert np.abs(one.state.u.x.array).max() > 0.01
    assert two.state.u.x.array == pytest.approx(one.state.u.x.array, abs=1e-12)
    assert same.energies.loads == pytest.approx(step.energies.loads, rel=1e-12)
    for system in (one, two):
        system.destroy()


def test_snapshot_and_restart_state_hold_it() -> None:
    water = Water(start=0.1, rate=0.2, slope=0.7, cooling=1.0)
    problem = cracked(water, Forces(fluid=True, biot=0.5), times=(0.5, 1.0))
    session = Session(problem, build(problem))
    system = session.system
    list(march(problem, system))
    kept, p = snapshot(system), system.state.p.x.array.copy()
    x = vertices(system.spaces.alpha)[:, 0]
    assert p == pytest.approx(0.1 + 0.2 * (1 + 0.7 * x), abs=1e-14)
    system.state.p.x.array[:] = 0.0
    restore(system, kept)
    assert np.array_equal(system.state.p.x.array, p)
    finer = replace(
        problem, domain=block(session.comm, size=(1.0, 1.0), h=0.025, cells="quadrilateral")
    )
    other = interpolated(session, finer)
    fine = vertices(other.spaces.alpha)[:, 0]
    assert other.state.p.x.array == pytest.approx(0.1 + 0.2 * (1 + 0.7 * fine), abs=1e-12)
    other.destroy()
    session.destroy()


@pytest.mark.slow
def test_backtracking_and_first_guesses_bring_it_back() -> None:
    """Cooling with a pressure that grows: a return to an earlier time has that time's pressure."""
    water = Water(start=0.1, rate=0.5, cooling=2.0)

    def uneven(x: np.ndarray) -> np.ndarray:
        return 1 + 0.1 * np.sin(37 * x[0]) * np.cos(23 * x[1])

    stiff = (
        SideSupport(side="left", components=dict.fromkeys(range(2), no_displacement)),
        SideSupport(side="right", components=dict.fromkeys(range(2), no_displacement)),
    )
    problem = body(
        (1.0, 0.3),
        0.0125,
        sides=stiff,
        material=rock(ell=0.1, toughness=uneven, state="plane strain"),
        load=water,
        forces=Forces(fluid=True, biot=0.5),
        times=(0.2, 0.6, 0.8, 1.5),
    )
    problem = replace(
        problem,
        backtracking=Backtracking(),
        solvers=Solvers(guess="coarser", stop=Stop(change=1e-4, residual=1e-2)),
    )
    system = build(problem)
    pressures = []
    for step in march(problem, system):
        assert step.audit.violations == ()
        pressures.append((step.time, float(system.state.p.x.array.max()), step.returned))
    assert any(returned for _, _, returned in pressures), "there must be a return"
    for time, p, _ in pressures:
        assert p == pytest.approx(0.1 + 0.5 * time, abs=1e-13)
    coarse = system.coarser.system
    assert coarse.energy.external.p_at_rest.x.array == pytest.approx(0.1, abs=1e-13)
    system.destroy()


def test_a_pressure_that_is_not_finite_is_refused() -> None:
    class Lost(Water):
        def pressure(self, x: np.ndarray, t: float) -> np.ndarray:
            return np.full(x.shape[1], np.nan if t else 0.0)

    problem = body(
        (1.0, 0.5),
        0.25,
        material=strong(state="plane strain"),
        load=Lost(),
        forces=Forces(fluid=True),
    )
    system = build(problem)
    with pytest.raises(SolveError, match="a pressure that is not finite"):
        list(march(problem, system))
    system.destroy()


SECTION = """
[domain]
size = [1.0, 0.5]
h = 0.125
[material]
plane = "strain"
[damage]
ell = 0.3
[temperature]
profile = "none"
[time]
t = [1.0]
"""


def test_the_pressure_of_a_script_s_load_acts() -> None:
    """In pores, but in plane stress, where they would press the plate apart; and it is known
    again."""
    water = Water(start=0.1, rate=0.2)
    setup = case_to.problem(parse_case(SECTION), temperature=water)
    assert setup.forces == Forces(fluid=True, biot=1.0, balanced=True)
    thin = case_to.problem(parse_case(SECTION, ('material.plane="stress"',)), temperature=water)
    assert thin.forces == Forces(fluid=True, biot=0.0, balanced=True)
    stressed = ("forces.prestress={xx=-1.0,yy=-1.0,zz=-1.0}",)
    assert not case_to.problem(parse_case(SECTION, stressed), temperature=water).forces.balanced
    own = recorded(Given(temperature=water), setup)
    other = Given(temperature=Water(start=0.1, rate=0.3))
    with pytest.raises(InputError, match="go on with the same one"):
        require_same(other, own, case_to.problem(parse_case(SECTION), **vars(other)), "run")


@pytest.mark.parametrize(
    ("load", "settings", "words"),
    [
        (Water(), ("forces.pore_pressure=0.1",), "leave one of them out"),
        (Water(), ("forces.crack_pressure=1.0",), "leave one of them out"),
        (Water(start=np.nan), (), "the pressure is not finite at t = 1"),
    ],
)
def test_a_pressure_that_cannot_be(load, settings, words: str) -> None:
    with pytest.raises(InputError, match=words):
        case_to.problem(parse_case(SECTION, settings), temperature=load)


def test_a_script_s_load_and_a_reservoir_are_refused_together() -> None:
    """The prestress of the case would stay the total one, and the water be gone."""
    with pytest.raises(InputError, match=r"takes the place of \[reservoir\].*take that table out"):
        case_to.problem(wall('reservoir.simulator="single"'), temperature=NoLoad())
