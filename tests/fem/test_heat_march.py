"""The heat equation within the time loop: beside a closed form, and with cracks that it feels."""

from dataclasses import replace

import numpy as np
import pytest

from fem.test_backtrack import front
from staffa.errors import SolveError
from staffa.evolution import backtrack
from staffa.evolution import march as loop
from staffa.evolution.advance import advance_to
from staffa.evolution.agree import agree
from staffa.evolution.equilibrate import Loads
from staffa.evolution.march import march
from staffa.evolution.problem import Problem
from staffa.evolution.snapshot import restore, snapshot
from staffa.evolution.system import build
from staffa.heat.thermal_body import Conduction, Dirichlet, FluidFilledCrack, Insulating
from staffa.heat.transient import HeatEquation
from staffa.loads.closed_form import Face, Slab
from staffa.minimize.alternate import equilibrium
from staffa.model.supports import rollers
from staffa.records.step import Step, kept
from support.bodies import body, rock, run
from support.heated import still, tensor


def quenched(dT: float, *, side: str = "left", **more) -> Conduction:
    """A side dropped by dT, kappa = 1."""
    held = Dirichlet(side=side, T=lambda x, t: -dT)
    return Conduction(k=tensor(1.0, 1.0), rho_c=1.0, initial=still, sides=(held,), **more)


def plate(load, times=(0.0008, 0.002, 0.004, 0.008, 0.016), **more) -> Problem:
    """A plate cooled from below, in which a few cracks appear at the first step."""
    problem = body(
        (1.0, 0.5),
        0.02,
        load=load,
        times=times,
        material=rock(ell=0.06, toughness=lambda x: 1 + 0.1 * np.sin(17 * x[0] + 1)),
        face=Face(axis=1, position=0.0, inward=1),
        **more,
    )
    sides = tuple(rollers(problem.domain, side) for side in ("left", "right"))
    return replace(problem, sides=sides)


def last_damage(problem: Problem) -> tuple[list[Step], np.ndarray]:
    system = build(problem)
    steps = list(march(problem, system))
    alpha = system.state.alpha.x.array.copy()
    system.destroy()
    return steps, alpha


def test_heat_equation_and_closed_form_crack_a_plate_alike() -> None:
    slab = Slab(dT=9.0, kappa=1.0, face=Face(axis=1, position=0.0, inward=1), L=0.5)
    closed, expected = last_damage(plate(slab))
    steps, alpha = last_damage(plate(quenched(9.0, side="bottom")))
    assert expected.max() > 0.99
    assert np.abs(alpha - expected).max() < 0.1
    for step, other in zip(steps, closed, strict=True):
        assert step.audit.violations == () and step.heat.imbalance < 1e-8
        assert other.heat is None
        if step.time > 0.002:  # sqrt(kappa t) of 3 h and more
            assert step.energies.total == pytest.approx(other.energies.total, rel=0.005)


def test_backtracking_keeps_each_steps_temperature() -> None:
    """The states that stand are those of a march whose damage is given: heat knows no return."""
    steps = run(front(load=quenched(8.0)))
    assert any(step.returned for step in steps)
    kept_steps = kept(steps)
    alone = run(front(None, load=quenched(8.0)))
    assert [s.heat.stored for s in kept_steps] == pytest.approx([s.heat.stored for s in alone])
    assert all(s.heat.imbalance < 1e-8 and s.audit.violations == () for s in kept_steps)


FEELING = {
    "insulating": Insulating(residual=1e-3),
    "bath": FluidFilledCrack(h=lambda x, t: 20.0, T=lambda x, t: -4.0),
}


@pytest.mark.parametrize("name", FEELING)
def test_temperature_and_cracks_agree_at_the_end_of_a_step(name: str) -> None:
    """The step has the temperature that the heat equation gives with the cracks of the step."""
    problem = plate(quenched(9.0, side="bottom", cracks=FEELING[name], agreement=1e-4))
    system = build(problem)
    before, start, passes = system.thermal.read(), 0.0, 0
    for step in march(problem, system):
        state = system.state
        found, heat = system.coupling.advance(before, system.cracks, start, step.time)
        gap = np.abs(found.T - state.T.x.array).max() / 9.0
        assert gap <= 1e-4 and step.heat.gap == pytest.approx(gap, abs=1e-12)
        assert step.heat.stored == pytest.approx(heat.stored, rel=1e-3)
        assert step.audit.violations == ()
        before, start, passes = system.thermal.read(), step.time, passes + step.heat.passes
    assert passes > 0
    system.destroy()


def test_an_insulating_crack_keeps_what_is_behind_it_warm() -> None:
    """Cooled from the left, cracked across its middle from the start."""

    def cooled(cracks) -> float:
        load = quenched(0.5, cracks=cracks)
        problem = body(
            (1.0, 0.1),
            0.02,
            load=load,
            times=(0.5,),
            material=rock(ell=0.05, cracked=lambda x: np.abs(x[0] - 0.5) < 0.021),
        )
        system = build(problem)
        list(march(problem, system))
        T = system.state.T.x.array.min(), system.state.T.x.array.max()
        system.destroy()
        return T[1]

    assert cooled(None) < -0.25 and cooled(Insulating(residual=1e-6)) > -0.01


@pytest.mark.slow
def test_cracks_that_run_ahead_of_the_cold_are_an_error_that_says_so() -> None:
    load = quenched(9.0, side="bottom", cracks=FEELING["bath"], agreement=1e-9, passes=1)
    problem = plate(load, times=(0.002, 0.004))
    with pytest.raises(SolveError, match=r"take shorter time steps, or a larger heat\.agreement"):
        run(problem)


def feeling_front(residual: float = 0.05) -> Problem:
    return front(load=quenched(8.0, cracks=Insulating(residual=residual)))


@pytest.mark.slow
def test_earlier_energies_are_compared_at_the_temperatures_that_the_cracks_would_give() -> None:
    """Against a separate system, whose heat is led there from the step before."""
    steps = run(feeling_front())
    number = next(n for n, step in enumerate(steps) if step.returned)
    back, at = steps[number].returned, steps[number]
    problem = feeling_front()
    marching_on = replace(problem, backtracking=None)
    system = build(marching_on)
    marching = march(marching_on, system)
    start, before = 0.0, system.thermal.read()
    for index in range(back.index + 1):
        if index == at.index:
            before = system.thermal.read()
            start = problem.schedule.times[index - 1] if index else 0.0
        next(marching)
    found, _ = system.coupling.advance(before, system.cracks, start, at.time)
    system.thermal.put(found)
    equilibrium(system.alternation, system.supports.values(at.time))
    assert back.found == pytest.approx(system.energy.total(), rel=1e-9)
    assert at.heat.imbalance < 1e-8
    system.destroy()


@pytest.mark.slow
def test_returns_to_a_time_are_limited_where_cracks_are_felt(monkeypatch) -> None:
    """Even if each look back finds something better."""
    found = []

    def always(problem, system, history):
        real = better(problem, system, history)
        first = len(history.steps) > 1
        allowed = history.returns[0] < backtrack.MOST_RETURNS
        return real or (backtrack.Better(index=0, found=0.0) if first and allowed else None)

    better = backtrack.better_earlier
    monkeypatch.setattr(loop, "better_earlier", always)
    steps = run(feeling_front())
    found = [step.returned.number for step in steps if step.returned and step.index == 0]
    assert found == [1, 2, 3]


def test_forward_back_and_forward_again_is_the_same() -> None:
    problem = plate(quenched(9.0, side="bottom", cracks=FEELING["bath"]))
    system = build(problem)
    marching = march(problem, system)
    next(marching), next(marching)
    kept_state, state = snapshot(system), system.state
    third = next(marching)
    first = [field.x.array.copy() for field in (state.alpha, state.T)]
    restore(system, kept_state)
    times = problem.schedule.times
    loads = [Loads(time=t, values=system.supports.values(t)) for t in times[1:3]]
    again = advance_to(problem, system, *loads)
    for field, values in zip((state.alpha, state.T), first, strict=True):
        assert np.array_equal(field.x.array, values)
    assert again.heat == third.heat
    system.destroy()


def test_the_history_gives_back_what_it_was_given() -> None:
    """Damage and temperature of each step, and where its heat began, to the last bit."""
    problem = plate(quenched(9.0, side="bottom", cracks=FEELING["insulating"]))
    system = build(problem)
    history, state = backtrack.StepHistory(system), system.state
    start, given = Loads(time=0.0, values=system.supports.values(0.0)), []
    for time in problem.schedule.times[:3]:
        given.append((state.alpha.x.array.copy(), state.T.x.array.copy(), start.time))
        end = Loads(time=time, values=system.supports.values(time))
        history.keep(end, advance_to(problem, system, start, end), system)
        start = end
        assert np.array_equal(history.thermal(len(given) - 1).T, state.T.x.array)
    for index, (alpha, T, time) in enumerate(given):
        damage, origin = history.before(index)
        assert np.array_equal(damage, alpha) and np.array_equal(origin.thermal.T, T)
        assert origin.time == time
    history.close()
    system.destroy()


def test_a_step_cut_in_two_counts_the_heat_of_both_parts() -> None:
    """Also when cracks and temperature are made to agree once more."""
    problem = plate(quenched(9.0, side="bottom", cracks=FEELING["bath"]))
    system = build(problem)
    times = (0.0, 0.0008, 0.0016)
    loads = [Loads(time=t, values=system.supports.values(t)) for t in times]
    equilibrium(system.alternation, loads[0].values)
    first = advance_to(problem, system, loads[0], loads[1])
    both = first.then(advance_to(problem, system, loads[1], loads[2]))
    system.state.T.x.array[:] += 0.5  # so that it is not agreed
    again = agree(problem, system, loads[2], both)
    for advance in (both, again):
        assert advance.all_heat.stored == pytest.approx(first.heat.stored + advance.heat.stored)
    assert again.all_heat.substeps >= first.heat.substeps + 1
    assert again.heat.stored == pytest.approx(both.heat.stored, rel=0.1)
    system.destroy()


def test_a_heat_solver_that_fails_loses_no_finished_step(monkeypatch) -> None:
    problem, real, steps = plate(quenched(9.0, side="bottom")), HeatEquation._solve, []

    def failing(self, gain):
        if len(steps) == 2:
            raise SolveError("the heat equation was not solved: out of luck")
        return real(self, gain)

    monkeypatch.setattr(HeatEquation, "_solve", failing)
    system = build(problem)
    with pytest.raises(SolveError, match="out of luck"):
        for step in march(problem, system):
            steps.append(step)
    assert [step.status for step in steps] == ["converged", "converged", "failed"]
    system.destroy()


# Many small solves: on three ranks, more than there are cores, they take minutes.
MANY = [2, pytest.param(3, marks=pytest.mark.long)]
