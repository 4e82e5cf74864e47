"""Minimizers keep their promises, and say so when they cannot."""

from contextlib import contextmanager
from dataclasses import replace

from staffa.backend.stack import PETSc

import numpy as np
import pytest

from staffa.backend.petsc_options import DAMAGE
from staffa.errors import SolveError
from staffa.evolution.apply_loads import change_loads
from staffa.evolution.equilibrate import Loads
from staffa.evolution.march import Observers, march
from staffa.evolution.problem import Irreversibility
from staffa.evolution.system import System, build
from staffa.loads.closed_form import Face, HalfSpace
from staffa.minimize.alternate import alternate, equilibrium
from staffa.minimize.bounded import BoundedEnergy, projected_gradient
from staffa.model.fields import owned
from staffa.model.supports import SideSupport, no_displacement
from staffa.physics.damage import AT2, LAWS
from staffa.records.step import Stop
from support.bodies import body, quench, rock

TIMES = (0.0025, 0.01, 0.0225)


def cooled(**changes):
    """A plate that cracks under a severe quench in a second or two."""
    fields = {
        "load": quench(8.0),
        "times": TIMES,
        "material": rock(ell=0.08, toughness=uneven),
        "anchor": "top",
        "face": Face(axis=1, position=0.0, inward=1),
    }
    return body((1.0, 0.5), 0.04, **{**fields, **changes})


def uneven(x: np.ndarray) -> np.ndarray:
    """A toughness that favors some places, so that no round-off decides."""
    return 1 + 0.1 * np.cos(7 * x[0] + 1)


def damage_problem(system: System):
    """The damage at a displacement that strains the body, from 0 upwards."""
    parts, bounds = system.alternation, system.bounds
    return parts, bounds.lower.x.petsc_vec, bounds.upper.x.petsc_vec


@pytest.mark.parametrize("law", ["AT1", "AT2"])
@pytest.mark.parametrize("solver", ["tao", "snes"])
def test_damage_is_at_a_first_order_minimum(solver: str, law: str) -> None:
    problem = cooled(damage=solver, material=rock(ell=0.08, law=LAWS[law], toughness=uneven))
    system = build(problem)
    parts, lower, upper = damage_problem(system)
    values = np.zeros(len(system.supports.fixed))
    equilibrium(parts, values)
    change_loads(
        problem, system, Loads(time=0.0, values=values), Loads(time=TIMES[0], values=values)
    )
    first = parts.bounded[0]
    first.minimize(parts.alpha, lower, upper)
    alpha = parts.alpha.array_r
    assert alpha.max() > 0.2 and first.iterations > 0
    assert np.all((alpha >= 0) & (alpha <= 1))
    force = projected_gradient(parts.damage, parts.alpha, lower, upper, parts.work)
    assert force <= 1e-4, f"projected gradient {force:.1e} against the 1e-4 asked for"
    system.destroy()


def test_both_damage_solvers_give_the_same_run() -> None:
    tight = Stop(change=1e-6, residual=1e-4)
    energies = {}
    for solver in ("tao", "snes"):
        system = build(problem := cooled(damage=solver, stop=tight))
        energies[solver] = [step.energies.total for step in march(problem, system)]
        system.destroy()
    assert energies["tao"] == pytest.approx(energies["snes"], rel=1e-6)


def test_direct_and_iterative_displacements_give_the_same_run() -> None:
    tight = Stop(change=1e-6, residual=1e-4)
    energies = {}
    for solver in ("direct", "iterative"):
        system = build(problem := cooled(displacement=solver, stop=tight))
        assert system.alternation.elastic.linear.direct == (solver == "direct")
        energies[solver] = [step.energies.total for step in march(problem, system)]
        system.destroy()
    assert energies["direct"] == pytest.approx(energies["iterative"], rel=1e-6)


def test_energy_never_rises_and_audit_is_clean() -> None:
    system = build(problem := cooled())
    seen: dict[int, list[float]] = {}
    observers = Observers(
        watch=lambda moment, sweep: seen.setdefault(moment.index, []).append(sweep.energies.total)
    )
    steps = list(march(problem, system, observers))
    assert max(owned(system.state.alpha)) > 0.95, "the body must crack for this to be a test"
    for index, energies in seen.items():
        rises = np.diff(energies) / energies[0]
        assert rises.max(initial=0.0) < 1e-10, f"step {index} rose by {rises.max():.1e}"
    for step in steps:
        assert step.audit.violations == ()
        assert step.audit.balance < 1e-9 and step.audit.healing <= 0
        assert step.audit.released >= -1e-12 * step.energies.total
    system.destroy()


def test_energy_balance_sums_up() -> None:
    """E at the end is E at the start plus all work minus all that was released."""
    system = build(problem := cooled())
    start = system.energy.total()
    steps = list(march(problem, system))
    flow = sum(step.audit.work - step.audit.released for step in steps)
    assert steps[-1].energies.total - start == pytest.approx(flow, rel=1e-9)
    system.destroy()


@pytest.mark.parametrize("crack_set_only", [False, True])
def test_irreversibility(crack_set_only: bool) -> None:
    """On reheating, all damage stays, or only the crack set does and the rest heals."""

    class Cycle(HalfSpace):
        def temperature(self, x, t):
            return super().temperature(x, t) if t < 1 else np.zeros(x.shape[1])

    rule = Irreversibility(crack_set_only=crack_set_only, threshold=0.8)
    load = Cycle(dT=14.0, kappa=1.0, face=Face(axis=1, position=0.0, inward=1))
    problem = cooled(load=load, times=(0.001, 0.0025, 2.0), irreversibility=rule)
    system = build(problem)
    steps = march(problem, system)
    next(steps), next(steps)
    cold = owned(system.state.alpha).copy()
    next(steps)
    warm = owned(system.state.alpha)
    in_set = cold >= 0.8
    assert in_set.any() and (cold[~in_set] > 0.3).any(), "both kinds must be there"
    assert np.all(warm[in_set] >= cold[in_set])
    fallen = (cold - warm)[~in_set].max()
    assert (fallen > 0.05) if crack_set_only else (fallen <= 0)
    system.destroy()


def test_running_out_of_sweeps_is_said_and_yielded() -> None:
    system = build(problem := cooled(stop=Stop(change=1e-6, residual=1e-4, sweeps=2)))
    saved = []
    observers = Observers(
        save=lambda session, moment, converged: saved.append((moment.index, converged))
    )
    steps = []
    with pytest.raises(SolveError, match=r"not converged in 2 sweeps.*try shorter time steps"):
        for step in march(problem, system, observers):
            steps.append(step)
    assert steps[-1].status == "not converged" and steps[-1].audit.violations
    assert saved[-1] == (steps[-1].index, False), "the state was saved"
    system.destroy()


def test_fall_back_takes_over_and_is_counted() -> None:
    """A first solver that may not iterate fails; the second does the work; the record says so."""
    crippled = dict(DAMAGE["tao"], tao_max_it="1")
    from staffa.minimize.bounded import TaoSolver

    system = build(problem := cooled(times=TIMES[:2]))
    parts = system.alternation
    lame = TaoSolver(parts.damage, tolerance=1e-14, preset=crippled, prefix="lame_")
    system = replace(system, alternation=replace(parts, bounded=[lame, parts.bounded[1]]))
    steps = list(march(problem, system))
    assert sum(step.effort.fallbacks for step in steps) >= 1
    assert parts.bounded[1].iterations > 0
    reference = build(problem)
    expected = [step.energies.total for step in march(problem, reference)]
    assert [step.energies.total for step in steps] == pytest.approx(expected, rel=1e-4)


def test_when_all_damage_solvers_fail_the_run_stops() -> None:
    from staffa.minimize.bounded import SnesSolver

    system = build(problem := cooled())
    parts = system.alternation
    lame = SnesSolver(
        parts.damage, tolerance=1e-12, preset=dict(DAMAGE["snes"], snes_max_it="0"), prefix="lame2_"
    )
    system = replace(system, alternation=replace(parts, bounded=[lame]))
    saved, steps = [], []
    observers = Observers(
        save=lambda session, moment, converged: saved.append((moment.index, converged))
    )
    with pytest.raises(SolveError, match=r"step 0 .* damage was not minimized.*try a shorter"):
        for step in march(problem, system, observers):
            steps.append(step)
    assert saved == [(0, False)], "the state before the failure was saved"
    assert steps[-1].status == "failed" and "not minimized" in steps[-1].reason
    assert np.all(owned(system.state.alpha) == 0), "it is not the solver's last trial"


@contextmanager
def crippled(prefix: str, **options: str):
    """PETSc's options of a solver changed, and put back."""
    known = PETSc.Options(prefix)
    usual = {name: known.getString(name, "") for name in options}
    for name, value in options.items():
        known[name] = value
    try:
        yield
    finally:
        for name, value in usual.items():
            if value:
                known[name] = value
            else:
                known.delValue(name)


def test_a_factorization_takes_over_from_a_linear_solver_that_stops_early() -> None:
    """Again in each step, on record of it, with the energies of the direct solver."""
    energies = {}
    for name, most in (("direct", "8"), ("iterative", "1")):
        system = build(problem := cooled(displacement=name))
        with crippled(f"u_{name}_", ksp_max_it=most):
            steps = list(march(problem, system))
        energies[name] = [step.energies.total for step in steps]
        needed = [step.effort.direct > 0 for step in steps]
        assert needed == [name == "iterative"] * len(TIMES)
        assert not any(step.audit.violations for step in steps)
        system.destroy()
    assert energies["iterative"] == pytest.approx(energies["direct"], rel=1e-8)


def test_linear_solver_that_stops_early_is_refused() -> None:
    """Nothing is left that could take over."""
    with crippled("u_direct_", ksp_max_it="1", pc_type="jacobi"):
        system = build(problem := cooled(displacement="direct"))
        with pytest.raises(SolveError, match=r"displacement solve failed.*DIVERGED"):
            list(march(problem, system))
        system.destroy()


def test_temperature_that_is_not_finite_is_refused() -> None:
    class Broken:
        def temperature(self, x, t):
            """NaN."""
            return np.full(x.shape[1], np.nan)

    system = build(problem := cooled(load=Broken()))
    with pytest.raises(SolveError, match="temperature that is not finite"):
        list(march(problem, system))


def test_a_state_at_its_minimum_takes_no_sweep_more_than_one() -> None:
    system = build(problem := cooled(material=rock(ell=0.08, law=AT2(), toughness=uneven)))
    list(march(problem, system))
    parts, lower, upper = damage_problem(system)
    values = np.zeros(len(system.supports.fixed))
    again = alternate(parts, values, lower, upper, problem.solvers.stop)
    assert again.converged and again.sweeps == 1
    system.destroy()


def test_small_change_alone_does_not_stop() -> None:
    """A sweep that changes little is no minimum while forces on the damage are left."""
    loose = Stop(change=0.9, residual=1e-2)
    system = build(problem := cooled(stop=loose))
    for step in march(problem, system):
        assert step.audit.optimality <= 1e-2
    system.destroy()
    system = build(problem := cooled(stop=Stop(change=0.9, residual=1e6)))
    assert max(step.audit.optimality for step in march(problem, system)) > 1e-2
    system.destroy()


def test_tough_band_does_not_spoil_the_stop() -> None:
    """The force on the damage is judged by the toughness where it acts, not by the largest."""

    def banded(x):
        return np.where((x[1] < 0.05) & (x[0] > 0.3), 1e4, uneven(x))

    system = build(problem := cooled(material=rock(ell=0.08, toughness=banded)))
    assert all(step.status == "converged" for step in march(problem, system))
    system.destroy()


def test_unloaded_body_breaks_no_balance() -> None:
    """Loads that go back to zero leave no energy to compare an error with."""
    moved = SideSupport(side="right", components={0: lambda x, t: 0.01 * (t == 1)})
    sides = (SideSupport(side="left", components={0: no_displacement}), moved)
    system = build(problem := body((1.0, 0.5), 0.1, sides=sides, times=(1.0, 2.0)))
    assert all(step.audit.violations == () for step in march(problem, system))
    system.destroy()


@pytest.mark.parametrize("E", [1e-9, 1.0, 1e11])
def test_iterative_solver_is_as_good_at_any_modulus(E: float) -> None:
    """Prescribed displacements and forces of any size are held against the same tolerance."""
    pulled = SideSupport(side="right", components={0: lambda x, t: 1e-3})
    sides = (SideSupport(side="left", components={0: no_displacement}), pulled)
    found = {}
    for solver in ("direct", "iterative"):
        material = rock(E=E, Gc=E, nu=0.3, ell=0.2)
        problem = body((1.0, 0.5), 0.1, sides=sides, material=material, displacement=solver)
        system = build(problem)
        (step,) = march(problem, system)
        found[solver] = step.energies.elastic
        system.destroy()
    assert found["iterative"] == pytest.approx(found["direct"], rel=1e-8)
    assert found["direct"] == pytest.approx(0.5 * E * 1e-6 * 0.5, rel=1e-3)


@pytest.mark.parametrize(
    ("x", "force", "left"),
    [
        (0.0, 3.0, 0.0),  # held by the lower bound
        (0.0, -3.0, 1.5),
        (1.0, -3.0, 0.0),  # held by the upper bound
        (1.0, 3.0, 1.5),
        (0.5, -3.0, 1.5),
        (1.0 - 1e-9, -3.0, 0.0),  # at the bound, to SNES's measure
    ],
)
def test_bounds_hold_forces_that_push_against_them(x: float, force: float, left: float) -> None:
    """The force counts over its unit, here 2, unless a bound takes it up."""
    at, lower, upper, unit, work = (PETSc.Vec().createSeq(1) for _ in range(5))
    at.set(x), upper.set(1.0), unit.set(2.0)
    energy = BoundedEnergy(
        move_to=lambda vector: None,
        value=lambda: 0.0,
        gradient=lambda out: out.set(force),
        hessian=lambda out: None,
        matrix=None,
        unit=unit,
    )
    assert projected_gradient(energy, at, lower, upper, work) == left


def test_option_prefixes_do_not_depend_on_the_rank() -> None:
    system = build(cooled())
    prefixes = [system.alternation.elastic.linear.ksp.getOptionsPrefix()]
    everywhere = PETSc.COMM_WORLD.tompi4py().allgather(prefixes)
    assert all(found == prefixes for found in everywhere)
    system.destroy()


def test_a_guess_that_is_exact_renews_the_factorization_all_the_same() -> None:
    """A solve that has nothing to do left the factors of another damage, as if they were new."""
    system = build(cooled())
    parts, alpha = system.alternation, system.state.alpha
    values = np.zeros(len(system.supports.fixed))

    def solved(damage: float) -> np.ndarray:
        alpha.x.array[:] = damage
        equilibrium(parts, values)
        return parts.u.array_r.copy()

    system.state.T.x.array[:] = -1.0
    u = solved(0.5)
    solved(0.0)
    parts.u.array_w[:] = u
    parts.elastic.forget()
    solved(0.5)
    w, force, back = (parts.u.duplicate() for _ in range(3))
    w.array_w[:] = np.random.default_rng(0).normal(size=w.getLocalSize())
    w.array_w[parts.elastic.held] = 0.0
    parts.elastic.apply_stiffness(w, force)
    parts.elastic.precondition(force, back)
    assert parts.elastic.linear.exact
    assert back.array_r == pytest.approx(w.array_r, rel=1e-8, abs=1e-8)
    system.destroy()
