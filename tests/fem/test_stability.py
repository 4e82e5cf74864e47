"""Second order: eigenvalues on space and cone, against closed forms and dense algebra."""

from dataclasses import replace
from math import pi, sqrt

from staffa.backend.stack import MPI, PETSc

import numpy as np
import pytest
import scipy.linalg

from staffa.errors import SolveError
from staffa.evolution import second_order
from staffa.evolution.equilibrate import raise_bounds
from staffa.evolution.march import Observers, march
from staffa.evolution.problem import Problem, SecondOrder
from staffa.evolution.saddle import go_along
from staffa.evolution.second_order import modes
from staffa.evolution.system import System, build
from staffa.minimize.alternate import equilibrium
from staffa.minimize.stability import Mode, SecondVariation, _Factored
from staffa.model.supports import GeneralizedPlaneStrain, SideSupport, no_displacement
from staffa.records.step import Stability, Step
from support.bodies import body, quench, rock, run

ELL = 0.1


def rayleigh(n: int, a: float = 1.0, b: float = 4.0, c: float = 8.0) -> SecondVariation:
    """int_0^1 a beta'^2 + b (v' - c beta)^2 on n linear elements, v = 0 at both ends."""
    h, ends = 1 / n, np.array([[-1.0, 1.0], [-1.0, 1.0]]) / 2
    bending, mass = np.array([[1, -1], [-1, 1]]) / h, h * np.array([[2, 1], [1, 2]]) / 6
    K, C, H = (PETSc.Mat().createAIJ((n + 1, n + 1), nnz=3, comm=MPI.COMM_SELF) for _ in range(3))
    for e in range(n):
        rows = [e, e + 1]
        K.setValues(rows, rows, b * bending, addv=True)
        C.setValues(rows, rows, -b * c * ends, addv=True)
        H.setValues(rows, rows, a * bending + b * c**2 * mass, addv=True)
    for matrix in (K, C, H):
        matrix.assemble()
    lumped = K.createVecRight()
    lumped.array_w[:] = h
    lumped.array_w[[0, n]] = h / 2
    return SecondVariation(
        stiffness=K,
        mixed=C,
        hessian=H,
        mass=lumped,
        fixed=np.array([0, n]),
        moved=np.zeros(0, dtype=int),
        modes=(),
        free=np.ones(n + 1, dtype=bool),
    )


def test_the_rayleigh_quotient_on_the_space_and_on_the_cone() -> None:
    """9.8696 = a pi^2 and 86.482, taken on a length .33782 (Leon Baldelli and Maurini 2021)."""
    n = 400
    variation = rayleigh(n)
    space = variation.on_the_space()
    cone = variation.on_the_cone(space)
    variation.destroy()
    assert space.value == pytest.approx(9.8696, rel=1e-3) and space.negative == 0
    assert cone.value == pytest.approx(86.482, rel=1e-3)
    assert cone.b.min() >= 0 and space.b.min() < 0 and cone.b.max() == pytest.approx(1)
    assert abs((cone.b > 1e-6).sum() / n - 0.33782) <= 2 / n
    assert space.value <= cone.value


def uniform(length: float, n: int = 120, alpha: float = 1e-6) -> System:
    """An AT1 bar at its strength, hardly damaged, and alike all over."""
    sides = (
        SideSupport(side="left", components={0: no_displacement}),
        SideSupport(side="right", components={0: lambda x, t: t}),
    )
    h = length / n
    material = rock(ell=ELL, nu=0.0, residual_stiffness=0.0)
    problem = body((length, h), h, sides=sides, material=material)
    system = build(problem)
    system.state.alpha.x.array[:] = alpha
    raise_bounds(problem.irreversibility, system)
    strain = sqrt(3 / (8 * ELL) / (1 - alpha))
    equilibrium(system.alternation, system.supports.values(strain * length))
    return system


def values(length: float) -> tuple[float, float | None]:
    """On the space, and on the cone."""
    system = uniform(length)
    space, cone = modes(system)
    system.destroy()
    return space.value, cone and cone.value


def onset(which: int) -> float:
    """Length over ell at which uniqueness (0) or stability (1) is lost: by a straight line."""
    lengths = ((2.5, 2.63), (3.38, 3.46))[which]
    low, high = (values(length * ELL)[which] for length in lengths)
    assert low > 0 > high
    return lengths[0] + (lengths[1] - lengths[0]) * low / (low - high)


@pytest.mark.parametrize("which", [0, 1], ids=["uniqueness", "stability"])
def test_a_bar_at_onset_loses_it_at_its_length(which: int) -> None:
    """2.57 ell and 3.42 ell, within 1 %."""
    assert onset(which) == pytest.approx((pi * sqrt(2 / 3), 3.42)[which], rel=0.01)


def dense(system: System) -> tuple[np.ndarray, np.ndarray]:
    """A and M of a system whose damage is free all over, by plain matrices."""
    energy, supports = system.energy, system.supports
    blocks = []
    for make, fill in (
        (energy.new_stiffness, energy.stiffness),
        (energy.new_mixed, energy.mixed),
        (energy.new_hessian, energy.hessian),
    ):
        matrix = make()
        fill(matrix)
        blocks.append(matrix.convert("dense").getDenseArray().copy())
        matrix.destroy()
    K, C, H = blocks
    held = np.concatenate([supports.fixed, supports.moved])
    ways = np.delete(np.eye(len(K)), held, axis=1)
    for mode in supports.modes:
        ways = np.column_stack([ways, np.where(np.isin(np.arange(len(K)), held), mode, 0.0)])
    A = np.block([[ways.T @ K @ ways, (C @ ways).T], [C @ ways, H]])
    mass = system.alternation.damage.unit.array_r
    return A, np.concatenate([np.zeros(ways.shape[1]), mass])


@pytest.mark.parametrize(
    "section", [None, GeneralizedPlaneStrain(bending=True)], ids=["free", "cell"]
)
def test_the_smallest_eigenvalue_and_the_inertia_are_those_of_dense_algebra(section) -> None:
    left = (SideSupport(side="left", components={0: no_displacement}),) if section else ()
    problem = body((0.4, 0.2), 0.05, material=rock(ell=0.1), sides=left, section=section)
    system = build(problem)
    rng = np.random.default_rng(1)
    alpha, u, T = (f.x.array for f in (system.state.alpha, system.state.u, system.state.T))
    alpha[:] = rng.uniform(0.2, 0.5, len(alpha))
    u[:] = rng.uniform(-0.4, 0.4, len(u))
    T[:] = 0.0
    A, M = dense(system)
    space, cone = modes(system)
    n_v = int((M == 0).sum())
    K, C, H = A[:n_v, :n_v], A[n_v:, :n_v], A[n_v:, n_v:]
    S = H - C @ np.linalg.solve(K, C.T)
    expected = scipy.linalg.eigvalsh(S, np.diag(M[n_v:]))
    assert space.value == pytest.approx(expected[0], rel=1e-6)
    assert space.negative == (expected < 0).sum() > 0
    assert cone.value >= space.value - 1e-9 * abs(space.value) and cone.b.min() >= 0
    quotient = cone.b @ S @ cone.b / (cone.b @ (M[n_v:] * cone.b))
    assert cone.value == pytest.approx(quotient, rel=1e-6)
    b = rng.uniform(0, 1, (2000, len(cone.b)))
    tried = np.einsum("ki,ij,kj->k", b, S, b) / np.einsum("ki,i,ki->k", b, M[n_v:], b)
    assert cone.value <= tried.min()
    system.destroy()


def perfect_bar(second_order: SecondOrder | None, length: float = 10 * ELL) -> Problem:
    """A bar with nothing to tell one place from another, pulled a little past its strength."""
    sides = (
        SideSupport(side="left", components={0: no_displacement}),
        SideSupport(side="right", components={0: lambda x, t: t * length}),
    )
    strain = sqrt(3 / (8 * ELL))
    return body(
        (length, 0.05),
        0.025,
        sides=sides,
        material=rock(ell=ELL, nu=0.0),
        times=(0.9 * strain, 1.02 * strain),
        second_order=second_order,
    )


def test_an_unstable_state_is_reported_and_left_when_asked() -> None:
    sound, damaged = run(perfect_bar(SecondOrder(kind="report")))
    assert sound.stability == Stability(bifurcation=None, stability=None, negative=0)
    assert damaged.stability.escapes == 0 and damaged.stability.negative > 0
    assert damaged.stability.bifurcation < damaged.stability.stability < -0.1
    _, left = run(perfect_bar(SecondOrder(kind="follow")))
    assert left.stability.escapes > 0
    assert left.stability.stability is None or left.stability.stability > -1e-3
    assert left.energies.total < 0.7 * damaged.energies.total
    assert left.audit.violations == (), left.audit.violations


def test_a_run_can_be_stopped_at_each_sweep_after_a_state_was_left() -> None:
    problem, seen = perfect_bar(SecondOrder(kind="follow")), []
    system = build(problem)
    watch = Observers(watch=lambda moment, sweep: seen.append(moment.index))
    steps = list(march(problem, system, watch))
    system.destroy()
    assert steps[1].stability.escapes > 0
    assert [seen.count(step.index) for step in steps] == [step.sweeps for step in steps]


def test_a_short_bar_softens_alike_all_over_and_is_stable() -> None:
    _, damaged = run(perfect_bar(SecondOrder(kind="follow"), length=2 * ELL))
    assert damaged.stability.escapes == 0
    assert damaged.stability.bifurcation > 0 and damaged.stability.stability is None


def test_leaving_respects_the_bounds_and_lowers_the_energy() -> None:
    system = uniform(6 * ELL, n=60, alpha=0.05)
    _, cone = modes(system)
    before = system.energy.total()
    assert cone.value < 0 and go_along(system, cone.v, cone.b)
    alpha, lower = system.state.alpha.x.array, system.bounds.lower.x.array
    assert system.energy.total() < before
    assert np.all(alpha >= lower) and np.all(alpha <= 1) and alpha.max() > 0.06
    system.destroy()


def test_a_way_up_is_not_taken() -> None:
    system = uniform(1.5 * ELL, n=30, alpha=0.05)
    space, _ = modes(system)
    assert space.value > 0
    kept = system.state.alpha.x.array.copy()
    still = Mode(value=space.value, v=space.v, b=np.abs(space.b))
    assert not go_along(system, still.v, still.b)
    assert np.array_equal(system.state.alpha.x.array, kept)
    system.destroy()


def test_a_second_order_that_is_not_found_loses_no_step(monkeypatch) -> None:
    def fails(system):
        raise SolveError("no eigenvalue")

    expected = run(perfect_bar(None))
    monkeypatch.setattr(second_order, "modes", fails)
    found = run(perfect_bar(SecondOrder(kind="follow")))
    assert [s.status for s in found] == ["converged"] * 2
    assert [s.energies for s in found] == [s.energies for s in expected]
    assert all(s.stability.failure == "no eigenvalue" for s in found)
    assert all("second order was not found" in s.audit.violations[0] for s in found)


def test_the_record_is_read_back() -> None:
    step = run(perfect_bar(SecondOrder(kind="report")))[-1]
    assert Step.from_record(step.to_record()).stability == step.stability


def plate() -> Problem:
    """A cooled plate, damaged along its face."""
    material = rock(ell=0.1, toughness=lambda x: 1 + 0.1 * np.cos(7 * x[0] + 1))
    problem = body((1.0, 0.5), 0.05, material=material, load=quench(6.0), times=(0.001, 0.002))
    return replace(problem, second_order=SecondOrder(kind="report"))


def test_a_face_whose_points_hardly_feel_one_another_has_a_smallest_eigenvalue() -> None:
    """At the very onset all values are about the same: Hessian of the damage over its mass."""
    sides = tuple(
        SideSupport(side=side, components={0: no_displacement}) for side in ("left", "right")
    )
    (step,) = run(
        body(
            (4.0, 0.6),
            0.04,
            load=quench(2.4),
            material=rock(ell=0.12),
            sides=sides,
            times=(4e-4,),
            second_order=SecondOrder(kind="report"),
        )
    )
    found = step.stability
    assert found is not None and found.failure is None, found
    assert found.negative == 0 and 30 < found.bifurcation < 40, found


def test_a_solver_that_breaks_off_within_slepc_loses_no_step(monkeypatch) -> None:
    """SLEPc cannot free what it broke off in: its words must not replace the reason."""
    calls, solve = [], _Factored._solve

    def failing(self, y) -> None:
        calls.append(1)
        if len(calls) > 3:
            raise SolveError("told to fail")
        solve(self, y)

    monkeypatch.setattr(_Factored, "_solve", failing)
    sides = tuple(
        SideSupport(side=side, components={0: no_displacement}) for side in ("left", "right")
    )
    problem = body(
        (1.0, 0.5),
        0.05,
        load=quench(6.0),
        material=rock(ell=0.15),
        sides=sides,
        times=(4e-4,),
        second_order=SecondOrder(kind="report"),
    )
    (step,) = run(problem)
    assert step.status == "converged" and len(calls) > 3
    assert step.stability is not None and "was not found" in step.stability.failure
