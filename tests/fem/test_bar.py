"""A bar in traction, flat and solid: strength, dissipated energy, damage profile of AT1, AT2."""

from staffa.backend.stack import MPI

import numpy as np
import pytest

from staffa.backend.parallel import max_over_ranks
from staffa.evolution.effective_toughness import effective_gc
from staffa.evolution.march import march
from staffa.evolution.problem import Problem
from staffa.evolution.system import System, build
from staffa.minimize.alternate import support_reactions
from staffa.model.domain import block
from staffa.model.fields import vertices
from staffa.model.supports import SideSupport, no_displacement
from staffa.physics.damage import LAWS, damage_at_strength, strength
from staffa.records.step import Step, Stop
from support.bodies import body, rock

LENGTH, HEIGHT, E, ELL, H = 1.0, 0.3, 100.0, 0.1, 1 / 51  # a cell, not a vertex, in the middle
STRENGTH = {name: strength(law, E=E, Gc=1.0, ell=ELL) for name, law in LAWS.items()}
STRAIN = {name: STRENGTH[name] / (E * law.a(damage_at_strength(law))) for name, law in LAWS.items()}


def weaker_middle(x: np.ndarray) -> np.ndarray:
    """A crack at a loaded end costs half: a middle weaker by 1 % keeps it away from there."""
    return np.where(np.abs(x[0] - LENGTH / 2) < ELL, 0.99, 1.0)


def material(law: str, **changes):
    return rock(E=E, nu=0.3, ell=ELL, law=LAWS[law], **changes)


def bar(law: str, cells: str, strains, **changes) -> Problem:
    pulled = (
        SideSupport(side="left", components={0: no_displacement}),
        SideSupport(side="right", components={0: lambda x, t: t * LENGTH}),
    )
    return body(
        (LENGTH, HEIGHT),
        H,
        cells=cells,
        sides=pulled,
        times=tuple(strains),
        material=material(law, **changes),
        stop=Stop(change=1e-5, residual=1e-3),
    )


def pull(problem: Problem) -> tuple[list[Step], list[float], System]:
    """The steps, and the mean stress on the right side at each."""
    system = build(problem)
    steps, stresses = [], []
    for step in march(problem, system):
        forces = support_reactions(system.alternation)
        moving = system.supports.values(1.0) > 0
        steps.append(step)
        stresses.append(forces[moving].sum() / HEIGHT)
    return steps, stresses, system


def test_strengths_of_at1_and_at2_are_those_of_theory() -> None:
    """sqrt(3 Gc E/(8 ell)) at once; (3/16) sqrt(3 E Gc/ell) at alpha = 1/4, where a = 9/16."""
    at1, at2 = np.sqrt(3 * E / (8 * ELL)), 3 / 16 * np.sqrt(3 * E / ELL)
    assert [STRENGTH["AT1"], STRENGTH["AT2"]] == pytest.approx([at1, at2], rel=1e-6)
    assert [STRAIN["AT1"], STRAIN["AT2"]] == pytest.approx([at1 / E, at2 / E * 16 / 9], rel=1e-3)


@pytest.mark.parametrize("law", LAWS)
def test_strength(law: str) -> None:
    """The largest stress over steps of 0.25 % of the critical strain, within 0.5 %."""
    strains = STRAIN[law] * np.arange(0.98, 1.02, 0.0025)
    _, stresses, system = pull(bar(law, "quadrilateral", strains))
    system.destroy()
    assert max(stresses) == pytest.approx(STRENGTH[law], rel=0.005)


@pytest.mark.parametrize("cells", ["quadrilateral", "triangle"])
@pytest.mark.parametrize("law", ["AT1", "AT2"])
def test_broken_bar(law: str, cells: str) -> None:
    """Once broken, the bar has paid for one crack of its height: measured toughness, to 1 %."""
    # From sound to broken in one step: damage before the crack would stay, and be paid for too.
    strains = STRAIN[law] * np.array([0.05, 1.5, 4.0])
    problem = bar(law, cells, strains, toughness=weaker_middle)
    steps, stresses, system = pull(problem)
    assert abs(stresses[-1]) < 0.01 * STRENGTH[law]
    factor = effective_gc(problem.material, dim=2, h=H, cells=cells)
    paid = system.energy.crack_length()
    assert paid == pytest.approx(HEIGHT * factor, rel=0.01), f"{paid / HEIGHT:.4f}, {factor:.4f}"
    # What is left is the residual stiffness stretched: k_res E opening^2/(2 h) = 1.5e-3, by hand.
    assert steps[-1].energies.elastic < 5e-3 * steps[-1].energies.surface
    check_profile(law, system)
    system.destroy()


def check_profile(law: str, system: System) -> None:
    """(1 - r/(2 ell))^2 for AT1, exp(-r/ell) for AT2, r from the edge of the broken cells."""
    x, alpha = vertices(system.spaces.alpha), system.state.alpha.x.array
    row = np.abs(x[:, 1] - HEIGHT / 2) < H / 2 - 1e-9
    x, alpha = x[row, 0], alpha[row]
    broken = x[alpha > 0.99]
    r = np.maximum(np.maximum(broken.min() - x, x - broken.max()), 0.0)
    exact = np.maximum(1 - r / (2 * ELL), 0) ** 2 if law == "AT1" else np.exp(-r / ELL)
    error = np.abs(alpha - exact).max()
    assert error < 0.03, f"profile off by {error:.3f}"


# A solid bar that is thinner, on cells that are coarser: seconds. `make verify ONLY=solid-bar` has
# the whole section.
THIN, COARSE = 0.12, 1 / 25


def solid_bar(cells: str, strains, **changes) -> Problem:
    """Pulled along x, its other sides free; AT1."""
    pulled = (
        SideSupport(side="left", components={0: no_displacement}),
        SideSupport(side="right", components={0: lambda x, t: t * LENGTH}),
    )
    return body(
        (LENGTH, THIN, THIN),
        COARSE,
        cells=cells,
        sides=pulled,
        times=tuple(strains),
        material=rock(E=E, nu=0.3, ell=ELL, law=LAWS["AT1"], state="solid", **changes),
        stop=Stop(change=1e-5, residual=1e-3),
        displacement="iterative",
    )


@pytest.mark.parametrize("cells", ["hexahedron", "tetrahedron"])
def test_a_solid_bar_is_elastic_up_to_its_strength(cells: str) -> None:
    """Uniaxial stress whatever the section: E times the strain, and damage from 19.365 on."""
    strains = STRAIN["AT1"] * np.array([0.5, 0.99, 1.03])
    system = build(problem := solid_bar(cells, strains))
    damage, stresses = [], []
    for _ in march(problem, system):
        moving = system.supports.values(1.0) > 0
        forces = support_reactions(system.alternation)[moving].sum()
        stresses.append(system.state.u.function_space.mesh.comm.allreduce(forces) / THIN**2)
        damage.append(max_over_ranks(MPI.COMM_WORLD, system.state.alpha.x.array))
    system.destroy()
    assert stresses[:2] == pytest.approx(E * strains[:2], rel=1e-4)
    assert damage[0] == damage[1] == 0 < damage[2], f"{damage}"


@pytest.mark.slow
@pytest.mark.parametrize("cells", ["hexahedron", "tetrahedron"])
def test_a_broken_solid_bar_has_paid_for_its_section(cells: str) -> None:
    """One plane crack across, of the measured toughness, to 1 %; no force is left."""
    strains = STRAIN["AT1"] * np.array([0.05, 1.5, 4.0])
    problem = solid_bar(cells, strains, toughness=weaker_middle)
    system = build(problem)
    steps = list(march(problem, system))
    moving = system.supports.values(1.0) > 0
    stress = support_reactions(system.alternation)[moving].sum() / THIN**2
    assert abs(stress) < 0.01 * STRENGTH["AT1"], f"{stress}"
    factor = effective_gc(problem.material, dim=3, h=COARSE, cells=cells)
    paid = system.energy.crack_length() / THIN**2
    assert paid == pytest.approx(factor, rel=0.01), f"{paid:.4f}, {factor:.4f}"
    assert steps[-1].energies.elastic < 1e-2 * steps[-1].energies.surface
    assert half_width(system) == pytest.approx(2 * ELL, abs=COARSE), "(1 - r/(2 ell))^2 ends"
    system.destroy()


def half_width(system: System) -> float:
    """Reach of the damage beyond the broken cells."""
    x, alpha = vertices(system.spaces.alpha)[:, 0], system.state.alpha.x.array
    broken, damaged = x[alpha > 0.99], x[alpha > 1e-3]
    return max(broken.min() - damaged.min(), damaged.max() - broken.max())


@pytest.mark.parametrize("law", ["AT1", "AT2"])
@pytest.mark.parametrize("cells", ["quadrilateral", "triangle", "hexahedron", "tetrahedron"])
def test_effective_gc_is_near_its_first_guess(law: str, cells: str) -> None:
    """1 + h/(4 c_w ell), from the plateau of a broken cell; the rest is the profile's error."""
    dim = 2 if cells in ("quadrilateral", "triangle") else 3
    ell = ELL
    for h in (ELL / 3, ELL / 6):
        factor = effective_gc(material(law), dim=dim, h=h, cells=cells)
        guess = 1 + h / (4 * LAWS[law].c_w * ell)
        assert abs(factor - guess) < 0.3 * (guess - 1), f"h = ell/{ell / h:.0f}: {factor}, {guess}"


def test_cells_far_smaller_than_ell_are_no_obstacle() -> None:
    """The free boundary of the damage moves by one of 64 cells in an iteration."""
    found = effective_gc(rock(ell=1.0, law=LAWS["AT1"]), dim=2, h=1 / 64, cells="quadrilateral")
    assert found == pytest.approx(1 + 3 / (8 * 64), rel=1e-4)


def test_effective_gc_agrees_between_ranks() -> None:
    """It is measured on one rank's own strip: the same number everywhere."""
    domain = block(MPI.COMM_WORLD, size=(1.0, 1.0), h=0.5, cells="quadrilateral")
    factor = effective_gc(material("AT1"), dim=2, h=H, cells="quadrilateral")
    assert domain.comm.allreduce(factor, op=MPI.MAX) == factor
