"""Prestress, weight, tractions, pressure in pores and in cracks."""

from dataclasses import replace

import numpy as np
import pytest

from staffa.errors import LoadError, StoppedError
from staffa.evolution.equilibrate import Loads, _first_guess
from staffa.evolution.initial_equilibrium import come_to_rest
from staffa.evolution.march import Observers, march
from staffa.evolution.problem import Problem
from staffa.evolution.system import System, build
from staffa.loads.forces import Forces, Traction
from staffa.minimize.alternate import equilibrium, support_reactions
from staffa.model.fields import owned
from staffa.model.initial_cracks import FlatCrack
from staffa.model.supports import SideSupport, no_displacement
from staffa.physics.elasticity import Isotropic
from staffa.physics.split import SPLITS
from staffa.records.step import SolverStatistics, Step, Stop
from support.bodies import body, rock

E, NU = 2.0, 0.25
FLOOR = SideSupport(side="bottom", components={1: no_displacement})
LEFT = SideSupport(side="left", components={0: no_displacement})
RIGHT = SideSupport(side="right", components={0: no_displacement})


EVENLY = np.array([1.0, 1.0, 1.0, 0, 0, 0])
PULLED = np.array([1.0, 0, 0, 0, 0, 0])


def strong(state: str = "plane stress", **changes):
    """Rock that nothing here breaks."""
    return rock(E=E, nu=NU, ell=0.2, Gc=1e6, state=state, residual_stiffness=1e-12, **changes)


def last(problem: Problem) -> tuple[System, Step]:
    system = build(problem)
    steps = list(march(problem, system))
    assert not any(step.audit.violations for step in steps)
    return system, steps[-1]


def largest(system: System) -> float:
    """Largest displacement."""
    return float(np.abs(owned(system.state.u)).max())


def uniaxial(stress: float):
    return lambda x, t: np.array([np.full(x.shape[1], stress * t), np.zeros(x.shape[1])])


@pytest.mark.parametrize("split", ["none", "no-tension"])
@pytest.mark.parametrize("pulled", [True, False])
def test_traction(split: str, pulled: bool) -> None:
    """A bar under stress that grows with time: strain sigma/E, and its work is its energy."""
    sigma = 0.3 if pulled else -0.3
    problem = body(
        (1.0, 0.5),
        0.25,
        sides=(LEFT, FLOOR),
        times=(0.5, 1.0),
        material=strong(split=SPLITS[split]),
        forces=Forces(sides=(Traction(side="right", force=uniaxial(sigma)),)),
    )
    system, step = last(problem)
    x = system.spaces.alpha.tabulate_dof_coordinates()
    u = system.state.u.x.array.reshape(-1, 2)
    assert u[:, 0] == pytest.approx(sigma / E * x[:, 0], abs=1e-6)
    assert u[:, 1] == pytest.approx(-NU * sigma / E * x[:, 1], abs=1e-6)
    assert step.energies.elastic == pytest.approx(sigma**2 / (2 * E) * 0.5, rel=1e-5)
    assert step.energies.loads == pytest.approx(-(sigma**2) / E * 0.5, rel=1e-5)
    system.destroy()


def test_pressure_is_a_traction_inwards() -> None:
    """On a slanting or any face along its normal."""
    pressed = {"top", "right"}
    both = body(
        (1.0, 0.5),
        0.25,
        sides=(LEFT, FLOOR),
        material=strong(),
        forces=Forces(
            sides=tuple(
                Traction(side=side, pressure=lambda x, t: np.full(x.shape[1], 0.1))
                for side in sorted(pressed)
            )
        ),
    )
    system, _ = last(both)
    x = system.spaces.alpha.tabulate_dof_coordinates()[:, :2]
    strain = -0.1 * (1 - NU) / E
    assert system.state.u.x.array.reshape(-1, 2) == pytest.approx(strain * x, abs=1e-9)
    system.destroy()


def test_weight() -> None:
    """A column sinks by rho g L^2/(2 E) at its top, if nu = 0."""
    problem = body(
        (0.5, 1.0),
        0.125,
        sides=(FLOOR,),
        material=replace(strong(rho=3.0), nu=0.0),
        forces=Forces(gravity=(0.0, -0.1)),
    )
    system, _ = last(problem)
    assert largest(system) == pytest.approx(3.0 * 0.1 / (2 * E), rel=1e-9)
    system.destroy()


@pytest.mark.parametrize(
    ("elasticity", "split"), [(None, "none"), (Isotropic(E=E, nu=NU), "volumetric-deviatoric")]
)
@pytest.mark.parametrize("state", ["plane strain", pytest.param("solid", marks=pytest.mark.long)])
def test_rock_under_its_weight_stays_where_it_is(elasticity, split: str, state: str) -> None:
    """Prestress that grows with depth balances weight and pressure on top: no displacement."""
    dim = 2 if state == "plane strain" else 3
    size = (1.0, 1.0) if dim == 2 else (0.5, 0.5, 1.0)
    rho, g, lateral, top = 3.0, 0.1, 0.6, 0.2

    def stress(x: np.ndarray) -> np.ndarray:
        vertical = -top - rho * g * (1.0 - x[dim - 1])
        found = np.zeros((6, x.shape[1]))
        found[:3] = lateral * vertical
        found[dim - 1] = vertical
        return found

    sides = [
        FLOOR if dim == 2 else SideSupport(side="bottom", components={2: no_displacement}),
        LEFT,
        RIGHT,
    ]
    if dim == 3:
        sides += [
            SideSupport(side=side, components={1: no_displacement}) for side in ("front", "back")
        ]
    problem = body(
        size,
        0.25,
        cells="triangle" if dim == 2 else "tetrahedron",
        sides=tuple(sides),
        material=strong(state, rho=rho, elasticity=elasticity, split=SPLITS[split]),
        forces=Forces(
            gravity=(*(0.0,) * (dim - 1), -g),
            prestress=stress,
            sides=(Traction(side="top", pressure=lambda x, t: np.full(x.shape[1], top)),),
        ),
    )
    system, _ = last(problem)
    assert largest(system) < 1e-11
    system.destroy()


@pytest.mark.parametrize("biot", [0.5, 1.0])
def test_pore_pressure(biot: float) -> None:
    """A body without stress on the whole is in equilibrium, its rock pulled by b p on all sides."""
    pores = Forces(pore_pressure=lambda x, t: np.full(x.shape[1], 0.3), biot=biot)
    system, step = last(body((0.5, 0.5, 0.5), 0.25, material=strong("solid"), forces=pores))
    assert largest(system) < 1e-11
    pulled = biot * 0.3
    density = 3 * (1 - 2 * NU) / (2 * E) * pulled**2
    assert system.energy.stored() == pytest.approx(density * 0.125, rel=1e-9)
    assert step.energies.total == pytest.approx(0.0, abs=1e-12), "it counts from the state of rest"
    system.destroy()


def test_drawn_down_pores() -> None:
    """A free body whose pore pressure is none, and whose rock was pulled by b p before, shrinks."""
    pulled = 0.3
    relaxed = Forces(prestress=lambda x: np.full((6, len(x[0])), pulled) * EVENLY[:, None])
    system, _ = last(body((0.5, 0.5, 0.5), 0.25, material=strong("solid"), forces=relaxed))
    u = system.state.u.x.array.reshape(-1, 3)
    strain = -(1 - 2 * NU) / E * pulled
    assert np.ptp(u[:, 0]) == pytest.approx(-strain * 0.5, rel=1e-6)
    system.destroy()


# Forms of a solid without tension take a minute to compile.
@pytest.mark.parametrize(
    ("state", "split"),
    [("plane stress", "none"), ("plane stress", "no-tension"), ("solid", "none")],
)
@pytest.mark.parametrize("s", [0.0, 0.25, 0.6])
def test_onset_under_prestress(state: str, split: str, s: float) -> None:
    """Rock held along x and pressed by s (times the strength) along it: cooling damages it when
    E expansion dT = sigma_c + s; 1 %."""
    ell = 0.5
    strength = np.sqrt(3 * E / (8 * ell))

    class Evenly:
        def temperature(self, x: np.ndarray, t: float) -> np.ndarray:
            return np.full(x.shape[1], -t)

    def stress(x: np.ndarray) -> np.ndarray:
        return np.array([-s * strength, 0, 0, 0, 0, 0])[:, None] * np.ones(x.shape[1])

    # Without tension 1 - nu^2 of a bar's energy drives damage in plane stress: see test_split.
    drop = strength / E * (s + (1 / np.sqrt(1 - NU**2) if split == "no-tension" else 1))
    size = (1.0, 0.5) if state == "plane stress" else (1.0, 0.5, 0.5)
    problem = body(
        size,
        0.25,
        sides=(LEFT, RIGHT),
        times=tuple(drop * np.array([0.5, 0.992, 1.008])),
        load=Evenly(),
        material=rock(E=E, nu=NU, ell=ell, state=state, split=SPLITS[split]),
        forces=Forces(prestress=stress),
        stop=Stop(change=1e-6, residual=1e-5),
    )
    system = build(problem)
    damage = []
    for step in march(problem, system):
        assert not step.audit.violations
        damage.append(system.state.alpha.x.array.max())
    system.destroy()
    assert damage[1] < 1e-8 < damage[2]


def test_stress_that_cracks_the_rock_by_itself() -> None:
    """It is told, with the place and the way out, before the first step."""
    problem = body(
        (1.0, 0.5),
        0.05,
        sides=(LEFT, RIGHT),
        material=rock(ell=0.15),
        forces=Forces(prestress=lambda x: np.full((6, len(x[0])), 2.0) * PULLED[:, None]),
    )
    system = build(problem)
    with pytest.raises(LoadError, match="cracks the rock by itself, most at"):
        next(march(problem, system))
    system.destroy()


def test_a_run_can_be_stopped_on_the_way_to_rest() -> None:
    problem = body(
        (1.0, 0.5), 0.1, sides=(LEFT, RIGHT), material=rock(ell=0.3),
        forces=Forces(prestress=lambda x: np.full((6, len(x[0])), 0.1) * PULLED[:, None]),
    )  # fmt: skip

    def stop() -> None:
        raise StoppedError("enough")

    system = build(problem)
    with pytest.raises(StoppedError):
        come_to_rest(problem, system, lambda sweep: stop())
    with pytest.raises(StoppedError):
        list(march(problem, system, Observers(pause=stop)))
    system.destroy()


def cracked(forces: Forces, split: str = "none", *, size=(1.0, 1.0), h=0.05, times=(1.0,), **more):
    """Half of a plate with a crack in the middle, a fluid in it."""
    crack = FlatCrack(center=(0.0, 0.5 + h / 4, 0.0), normal=(0.0, 1.0, 0.0), radius=0.3)
    material = rock(
        E=1.0, nu=0.2, ell=0.15, state="plane strain", cracks=(crack,), split=SPLITS[split]
    )
    return body(size, h, sides=(LEFT,), material=material, forces=forces, times=times, **more)


@pytest.mark.parametrize("split", ["none", "no-tension"])
def test_volume_and_pressure_in_a_crack(split: str) -> None:
    """The pressure that a volume takes holds just this volume open, and its work is V dp."""
    given, _ = last(cracked(Forces(crack_pressure=lambda t: 0.2 * t), split, times=(0.5, 1.0)))
    volume = given.energy.crack_volume()
    assert volume > 0.01
    held, step = last(cracked(Forces(crack_volume=lambda t: volume * t), split, times=(0.5, 1.0)))
    assert held.energy.crack_volume() == pytest.approx(volume, rel=1e-8)
    assert float(held.energy.external.pressure.value) == pytest.approx(0.2, rel=1e-3)
    assert step.energies.loads == pytest.approx(0.0, abs=1e-10)
    for system in (given, held):
        system.destroy()


def edge_crack(forces: Forces, **more) -> Problem:
    """A free plate with a crack from its left side."""
    crack = FlatCrack(center=(0.0, 0.51, 0.0), normal=(0.0, 1.0, 0.0), radius=0.4)
    material = rock(E=1.0, nu=0.2, ell=0.15, state="plane strain", cracks=(crack,))
    return body((1.0, 1.0), 0.05, material=material, forces=forces, **more)


def test_a_fluid_in_an_open_mouth_pushes_nothing_along() -> None:
    """The pins of a free body carry nothing, and a body that is moved holds no volume."""
    system, _ = last(edge_crack(Forces(crack_pressure=lambda t: 0.05)))
    assert np.abs(support_reactions(system.alternation)).max() < 1e-12
    system.state.u.x.array.reshape(-1, 2)[:] = [1.0, -2.0]
    assert abs(system.energy.crack_volume()) < 1e-12
    system.destroy()


def test_cold_rock_holds_no_volume() -> None:
    """A body that shrinks evenly opens no crack."""

    class Evenly:
        def temperature(self, x: np.ndarray, t: float) -> np.ndarray:
            return np.full(x.shape[1], -0.01)

    system, _ = last(edge_crack(Forces(crack_pressure=lambda t: 0.0), load=Evenly()))
    x = system.spaces.alpha.tabulate_dof_coordinates()[:, :2]
    system.state.u.x.array.reshape(-1, 2)[:] = -0.01 * x
    assert abs(system.energy.crack_volume()) < 1e-12
    system.destroy()


def test_a_fluid_does_not_pull() -> None:
    """A crack that is wider than its fluid fills has no pressure."""
    apart = (
        SideSupport(side="bottom", components={1: no_displacement}),
        SideSupport(side="top", components={1: lambda x, t: 0.02 * t}),
    )
    problem = edge_crack(Forces(crack_volume=lambda t: 1e-4 * t))
    system, step = last(replace(problem, sides=apart))
    assert step.energies.loads == 0.0
    assert float(system.energy.external.pressure.value) == 0.0
    assert system.energy.crack_volume() > 1e-3
    system.destroy()


def test_a_refused_guess_leaves_the_pressure_of_a_given_volume() -> None:
    system, step = last(edge_crack(Forces(crack_volume=lambda t: 1e-4 * t)))
    pressure, alpha = float(system.energy.external.pressure.value), system.state.alpha.x.array
    assert pressure > 0
    loads = Loads(time=step.time, values=system.supports.values(step.time))
    broken = 1 - alpha
    effort = _first_guess(system, loads, lambda: (broken, SolverStatistics()))
    assert effort == SolverStatistics(refused=1)
    assert float(system.energy.external.pressure.value) == pressure
    system.destroy()


def test_a_crack_s_own_pressure_counts_in_it() -> None:
    """Not that of the pores besides: with b = 1 and both alike it is as with pores alone."""
    pores = {"pore_pressure": lambda x, t: np.full(x.shape[1], 0.05), "biot": 1.0}
    volumes = []
    for forces in (Forces(**pores), Forces(**pores, crack_pressure=lambda t: 0.05)):
        system, _ = last(edge_crack(forces))
        volumes.append(system.energy.crack_volume())
        system.destroy()
    assert volumes[1] == pytest.approx(volumes[0], rel=1e-6)


@pytest.mark.parametrize("split", ["volumetric-deviatoric", "no-tension"])
def test_the_first_prediction_is_no_equilibrium(split: str) -> None:
    """A new prescribed displacement is solved for to the end: no force is left on what is free."""
    problem = edge_crack(Forces())
    pressed = (
        SideSupport(side="bottom", components={1: no_displacement}),
        SideSupport(side="top", components={1: lambda x, t: -0.01 * t}),
    )
    problem = replace(
        problem, sides=pressed, material=replace(problem.material, split=SPLITS[split])
    )
    system = build(problem)
    parts = system.alternation
    equilibrium(parts, system.supports.values(1.0))
    held = np.abs(support_reactions(parts)).max()
    forces = parts.u.duplicate()
    parts.forces(forces)
    free = np.delete(np.abs(forces.array_r), system.supports.fixed).max()
    forces.destroy()
    system.destroy()
    assert free < 1e-6 * held


def test_no_crack_to_fill() -> None:
    """A volume needs a crack that it opens."""
    problem = body((1.0, 0.5), 0.1, material=rock(ell=0.3), forces=Forces(crack_volume=lambda t: t))
    system = build(problem)
    with pytest.raises(Exception, match="no crack is open to the fluid"):
        next(march(problem, system))
    system.destroy()


@pytest.mark.parametrize(
    ("state", "split", "elasticity"),
    [
        ("plane stress", "no-tension", None),
        pytest.param("plane strain", "no-tension", None, marks=pytest.mark.long),
        ("plane stress", "volumetric-deviatoric", Isotropic(E=E, nu=NU)),
        pytest.param(
            *("plane strain", "volumetric-deviatoric", Isotropic(E=E, nu=NU)),
            marks=pytest.mark.long,
        ),
        pytest.param(
            *("solid", "volumetric-deviatoric", Isotropic(E=E, nu=NU)),
            marks=pytest.mark.long,
        ),
    ],
)
def test_stress(split: str, state: str, elasticity) -> None:
    """Stress of a body at rest: the prestress and the share of the pores, in every cell."""
    dim = 3 if state == "solid" else 2
    components = np.array([-0.5, 0.3, 0.2, 0.0, 0.0, 0.1])
    if state == "plane stress":
        components[2] = 0.0
    held = tuple(
        SideSupport(side=side, components=dict.fromkeys(range(dim), no_displacement))
        for side in ("left", "right", "bottom", "top", "front", "back")[: 2 * dim]
    )
    pores = None if state == "plane stress" else (lambda x, t: 0.4 + 0 * x[0])
    problem = body(
        (1.0, 0.5, 0.5)[:dim],
        0.25,
        sides=held,
        material=strong(state, split=SPLITS[split], elasticity=elasticity),
        forces=Forces(
            prestress=lambda x: components[:, None] + 0 * x[0], pore_pressure=pores, biot=0.7
        ),
    )
    system, _ = last(problem)
    xx, yy, zz, _, _, xy = components
    expected = np.array([[xx, xy, 0], [xy, yy, 0], [0, 0, zz]])
    assert system.energy.stress() == pytest.approx(
        np.broadcast_to(expected, (len(system.energy.stress()), 3, 3)), abs=2e-7
    )
    system.destroy()


def test_a_load_is_asked_once_for_each_end_of_a_step() -> None:
    """The work of a step looks at its two ends again and again."""
    asked = []

    def pressure(x: np.ndarray, t: float) -> np.ndarray:
        asked.append(t)
        return t * (1 + x[0])

    pores = Forces(pore_pressure=pressure, crack_field=pressure)
    system = build(body((1.0, 0.5), 0.25, material=strong("plane strain"), forces=pores))
    external = system.energy.external
    asked.clear()
    for t in (1.0, 2.0, 1.0, 2.0, 1.0):
        external.at(t)
        _, cracks = external.fields
        x = cracks.function_space.tabulate_dof_coordinates()
        assert cracks.x.array == pytest.approx(t * (1 + x[:, 0]))
    assert set(asked) == {1.0, 2.0} and asked == sorted(asked)
    system.destroy()
