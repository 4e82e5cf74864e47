"""Rock with directions: patch tests, turned bodies, isotropic stiffnesses, layers."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from staffa.backend.stack import MPI

import numpy as np
import pytest

from fem.test_turning import roughness
from staffa.case.reading.read import parse_case
from staffa.evolution.coefficients import energy_of
from staffa.evolution.march import march
from staffa.evolution.problem import Material, Problem
from staffa.evolution.system import build
from staffa.minimize.alternate import equilibrium
from staffa.model.domain import block
from staffa.model.energy import Energy
from staffa.model.fields import linear_spaces, vertices, zero_state
from staffa.model.supports import SideSupport, no_displacement
from staffa.physics.damage import AT2
from staffa.physics.elasticity import (
    Elasticity,
    Full,
    Isotropic,
    Orthotropic,
    TransverselyIsotropic,
)
from staffa.physics.split import SPLITS
from staffa.setup.build import problem as problem_of
from support.bodies import body, quench, rock
from unit.test_elasticity import SHALE, WOOD, rotation, some_stiffness, voigt

E, NU = 3.0, 0.25
CLASSES: dict[str, Elasticity | None] = {
    "E and nu": None,
    "isotropic": Isotropic(E=E, nu=NU),
    "transversely isotropic": TransverselyIsotropic(**SHALE, axes=rotation(1)),
    "orthotropic": Orthotropic(**WOOD, axes=rotation(2)),
    "full": Full(C=some_stiffness(3), axes=rotation(3)),
}
# Isotropic rock has five splits, in two of which principal strains make large forms.
MANY_FORMS = ("E and nu", "isotropic")
NAMES = [pytest.param(n, marks=pytest.mark.long) if n in MANY_FORMS else n for n in CLASSES]
STATES = {"plane stress": 2, "plane strain": 2, "solid": 3}
ROUND_OFF = 1e-12  # of sums over some hundred cells
# Any gradient of displacement, and any tensors: no symmetry helps.
GRADIENT = np.array([[0.3, -0.5, 0.2], [0.1, -0.4, 0.6], [-0.3, 0.25, 0.7]])
EXPANSION = np.array([[0.4, 0.1, -0.2], [0.1, 0.7, 0.15], [-0.2, 0.15, 0.5]])
ROUGHNESS = np.array([[1.7, 0.4, 0.3], [0.4, 1.2, -0.2], [0.3, -0.2, 2.5]])
OUT_OF_PLANE, IN_PLANE = [2, 3, 4], [0, 1, 5]


def tensor(stress: np.ndarray) -> np.ndarray:
    """The tensor of a stress in Voigt's order, 3 x 3."""
    xx, yy, zz, yz, xz, xy = stress
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def answer(C: np.ndarray, e: np.ndarray, state: str) -> tuple[float, np.ndarray]:
    """Energy density and stress of a strain, 3 x 3; in plane stress the strains across the plane
    are those that leave no stress there."""
    strain = voigt(e)
    if state == "plane stress":
        across = np.ix_(OUT_OF_PLANE, OUT_OF_PLANE)
        pull = C[np.ix_(OUT_OF_PLANE, IN_PLANE)] @ strain[IN_PLANE]
        strain[OUT_OF_PLANE] = -np.linalg.solve(C[across], pull)
    stress = C @ strain
    return float(strain @ stress) / 2, tensor(stress)


def in_state(gradient: np.ndarray, state: str) -> np.ndarray:
    """The strain of a displacement gradient; in plane bodies nothing depends on z."""
    e = (gradient + gradient.T) / 2
    if STATES[state] == 2:
        e[2, :] = e[:, 2] = 0.0
    return e


def warp(mesh) -> None:
    """Move the inner vertices, so that no two cells are alike."""
    x = mesh.geometry.x
    inside = np.prod(np.sin(np.pi * x[:, : mesh.geometry.dim]), axis=1)[:, None]
    x += 0.08 * inside * np.sin(np.array([5.0, 7.0, 3.0]) * x[:, [1, 2, 0]] + x[:, [2, 0, 1]])
    if mesh.geometry.dim == 2:
        x[:, 2] = 0.0


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("name", NAMES)
def test_patch(name: str, state: str) -> None:
    """Linear displacements of all the boundary, with some cold: exact within, on warped cells."""
    dim, T = STATES[state], -0.3

    def moved(axis: int) -> Callable[[np.ndarray, float], np.ndarray]:
        return lambda x, t: GRADIENT[axis, :dim] @ x[:dim]

    sides = ("left", "right", "bottom", "top", "front", "back")[: 2 * dim]
    problem = body(
        (1.0,) * dim,
        0.25,
        sides=tuple(
            SideSupport(side=s, components={a: moved(a) for a in range(dim)}) for s in sides
        ),
        material=rock(
            E=E,
            nu=NU,
            elasticity=CLASSES[name],
            expansion=EXPANSION,
            roughness=ROUGHNESS,
            state=state,
            residual_stiffness=0.0,
        ),
    )
    warp(problem.domain.mesh)
    system = build(problem)
    try:
        system.state.T.x.array[:] = T
        equilibrium(system.alternation, system.supports.values(1.0))
        x, u = vertices(system.spaces.alpha), system.state.u.x.array.reshape(-1, dim)
        exact = x[:, :dim] @ GRADIENT[:dim, :dim].T
        assert np.abs(u - exact).max() < ROUND_OFF
        C = (CLASSES[name] or Isotropic(E=E, nu=NU)).stiffness(np.zeros((3, 1)))[0]
        density, stress = answer(C, in_state(GRADIENT, state) - T * EXPANSION, state)
        assert system.energy.energies().elastic == pytest.approx(density, rel=ROUND_OFF)
        found = system.energy.stress()
        assert found == pytest.approx(np.broadcast_to(stress, found.shape), abs=1e-12 * C.max())
    finally:
        system.destroy()


def turned(material: Material, Q: np.ndarray) -> Material:
    """The same rock turned by Q, whose columns are where x, y, z go."""
    elasticity = material.elasticity
    if elasticity is not None and not isinstance(elasticity, Isotropic):
        elasticity = replace(elasticity, axes=elasticity.axes @ Q.T)
    return replace(
        material,
        elasticity=elasticity,
        expansion=Q @ EXPANSION @ Q.T,
        roughness=Q @ ROUGHNESS @ Q.T,
    )


@dataclass(frozen=True, kw_only=True)
class Turn:
    """x goes to Q x + shift; `size` is that of the body afterwards."""

    Q: np.ndarray
    shift: np.ndarray
    size: tuple[float, ...]


SIZES = {2: (1.0, 0.5), 3: (1.0, 0.5, 0.75)}
UNTURNED = {dim: Turn(Q=np.eye(3), shift=np.zeros(3), size=size) for dim, size in SIZES.items()}
# A quarter turn about z; in space also one that sends x to y, y to z and z to x.
QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
CYCLE = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
TURNS = {
    2: [Turn(Q=QUARTER, shift=np.array([0.5, 0.0, 0.0]), size=(0.5, 1.0))],
    3: [
        Turn(Q=QUARTER, shift=np.array([0.5, 0.0, 0.0]), size=(0.5, 1.0, 0.75)),
        Turn(Q=CYCLE, shift=np.zeros(3), size=(0.75, 1.0, 0.5)),
    ],
}


def some_fields(x: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Displacement, damage and temperature at points, shape (n, 3): without any symmetry."""
    waves = np.sin(x @ rotation(5) * 3 + np.array([0.3, 1.1, 2.0]))
    return waves @ GRADIENT, 0.4 + 0.35 * np.cos(4 * waves[:, 0]), waves[:, 1] - 0.5


def energy_at(material: Material, turn: Turn) -> Energy:
    """The energy of the turned body, with the same fields, turned with it."""
    dim = len(turn.size)
    problem = body(turn.size, 0.25, material=turned(material, turn.Q))
    spaces = linear_spaces(problem.domain)
    state = zero_state(spaces)
    u, alpha, T = some_fields((vertices(spaces.alpha) - turn.shift) @ turn.Q)
    if dim == 2:
        u[:, 2] = 0.0
    state.u.x.array[:] = (u @ turn.Q.T)[:, :dim].ravel()
    state.alpha.x.array[:], state.T.x.array[:] = alpha, T
    energy = energy_of(problem, spaces, state)
    energy.direction.x.array[:] = T
    return energy


def readings(energy: Energy) -> list[float]:
    """Numbers that no turn may change: energies, power, and the sizes of forces on u and alpha."""
    found = energy.energies()
    forces = []
    for fill, matrix in (
        (energy.residual, energy.new_stiffness()),
        (energy.gradient, energy.new_hessian()),
    ):
        matrix.assemble()
        vector = matrix.createVecRight()
        fill(vector)
        forces.append(vector.norm())
        vector.destroy()
        matrix.destroy()
    return [found.elastic, found.surface, energy.thermal_power(), *forces]


def splits(name: str, state: str) -> tuple[str, ...]:
    """Of any rock, and of isotropic rock alone; in space these take minutes to compile."""
    both = ("none", "volumetric-deviatoric")
    return (*both, "spectral", "no-tension") if name == "E and nu" and state != "solid" else both


@pytest.mark.parametrize("state", STATES)
@pytest.mark.parametrize("name", NAMES)
def test_a_turned_body_has_the_same_energy_and_forces(name: str, state: str) -> None:
    """A block turns into a block: elastic and surface energy, heat, forces, with each split."""
    dim = STATES[state]
    for split in splits(name, state):
        material = rock(
            E=E, nu=NU, elasticity=CLASSES[name], state=state, split=SPLITS[split], ell=0.3
        )
        before = readings(energy_at(material, UNTURNED[dim]))
        for turn in TURNS[dim]:
            after = readings(energy_at(material, turn))
            assert after == pytest.approx(before, rel=ROUND_OFF), split


def uniform_energy(material: Material, Q: np.ndarray) -> float:
    """Elastic energy of a block in the same body, strained, damaged and cold alike everywhere; the
    rock and its strain turned by Q."""
    dim = 3 if material.state == "solid" else 2
    problem = body((1.0,) * dim, 0.5, material=turned(material, Q))
    spaces = linear_spaces(problem.domain)
    state = zero_state(spaces)
    gradient = GRADIENT.copy()
    if dim == 2:
        gradient[2, :] = gradient[:, 2] = 0.0
    x = vertices(spaces.alpha)
    state.u.x.array[:] = (x @ (Q @ gradient @ Q.T).T)[:, :dim].ravel()
    state.alpha.x.array[:], state.T.x.array[:] = 0.4, 0.5
    return energy_of(problem, spaces, state).energies().elastic


@pytest.mark.parametrize(
    "state", [pytest.param(s, marks=pytest.mark.long) if s != "solid" else s for s in STATES]
)
@pytest.mark.parametrize("name", CLASSES)
def test_a_strain_turned_by_any_angle_with_the_rock_costs_the_same(name: str, state: str) -> None:
    c, s = np.cos(0.7), np.sin(0.7)
    Q = rotation(8) if state == "solid" else np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    for split in splits(name, state):
        material = rock(E=E, nu=NU, elasticity=CLASSES[name], state=state, split=SPLITS[split])
        before, after = (uniform_energy(material, turn) for turn in (np.eye(3), Q))
        assert after == pytest.approx(before, rel=ROUND_OFF), split


@pytest.mark.parametrize("angle", [0.0, 30.0, 90.0])
def test_a_drawn_crack_has_its_length_whatever_it_costs(angle: float) -> None:
    """A band across the body with AT2's profile, sqrt(n . A n) ell wide: Gc sqrt(n . A n) a unit of
    length in energy, and the length of the body's height by `crack_length`."""
    A = roughness(2.0, angle)
    cost, ell, height = np.sqrt(A[0, 0]), 0.05, 0.4
    problem = body((1.5, height), ell / 10, material=rock(ell=ell, law=AT2(), Gc=3.0, roughness=A))
    spaces = linear_spaces(problem.domain)
    state = zero_state(spaces)
    state.alpha.x.array[:] = np.exp(-np.abs(vertices(spaces.alpha)[:, 0] - 0.75) / (cost * ell))
    energy = energy_of(problem, spaces, state)
    assert energy.energies().surface == pytest.approx(3.0 * cost * height, rel=0.005)
    assert energy.crack_length() == pytest.approx(height, rel=0.005)


# A cooled plate whose first cracks come in few steps.
CRACKING = """
[domain]
size = [1.0, 0.5]
h = 0.04
[damage]
ell = 0.12
[temperature]
dT = 4.0
[supports]
left = "rollers"
right = "rollers"
[toughness]
amplitude = 0.2
seed = 2
[time]
t = [0.0005, 0.002, 0.005, 0.01]
"""
STRAIN_SPLIT = ('material.plane="strain"', 'damage.split="volumetric-deviatoric"')


@pytest.mark.slow
@pytest.mark.parametrize(
    "settings", [(), STRAIN_SPLIT], ids=["plane stress", "split, plane strain"]
)
def test_a_full_stiffness_that_is_isotropic_gives_the_isotropic_run(settings) -> None:
    """Energies, damage and displacement of a cracking plate, step by step."""
    C = Isotropic(E=1.0, nu=0.2).stiffness(np.zeros((3, 1)))[0].tolist()
    runs = []
    for stiffness in ((), (f"material.stiffness={C}",)):
        problem = problem_of(parse_case(CRACKING, (*settings, *stiffness)), comm=MPI.COMM_SELF)
        assert (problem.material.elasticity is None) == (not stiffness)
        system = build(problem)
        alpha, u = system.state.alpha.x.array, system.state.u.x.array
        runs.append(
            [
                (step.energies.elastic, step.energies.surface, alpha.copy(), u.copy())
                for step in march(problem, system)
            ]
        )
        system.destroy()
        assert alpha.max() > 0.99, "it cracks"
    for quantities in zip(*runs, strict=True):
        for same, expected in zip(*quantities, strict=True):
            assert np.abs(same - expected).max() <= 1e-10 * np.abs(expected).max()


HALVES = {"left half": lambda x: x[0] < 0.5, "right half": lambda x: x[0] > 0.5}


def layered(comm: MPI.Comm = MPI.COMM_SELF, **more) -> Problem:
    """A plate of two rocks side by side, the left one orthotropic, its first axis along y, and of
    another expansion along each."""
    problem = body((1.0, 0.5), 0.125, comm=comm, material=rock(E=E, nu=NU), **more)
    domain = block(comm, size=(1.0, 0.5), h=0.125, cells="quadrilateral", parts=HALVES)
    left = replace(
        problem.material,
        elasticity=Orthotropic(**WOOD, axes=np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])),
        expansion=np.diag([0.2, 0.5, 0.3]),
    )
    return replace(problem, domain=domain, regions={"left half": left})


def test_layers_in_series_share_the_stretch() -> None:
    """Held above and below, pulled and cold: one stress in both, linear displacement in each."""
    T, pull = -0.05, 0.02
    sides = (
        SideSupport(side="left", components={0: no_displacement}),
        SideSupport(side="right", components={0: lambda x, t: pull}),
        *(SideSupport(side=s, components={1: no_displacement}) for s in ("bottom", "top")),
    )
    problem = layered(sides=sides)
    system = build(problem)
    try:
        system.state.T.x.array[:] = T
        equilibrium(system.alternation, system.supports.values(1.0))
        # sigma = M (e - f): M and f from the reduced stiffness of each half by hand.
        (E1, E2, _), (nu12, _, _) = WOOD["E"], WOOD["nu"]
        nu21 = nu12 * E2 / E1
        M = np.array([E2 / (1 - nu12 * nu21), E / (1 - NU**2)])
        free = T * np.array([0.2 + nu12 * 0.5, 1 + NU])
        stress = (pull - free.mean()) / (0.5 / M).sum()
        e = stress / M + free
        x, u = vertices(system.spaces.alpha)[:, 0], system.state.u.x.array.reshape(-1, 2)
        exact = np.where(x < 0.5, e[0] * x, pull - e[1] * (1 - x))
        assert u[:, 0] == pytest.approx(exact, abs=1e-12)
        assert system.energy.stress()[:, 0, 0] == pytest.approx(stress * (1 + 1e-6), rel=1e-9)
    finally:
        system.destroy()


def cooled(comm: MPI.Comm) -> Problem:
    """The layers, their toughness with directions too, cooled from below until they crack."""
    sides = tuple(SideSupport(side=s, components={0: no_displacement}) for s in ("left", "right"))
    problem = layered(comm, sides=sides, load=quench(8.0), times=(0.002, 0.01))
    rocks = {name: replace(m, roughness=ROUGHNESS) for name, m in problem.regions.items()}
    return replace(problem, regions=rocks)


def single(comm: MPI.Comm) -> Problem:
    """One cell, stretched."""
    sides = tuple(
        SideSupport(side=side, components={0: lambda x, t: 0.01 * x[0]})
        for side in ("left", "right")
    )
    material = rock(elasticity=CLASSES["full"], expansion=EXPANSION, roughness=ROUGHNESS)
    return body((1.0, 1.0), 1.0, comm=comm, sides=sides, material=material)
