"""Backtracking: to the earliest time at which a later damage is better, downhill, on record."""

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest

from staffa.errors import SolveError
from staffa.evolution import backtrack, second_order
from staffa.evolution import march as loop
from staffa.evolution.advance import advance_to
from staffa.evolution.backtrack import StepHistory, better_earlier
from staffa.evolution.effective_toughness import effective_gc
from staffa.evolution.equilibrate import Loads
from staffa.evolution.march import march
from staffa.evolution.problem import Backtracking, Irreversibility, Problem
from staffa.evolution.system import build
from staffa.loads.closed_form import Face, HalfSpace, Load
from staffa.minimize.alternate import equilibrium
from staffa.model.supports import SideSupport, no_displacement
from staffa.records.step import kept
from support.bodies import body, rock, run

HEIGHT, H, ELL = 0.1, 0.02, 0.05
DEFAULT = Backtracking()


def weakest(x: np.ndarray) -> np.ndarray:
    """A bar that is a little weaker left of its middle."""
    return 1 - 0.02 * np.exp(-(((x[0] - 0.4) / 0.1) ** 2))


def bar(times=None, *, backtracking: Backtracking | None = DEFAULT, **more) -> Problem:
    """A bar of length 1, pulled; by Griffith it breaks long before its strength is reached."""
    pulled = (
        SideSupport(side="left", components={0: no_displacement}),
        SideSupport(side="right", components={0: lambda x, t: t}),
    )
    material = rock(ell=ELL, nu=0.0, toughness=weakest)
    times = times if times is not None else np.arange(0.2, 3.01, 0.2)
    return body(
        (1.0, HEIGHT),
        H,
        material=material,
        times=tuple(times),
        backtracking=backtracking,
        **{"sides": pulled, **more},
    )


def front(backtracking: Backtracking | None = DEFAULT, *, load: Load | None = None) -> Problem:
    """The bar held at both ends and cooled from one: a load that is not in proportion to time."""
    sides = tuple(
        SideSupport(side=side, components={0: no_displacement}) for side in ("left", "right")
    )
    load = load or HalfSpace(dT=8.0, kappa=1.0, face=Face(axis=0, position=0.0, inward=1))
    times = np.linspace(0.05, 0.4, 15) ** 2
    return bar(times, backtracking=backtracking, sides=sides, load=load)


def broken_from(steps) -> float:
    """Time of the first step with a crack across the bar."""
    return next(step.time for step in steps if step.energies.surface > 0.9 * HEIGHT)


def test_a_bar_breaks_when_that_is_better_and_not_when_it_must() -> None:
    """Elastic energy E strain^2/2 against Gc; without, at the strength sqrt(3 Gc E/(8 ell))."""
    problem = bar()
    factor = effective_gc(problem.material, dim=2, h=H, cells="quadrilateral")
    step = 0.2
    griffith, strength = sqrt(2 * 0.98 * factor), sqrt(3 / (8 * ELL))
    with_it = broken_from(kept(run(problem)))
    without = broken_from(run(replace(problem, backtracking=None)))
    assert griffith <= with_it + 1e-9 <= griffith + 1.2 * step, f"{with_it}, theory {griffith}"
    assert abs(without - strength) <= 1.2 * step, f"{without}, theory {strength}"


@pytest.mark.parametrize("make", [bar, front])
def test_the_descent_is_lexicographic(make) -> None:
    """A return lowers the energy at its time by the tolerance; those before stay as they are."""
    returns, before = 0, ()
    steps = run(make())
    for number, step in enumerate(steps):
        after = kept(steps[: number + 1])
        assert [s.index for s in after] == list(range(len(after)))
        if step.returned:
            returns += 1
            left = before[step.index]
            assert step.returned.before == left.energies.total
            assert step.returned.index == before[-1].index
            assert step.returned.found < left.energies.total * (1 - 1e-4)
            assert step.energies.total <= step.returned.found * (1 + 1e-9)
            assert after[:-1] == before[: step.index]
            assert step.audit.violations == (), step.audit.violations
        before = after
    assert returns > 0
    assert len(before) == len(make().schedule.times)


def test_the_first_time_that_differs_has_a_lower_energy() -> None:
    alone = run(front(None))
    back = kept(run(front()))
    pairs = [(a.energies.total, b.energies.total) for a, b in zip(alone, back, strict=True)]
    different = [(a, b) for a, b in pairs if abs(a - b) > 1e-5 * a]
    assert different and different[0][1] < different[0][0], pairs


@pytest.mark.parametrize("make", [bar, front])
def test_the_energies_compared_are_those_of_the_frozen_damage_then(make) -> None:
    """Against elasticity solved at the earlier time by a separate system."""
    problem, steps = make(), run(make())
    number = next(n for n, step in enumerate(steps) if step.returned)
    back = steps[number].returned
    system = build(problem)
    marching = march(replace(problem, backtracking=None), system)
    for _ in range(back.index + 1):
        next(marching)
    loads = Loads(time=steps[number].time, values=system.supports.values(steps[number].time))
    thermal, _ = system.coupling.advance(system.thermal.read(), system.cracks, 0.0, loads.time)
    system.thermal.put(thermal)
    equilibrium(system.alternation, loads.values)
    assert back.found == pytest.approx(system.energy.total(), rel=1e-9)
    system.destroy()


def test_looking_back_factorizes_once_and_leaves_the_state() -> None:
    problem = bar((0.5, 0.7, 0.9, 2.0, 2.9))
    system = build(problem)
    state, elastic = system.state, system.alternation.elastic
    history = StepHistory(system)
    start = Loads(time=0.0, values=system.supports.values(0.0))
    for time in problem.schedule.times:
        end = Loads(time=time, values=system.supports.values(time))
        history.keep(end, advance_to(problem, system, start, end), system)
        start = end
    before = [f.x.array.copy() for f in (state.u, state.alpha, state.T)]
    for tolerance, expected in ((1e-4, 3), (0.9, None)):
        made = elastic.linear.renewals
        looking = replace(problem, backtracking=Backtracking(tolerance=tolerance))
        better = better_earlier(looking, system, history)
        assert (better and better.index) == expected
        assert elastic.linear.renewals - made <= 1
        for field, values in zip((state.u, state.alpha, state.T), before, strict=True):
            assert np.array_equal(field.x.array, values)
    history.close()
    system.destroy()


def test_what_the_crack_set_alone_bounds_may_heal_at_the_time_returned_to() -> None:
    problem = bar(irreversibility=Irreversibility(crack_set_only=True))
    steps = kept(run(problem))
    assert any(step.returned for step in steps)
    assert all(step.audit.violations == () for step in steps)


@pytest.mark.parametrize("where", ["go_back", "examine"])
def test_a_return_that_fails_is_recorded_and_loses_nothing(monkeypatch, where: str) -> None:
    """The run goes on as it would without it."""
    if where == "go_back":

        def fails(*arguments, **more):
            raise SolveError("out of luck")

        monkeypatch.setattr(backtrack, "settle", fails)
    else:
        real = second_order.examine

        def fails(problem, system, loads, advance, watch):
            if advance.returned:
                raise SolveError("out of luck")
            return real(problem, system, loads, advance, watch)

        monkeypatch.setattr(loop, "examine", fails)
    found = run(bar())
    expected = run(replace(bar(), backtracking=None))
    rejected = [step for step in found if step.status == "rejected"]
    assert rejected and all("out of luck" in step.reason for step in rejected)
    assert len({step.index for step in rejected}) == len(rejected), "none is tried again"
    stands = kept(found)
    assert [step.index for step in stands] == [step.index for step in expected]
    energies = [step.energies.total for step in expected]
    assert [step.energies.total for step in stands] == pytest.approx(energies, rel=1e-10)
