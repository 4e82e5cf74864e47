"""The audit names what was tampered with: each test spoils one thing, and no other."""

from collections.abc import Callable
from dataclasses import replace
from itertools import count

import numpy as np
import pytest

from staffa.evolution import advance, apply_loads, equilibrate
from staffa.evolution.load_path import integral
from staffa.evolution.march import Observers, march
from staffa.evolution.problem import Irreversibility, Problem
from staffa.evolution.restart_state import RestartState
from staffa.evolution.system import System, build
from staffa.heat.thermal_body import Conduction, Dirichlet
from staffa.heat.transient import HeatEquation
from staffa.loads.closed_form import HalfSpace
from staffa.minimize import alternate
from staffa.minimize.bounded import TaoSolver
from staffa.model.energy import Energy
from staffa.model.supports import SideSupport, no_displacement
from staffa.physics.split import NO_SPLIT, SPLITS
from staffa.records.step import Step, Stop
from support.bodies import BOTTOM, Unbreakable, body, quench, rock
from support.heated import still, tensor

SPLIT = SPLITS["volumetric-deviatoric"]
TIMES = (0.0025, 0.01)


def cooled(*, split=NO_SPLIT, **changes) -> Problem:
    """A plate that cracks under a severe quench."""
    material = rock(ell=0.12, toughness=lambda x: 1 + 0.1 * np.cos(7 * x[0] + 1), split=split)
    fields = {"load": quench(8.0), "times": TIMES, "material": material, "anchor": "top"}
    return body((1.0, 0.5), 0.06, **{**fields, "face": BOTTOM, **changes})


class Cycle(HalfSpace):
    """Cooled, and warm again."""

    def temperature(self, x: np.ndarray, t: float) -> np.ndarray:
        """As the protocol has it."""
        return super().temperature(x, t) if t < 1 else np.zeros(x.shape[1])


def reheated(**changes) -> Problem:
    """Damage that would heal if it could."""
    return cooled(load=Cycle(dT=14.0, kappa=1.0, face=BOTTOM), times=(0.0025, 2.0), **changes)


def heated() -> Problem:
    """Cooled by conduction from below."""
    held = Dirichlet(side="bottom", T=lambda x, t: -8.0)
    return cooled(load=Conduction(k=tensor(1.0, 1.0), rho_c=1.0, initial=still, sides=(held,)))


Look = Callable[[System, int], None]


def ran(problem: Problem, look: Look = lambda system, index: None) -> list[Step]:
    """All steps; look: called at the end of each."""
    system = build(problem)
    observers = Observers(save=lambda session, moment, converged: look(system, moment.index))
    try:
        return list(march(problem, system, observers))
    finally:
        system.destroy()


def said(steps: list[Step], words: str) -> list[int]:
    """The steps whose audit says so; of the others it says nothing."""
    found = {step.index: step.audit.violations for step in steps if step.audit}
    named = [index for index, every in found.items() if any(words in text for text in every)]
    assert named and not any(every for index, every in found.items() if index not in named), found
    return named


@pytest.mark.parametrize("split", [NO_SPLIT, SPLIT], ids=["no split", "split"])
def test_nothing_is_said_of_a_sound_run(split) -> None:
    steps = ran(cooled(split=split))
    assert all(step.audit.violations == () for step in steps)
    assert max(step.audit.gap for step in steps) < 1e-12
    assert max(step.audit.balance for step in steps) < 3e-6


def test_a_half_sweep_that_raises_the_energy_is_named(monkeypatch) -> None:
    real, calls = TaoSolver.minimize, count()

    def once_upwards(self, x, lower, upper) -> None:
        real(self, x, lower, upper)
        if next(calls) == 2:
            x.array_w[:] = np.minimum(x.array_r + 0.05, 1.0)

    monkeypatch.setattr(TaoSolver, "minimize", once_upwards)
    said(ran(cooled()), "the energy rose by")


def test_a_solver_that_heals_damage_is_named(monkeypatch) -> None:
    real = TaoSolver.minimize

    def without_bound(self, x, lower, upper) -> None:
        none = lower.duplicate()
        real(self, x, none, upper)
        none.destroy()

    monkeypatch.setattr(TaoSolver, "minimize", without_bound)
    problem = reheated()
    plain = replace(problem, solvers=replace(problem.solvers, acceleration="none"))
    assert said(ran(plain), "irreversibility is violated by") == [1]


@pytest.mark.parametrize("crack_set_only", [False, True])
def test_bounds_that_are_not_raised_are_named(monkeypatch, crack_set_only: bool) -> None:
    """Damage is judged by that of the step before, not by the bound that was put on."""
    rule = Irreversibility(crack_set_only=crack_set_only, threshold=0.8)
    assert all(step.audit.violations == () for step in ran(reheated(irreversibility=rule)))
    monkeypatch.setattr(equilibrate, "raise_bounds", lambda rule, system: None)
    assert said(ran(reheated(irreversibility=rule)), "irreversibility is violated by") == [1]


@pytest.mark.parametrize("split", [NO_SPLIT, SPLIT], ids=["no split", "split"])
@pytest.mark.parametrize("what", ["displacement", "power"])
def test_work_that_is_not_that_of_the_loads_is_named(monkeypatch, split, what: str) -> None:
    """A displacement out of equilibrium, and a power of heat that is wrong, by 1 in 1000."""
    solved, power = apply_loads.equilibrium, Energy.thermal_power

    def out_of_equilibrium(parts, values) -> None:
        solved(parts, values)
        parts.u.scale(1.001)
        parts.keep_u(parts.u)

    if what == "displacement":
        monkeypatch.setattr(apply_loads, "equilibrium", out_of_equilibrium)
    else:
        monkeypatch.setattr(Energy, "thermal_power", lambda self: 1.001 * power(self))
    assert said(ran(cooled(split=split)), "the energy balance is off by") == [0, 1]


def warmer(system: System) -> None:
    """Change the temperature by 1 in 1000."""
    system.state.T.x.array[:] *= 0.999


@pytest.mark.parametrize("when", ["before", "after"])
def test_a_temperature_changed_after_the_account_is_named(monkeypatch, when: str) -> None:
    """Before the minimization, and after it."""
    name = {"before": "change_loads", "after": "settle"}[when]
    real = getattr(advance, name)

    def changed(problem, system, *rest, **more):
        found = real(problem, system, *rest, **more)
        warmer(system)
        return found

    monkeypatch.setattr(advance, name, changed)
    indices = said(ran(cooled()), "a state is not the one on record")
    assert set(indices) == {0, 1}


@pytest.mark.parametrize("field", ["temperature", "damage", "displacement"])
def test_a_state_changed_between_steps_is_named(field: str) -> None:
    """By the energy on record of the step before."""

    def spoil(system: System, index: int) -> None:
        state = system.state
        changed = {"temperature": state.T, "damage": state.alpha, "displacement": state.u}[field]
        changed.x.array[:] *= 0.99 if index == 0 else 1.0

    assert said(ran(cooled(), spoil), "a state is not the one on record") == [1]


def test_a_state_changed_before_a_run_goes_on_is_named() -> None:
    problem, kept = cooled(), []
    keep = Observers(keep=lambda restart, now: kept.append(restart))
    system = build(problem)
    list(march(problem, system, keep))
    middle: RestartState = kept[1]

    def goes_on(restart: RestartState) -> list[Step]:
        return list(march(problem, system, restart=restart))

    assert [step.audit.violations for step in goes_on(middle)] == [()]
    thermal = replace(middle.kept.thermal, T=0.999 * middle.kept.thermal.T)
    spoiled = replace(middle, kept=replace(middle.kept, thermal=thermal))
    assert said(goes_on(spoiled), "a state is not the one on record") == [1]
    assert "total" in middle.numbers() and middle.total is not None
    system.destroy()


def test_a_minimum_that_is_none_is_named(monkeypatch) -> None:
    """A minimization that takes any force for balanced; the audit looks at the state itself."""
    monkeypatch.setattr(alternate, "projected_gradient", lambda *arguments: 0.0)
    problem = cooled(stop=Stop(change=0.9, residual=1e-3))
    plain = replace(problem, solvers=replace(problem.solvers, acceleration="none"))
    said(ran(plain), "the first-order residual is")


@pytest.mark.parametrize("when", ["within the step", "after it"])
def test_heat_that_came_from_nowhere_is_named(monkeypatch, when: str) -> None:
    real = HeatEquation.advance
    assert all(step.audit.violations == () for step in ran(heated()))

    def warmed(self, *arguments):
        T, heat = real(self, *arguments)
        return 0.999 * T, heat

    if when == "within the step":
        monkeypatch.setattr(HeatEquation, "advance", warmed)
        words, expected = "the heat that entered is not what was stored", [0, 1]
        assert said(ran(heated()), words) == expected
        return
    steps = ran(heated(), lambda system, index: warmer(system))
    assert said(steps, "a state is not the one on record") == [1]


def test_work_of_pushing_and_pulling_by_a_closed_form() -> None:
    """A bar whose layers answer pressure ten times as stiffly as tension, pushed and then pulled:
    the work of each half of the way is its energy, of the whole way the difference."""
    sides = (
        SideSupport(side="left", components={0: no_displacement}),
        SideSupport(side="right", components={0: lambda x, t: 0.01 * (t - 2) * (t > 0)}),
    )

    class Softened(Unbreakable):
        def a(self, alpha):
            return 0.1 + 0 * alpha

    material = rock(E=100.0, nu=0.0, law=Softened(), split=SPLITS["spectral"])
    pushed, pulled = ran(body((1.0, 0.2), 0.1, sides=sides, times=(1.0, 3.0), material=material))
    stiff, soft = 0.5 * 100 * 0.01**2 * 0.2, 0.1 * 0.5 * 100 * 0.01**2 * 0.2
    assert pushed.audit.work == pytest.approx(stiff, rel=1e-5)
    assert pulled.audit.work == pytest.approx(soft - stiff, rel=1e-5)
    assert not pushed.audit.violations and not pulled.audit.violations


def test_integral_of_a_slope_with_a_kink() -> None:
    looks = []

    def slope(s: float) -> float:
        looks.append(s)
        return max(s - 1 / 3, 0.0)

    found = integral(slope, (0.0, 1.0), (slope(0.0), slope(0.5), slope(1.0)), 1e-6)
    assert found == pytest.approx(2 / 9, abs=1e-6)
    assert len(looks) < 40, f"{len(looks)} looks"
