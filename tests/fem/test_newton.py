"""Newton's moves: what they may do, what they save, and that they change no result."""

from dataclasses import replace
from functools import partial
from itertools import pairwise

from staffa.backend.stack import PETSc

import numpy as np
import pytest

from staffa.errors import SolveError
from staffa.evolution.apply_loads import change_loads
from staffa.evolution.equilibrate import Loads, raise_bounds
from staffa.evolution.march import Observers, march
from staffa.evolution.problem import Problem, Solvers
from staffa.evolution.system import System, build
from staffa.minimize.alternate import Sweep, Tally, alternate, equilibrium
from staffa.minimize.newton import SHORTEST, search
from staffa.minimize.patience import Patience
from staffa.model.fields import read_vector
from staffa.model.supports import GeneralizedPlaneStrain, SideSupport, no_displacement
from staffa.physics.damage import LAWS
from staffa.records.step import Energies, Moment, Stop
from support.bodies import body, quench, rock, run

TIGHT = Stop(change=1e-6, residual=1e-4)


def uneven(x: np.ndarray) -> np.ndarray:
    """A toughness that favors some places, so that no round-off decides."""
    return 1 + 0.1 * np.cos(7 * x[0] + 1)


def with_acceleration(problem: Problem, name: str, displacement: str = "direct") -> Problem:
    """The same problem, solved in another way."""
    solvers = Solvers(displacement=displacement, acceleration=name, stop=TIGHT)
    return replace(problem, solvers=solvers)


def pulled_bar(law: str) -> Problem:
    """A bar of uneven toughness, pulled until it is damaged but not yet past its peak."""
    sides = (
        SideSupport(side="left", components={0: no_displacement}),
        SideSupport(side="right", components={0: lambda x, t: t}),
    )
    material = rock(E=10.0, ell=0.2, law=LAWS[law], toughness=uneven)
    return body((0.4, 0.2), 0.04, sides=sides, material=material, times=(0.15, 0.18, 0.2))


def cooled(dim: int = 2, **changes) -> Problem:
    """A plate or a box whose cooled face is damaged, and cracks at the last time."""
    size = (1.0, 0.5) if dim == 2 else (0.4, 0.4, 0.3)
    material = rock(ell=0.1, toughness=uneven, state="plane stress" if dim == 2 else "solid")
    fields = {"load": quench(6.0) if dim == 2 else Bottom(), "times": (0.002, 0.006, 0.012)}
    return body(size, 0.05, **{"material": material, **fields, **changes})


class Bottom:
    """A box cooled from below."""

    def temperature(self, x, t):
        """A half-space along z."""
        from scipy.special import erfc

        return -9.0 * erfc(x[2] / (2 * np.sqrt(t)))


PROBLEMS = {
    "bar AT1": lambda: pulled_bar("AT1"),
    "bar AT2": lambda: pulled_bar("AT2"),
    "plate": cooled,
    "cell of a slab": lambda: cooled(
        sides=(SideSupport(side="left", components={0: no_displacement}),),
        section=GeneralizedPlaneStrain(bending=True),
    ),
    "box": lambda: cooled(3),
}


@pytest.mark.parametrize("displacement", ["direct", "iterative"])
@pytest.mark.parametrize("name", PROBLEMS)
def test_same_energies_with_and_without(name: str, displacement: str) -> None:
    problem = PROBLEMS[name]()
    plain, fast = (
        run(with_acceleration(problem, kind, displacement)) for kind in ("none", "newton")
    )
    assert sum(step.effort.moves for step in plain) == 0
    assert sum(step.effort.moves for step in fast) > 0
    assert max(step.energies.surface for step in fast) > 1e-3, "there must be damage"
    expected = [step.energies.total for step in plain]
    assert [step.energies.total for step in fast] == pytest.approx(expected, rel=1e-5)
    assert [step.audit.violations for step in fast] == [()] * len(fast)


def test_it_takes_a_fraction_of_the_sweeps_through_nucleation() -> None:
    problem = cooled(load=quench(8.0), material=rock(ell=0.08, toughness=uneven))
    sweeps = {
        kind: sum(step.sweeps for step in run(with_acceleration(problem, kind)))
        for kind in ("none", "newton")
    }
    assert sweeps["newton"] < 0.4 * sweeps["none"], sweeps


def damaged(problem: Problem) -> System:
    """A system in equilibrium whose damage is neither minimal nor at its bounds."""
    system = build(problem)
    parts, values = system.alternation, np.zeros(len(system.supports.fixed))
    equilibrium(parts, values)
    loads = Loads(time=0.006, values=values)
    change_loads(problem, system, Loads(time=0.0, values=values), loads)
    raise_bounds(problem.irreversibility, system)
    alpha = system.state.alpha.x.array
    alpha[:] = 0.3 + 0.2 * np.sin(np.arange(len(alpha)))
    read_vector(system.state.alpha, parts.alpha)
    equilibrium(parts, values)
    return system


@pytest.mark.parametrize("name", ["plate", "box"])
def test_the_quadratic_model_is_the_energys(name: str) -> None:
    """Along any admissible move the forces change as the second derivative says."""
    system = damaged(PROBLEMS[name]())
    parts, newton = system.alternation, system.alternation.newton
    lower, upper = system.bounds.lower.x.petsc_vec, system.bounds.upper.x.petsc_vec
    newton._direction(parts.alpha, lower, upper)
    assert len(newton.model.held) == 0
    rng = np.random.default_rng(1)
    du, dalpha = newton.move.getNestSubVecs()
    for vector in (du, dalpha):
        vector.array_w[:] = rng.normal(size=vector.getLocalSize())
    du.array_w[parts.elastic.held] = 0.0
    newton.model.apply(newton.move, newton.resistance)

    def forces(step: float) -> tuple[np.ndarray, np.ndarray]:
        u, alpha = parts.u.copy(), parts.alpha.copy()
        u.axpy(step, du), alpha.axpy(step, dalpha)
        parts.keep_u(u), parts.damage.move_to(alpha)
        found_u, found_alpha = u.duplicate(), alpha.duplicate()
        parts.forces(found_u), parts.damage.gradient(found_alpha)
        found_u.array_w[parts.elastic.held] = 0.0
        return found_u.array_r.copy(), found_alpha.array_r.copy()

    step = 1e-5
    for part, plus, minus in zip(
        newton.resistance.getNestSubVecs(), forces(step), forces(-step), strict=True
    ):
        slope = (plus - minus) / (2 * step)
        assert part.array_r == pytest.approx(slope, rel=1e-5, abs=1e-5 * np.abs(slope).max())
    system.destroy()


@pytest.mark.parametrize("kept", [False, True])
@pytest.mark.parametrize("name", ["plate", "cell of a slab"])
def test_preconditioner_is_symmetric_and_positive(name: str, kept: bool) -> None:
    """Also with the modes of a section, and with a factor that was made a little earlier."""
    for displacement in ("direct", "iterative"):
        system = damaged(with_acceleration(PROBLEMS[name](), "newton", displacement))
        if kept:
            system.state.alpha.x.array[:] += 1e-4
            read_vector(system.state.alpha, system.alternation.alpha)
            equilibrium(system.alternation, np.zeros(len(system.supports.fixed)))
            assert not system.alternation.elastic.linear.exact
        newton, parts = system.alternation.newton, system.alternation
        lower, upper = system.bounds.lower.x.petsc_vec, system.bounds.upper.x.petsc_vec
        newton._direction(parts.alpha, lower, upper)
        rng = np.random.default_rng(2)
        pairs = []
        for pair, out in ((newton.force, newton.answer), (newton.way, newton.resistance)):
            u, alpha = pair.getNestSubVecs()
            alpha.array_w[:] = rng.normal(size=alpha.getLocalSize())
            # With an exact inverse the preconditioner relies on displacements in equilibrium.
            u.array_w[:] = 0 if parts.elastic.linear.exact else rng.normal(size=u.getLocalSize())
            u.array_w[parts.elastic.held] = 0.0
            newton.model.precondition(pair, out)
            pairs.append((pair, out))
        (a, Pa), (b, Pb) = pairs
        assert a.dot(Pa) > 0 and b.dot(Pb) > 0
        assert a.dot(Pb) == pytest.approx(b.dot(Pa), rel=1e-6)
        system.destroy()


@pytest.mark.parametrize(
    ("energy", "expected"),
    [
        (lambda t: (t - 1) ** 2, 1.0),
        (lambda t: (t - 5) ** 2, 4.0),
        (lambda t: -t, 16.0),
        (lambda t: (t - 0.1) ** 2, 1 / 9),
        (lambda t: t, 0.0),
        (lambda t: np.nan if t else 0.0, 0.0),
        (lambda t: np.inf if t > 0.2 else (t - 0.1) ** 2, 1 / 9),
    ],
)
def test_search_takes_only_what_lowers_the_energy(energy, expected) -> None:
    asked: list[float] = []

    def energy_at(t: float) -> float:
        asked.append(t)
        return energy(t)

    taken, found = search(energy_at, energy(0.0))
    assert taken == pytest.approx(expected) and found == energy(taken)
    assert asked[-1] == taken, "the state is left where the energy was found"
    assert taken == 0 or found < energy(0.0)
    assert min(asked[:-1], default=1.0) > SHORTEST / 4


def test_a_refused_move_leaves_the_state_and_is_counted() -> None:
    """An energy that no move can lower: every proposal is refused, and plain sweeps do the work."""
    problem = with_acceleration(cooled(), "newton")
    system = build(problem)
    parts = system.alternation
    newton = parts.newton
    advance = newton.advance

    def hopeless(u, alpha, lower, upper, *, total, before):
        u_before, alpha_before = u.copy(), alpha.copy()
        move = advance(u, alpha, lower, upper, total=lambda: total() and np.nan, before=before)
        assert move.taken == 0
        for now, then in ((u, u_before), (alpha, alpha_before)):
            assert np.array_equal(now.array_r, then.array_r), "the state was left as it was"
        return move

    newton.advance = hopeless
    steps = list(march(problem, system))
    assert sum(step.effort.moves for step in steps) == 0
    assert sum(step.effort.refused for step in steps) > 0
    expected = [step.energies.total for step in run(with_acceleration(problem, "none"))]
    assert [step.energies.total for step in steps] == pytest.approx(expected, rel=1e-6)
    system.destroy()


def test_patience_doubles_with_each_refusal() -> None:
    patience, tried = Patience(), []
    for sweep in range(20):
        if patience.allows():
            tried.append(sweep)
            patience.learn(taken=False)
    assert tried == [0, 2, 5, 10, 19]
    patience.learn(taken=True)
    assert patience.allows() and Patience().allows()


def test_the_stop_is_judged_by_a_plain_sweep() -> None:
    """Going on from the state returned, plain alternation finds nothing left to do."""
    problem = with_acceleration(cooled(), "newton")
    for displacement in ("direct", "iterative"):
        system = build(with_acceleration(problem, "newton", displacement))
        list(march(problem, system))
        plain = replace(system.alternation, newton=None)
        lower, upper = system.bounds.lower.x.petsc_vec, system.bounds.upper.x.petsc_vec
        values = np.zeros(len(system.supports.fixed))
        again = alternate(plain, values, lower, upper, TIGHT)
        assert again.converged and again.sweeps == 1
        system.destroy()


def noted(seen: list[tuple[int, float]], moment: Moment, sweep: Sweep) -> None:
    """Keep the step and the energy of a sweep."""
    seen.append((moment.index, sweep.energies.total))


def test_energies_fall_from_sweep_to_sweep() -> None:
    for displacement in ("direct", "iterative"):
        problem = with_acceleration(cooled(load=quench(8.0)), "newton", displacement)
        system = build(problem)
        seen: list[tuple[int, float]] = []
        note = partial(noted, seen)
        steps = list(march(problem, system, Observers(watch=note)))
        assert sum(step.effort.moves for step in steps) > 5
        for (step, before), (next_step, after) in pairwise(seen):
            assert next_step != step or after <= before * (1 + 1e-9)
        assert max(step.audit.largest_rise for step in steps) <= 1e-9
        system.destroy()


def test_a_rise_in_either_half_of_a_sweep_is_seen() -> None:
    tally = Tally(energies=Energies(elastic=10.0, surface=0.0))
    tally.note(5.0, "the damage was minimized")
    assert tally.largest_rise == 0.0
    tally.accept(Energies(elastic=9.0, surface=0.0), "the displacement was solved for")
    assert tally.largest_rise == pytest.approx(4 / 9), "what one half gained the other gave back"


def test_out_of_sweeps_the_state_is_in_equilibrium() -> None:
    """Also where the displacement was solved for loosely till then."""
    problem = with_acceleration(cooled(load=quench(8.0)), "newton", "iterative")
    solvers = replace(problem.solvers, stop=replace(TIGHT, sweeps=3))
    system = build(replace(problem, solvers=solvers))
    with pytest.raises(SolveError, match="not converged in 3 sweeps"):
        list(march(replace(problem, solvers=solvers), system))
    parts = system.alternation
    force = parts.u.duplicate()
    parts.forces(force)
    force.array_w[parts.elastic.held] = 0.0
    assert force.norm() < 1e-7 * parts.elastic.load.norm()
    system.destroy()


def test_factor_is_kept_while_the_stiffness_is_the_same() -> None:
    system = build(problem := cooled())
    parts, values = system.alternation, np.zeros(len(system.supports.fixed))
    equilibrium(parts, values)
    assert parts.elastic.linear.renewals == 1
    change_loads(problem, system, Loads(time=0.0, values=values), Loads(time=0.006, values=values))
    assert parts.elastic.linear.renewals == 1 and parts.elastic.linear.exact
    system.state.alpha.x.array[:] = 0.5
    equilibrium(parts, values)
    assert parts.elastic.linear.renewals == 2, (
        "half the stiffness is gone: the old factor is of no use"
    )
    system.state.alpha.x.array[:] += 1e-4
    equilibrium(parts, values)
    assert parts.elastic.linear.renewals == 2 and not parts.elastic.linear.exact
    force = parts.u.duplicate()
    parts.forces(force)
    force.array_w[parts.elastic.held] = 0.0
    assert force.norm() < 1e-8 * parts.elastic.load.norm(), "solved for all the same"
    system.destroy()


def test_rigid_modes_save_iterations() -> None:
    """Multigrid without them needs many more."""
    problem = with_acceleration(cooled(3), "none", "iterative")
    iterations = {}
    for known in (True, False):
        system = build(problem)
        elastic, values = system.alternation.elastic, np.zeros(len(system.supports.fixed))
        if not known:
            elastic.constrained.setNearNullSpace(PETSc.NullSpace())
        change_loads(
            problem, system, Loads(time=0.0, values=values), Loads(time=0.006, values=values)
        )
        iterations[known] = elastic.linear.iterations
        system.destroy()
    assert iterations[True] < 0.8 * iterations[False], iterations
