"""When a solver fails: what is tried next, in which order, and what is on record of it."""

import gc
import subprocess
import sys
from dataclasses import replace

from staffa.backend.stack import MPI

import numpy as np
import pytest

from staffa.errors import LoadError, SolveError
from staffa.evolution.march import Observers, march
from staffa.evolution.problem import Problem
from staffa.evolution.system import System, build
from staffa.loads.forces import Forces, Traction
from staffa.model.fields import owned
from staffa.model.supports import SideSupport, no_displacement
from staffa.physics.damage import AT1, AT2, is_quadratic
from staffa.records.step import SolverStatistics, Step, Stop
from support.bodies import body, quench, rock
from support.paths import TESTS

TIMES = (0.002, 0.006)


def cooled(**changes) -> Problem:
    """A plate that is damaged along its cooled edge."""
    fields = {"load": quench(6.0), "times": TIMES, "material": rock(ell=0.1)}
    return body((1.0, 0.5), 0.1, stop=Stop(change=1e-6, residual=1e-4), **{**fields, **changes})


class Failing:
    """A damage solver that fails, or gives nonsense, when `when` says so; else the real one."""

    def __init__(self, system: System, when, nonsense: float | None = None) -> None:
        self.real = system.alternation.bounded[0]
        self.when, self.nonsense, self.iterations = when, nonsense, 0

    def minimize(self, x, lower, upper) -> None:
        """See `BoundedSolver`."""
        if not self.when():
            self.real.minimize(x, lower, upper)
        elif self.nonsense is None:
            raise SolveError("the damage was not minimized: told to fail")
        else:
            x.set(self.nonsense)


def with_solvers(system: System, *solvers) -> System:
    """The system with other damage solvers."""
    return replace(system, alternation=replace(system.alternation, bounded=list(solvers)))


def reference(problem: Problem) -> list[Step]:
    """The steps without any failure."""
    system = build(problem)
    steps = list(march(problem, system))
    system.destroy()
    return steps


def test_without_newton_where_it_fails() -> None:
    """A step that fails after a Newton move is done again without; the record says so."""
    problem = cooled()
    system = build(problem)
    moves = []
    newton = system.alternation.newton
    advance = newton.advance

    def noted(*args, **kwargs):
        moves.append(1)
        return advance(*args, **kwargs)

    newton.advance = noted

    def just_moved() -> bool:
        return bool(moves) and moves.pop() == 1

    broken = with_solvers(system, Failing(system, just_moved))
    steps = list(march(problem, broken))
    assert steps[0].effort == SolverStatistics(plain=1), "done by plain sweeps alone"
    assert sum(step.effort.halvings for step in steps) == 0
    expected = [step.energies.total for step in reference(problem)]
    assert [step.energies.total for step in steps] == pytest.approx(expected, rel=1e-6)
    assert all(step.audit.violations == () for step in steps)
    system.destroy()


def test_a_step_is_cut_in_two_where_all_else_fails() -> None:
    """A solver that cannot follow the second step in one go can in two; nothing is lost of it."""
    problem = cooled()
    system = build(problem)
    x = system.state.T.function_space.tabulate_dof_coordinates()
    inside = np.abs(x[:, 1] - 0.1) < 1e-9
    seen = {"T": 0.0}

    def too_far() -> bool:
        now = float(system.state.T.x.array[inside].mean())
        jump = abs(now - seen["T"])
        if jump <= 1.0:
            seen["T"] = now
        return jump > 1.0

    seen["T"] = float(problem.load.temperature(x[inside].T, TIMES[0])[0])
    jump = abs(float(problem.load.temperature(x[inside].T, TIMES[1])[0]) - seen["T"])
    assert jump > 1.0, f"the second step cools by {jump:.2f}: too little for this test"
    seen["T"] = 0.0

    broken = with_solvers(system, Failing(system, too_far))
    steps = list(march(problem, broken))
    assert steps[0].effort.halvings == 0 and steps[1].effort.halvings >= 1
    assert "second half of a step cut in two" in steps[1].reason
    assert [step.index for step in steps] == [0, 1] and steps[1].time == TIMES[1]
    assert all(step.audit.violations == () for step in steps)
    # Whole steps and halves sum up: E_1 = E_0 + work - released.
    flow = steps[1].audit.work - steps[1].audit.released
    change = steps[1].energies.total - steps[0].energies.total
    assert change == pytest.approx(flow, rel=1e-9)
    expected = reference(problem)[1].energies.total
    assert steps[1].energies.total == pytest.approx(expected, rel=1e-3)
    system.destroy()


def test_when_nothing_helps_the_state_before_is_saved() -> None:
    problem = cooled()
    system = build(problem)
    saved, steps, tries, before = [], [], [], []

    def at_the_second_step() -> bool:
        tries.append(1)
        return bool(steps)

    broken = with_solvers(system, Failing(system, at_the_second_step))
    observers = Observers(
        save=lambda session, moment, converged: saved.append(owned(system.state.alpha).copy())
    )
    with pytest.raises(SolveError, match=r"step 1 \(time 0.006\) failed: .*told to fail"):
        for step in march(problem, broken, observers):
            steps.append(step)
            before.append(len(tries))
    assert steps[-1].status == "failed" and len(saved) == 2
    # The first step takes what it takes; then with Newton and without, whole and in 2, 4, 8 parts:
    # the first part fails each time.
    assert len(tries) - before[0] == 2 * (1 + 3)
    assert np.array_equal(saved[0], saved[1]), "what is saved is the last finished state"
    assert steps[-1].energies.total == pytest.approx(steps[0].energies.total, rel=1e-9)
    system.destroy()


@pytest.mark.parametrize("nonsense", [np.nan, np.inf])
def test_what_is_not_a_number_is_named_and_left_behind(nonsense: float) -> None:
    """A solver's NaN never enters the energy that is reported: the halved step is free of it."""
    problem = cooled(times=TIMES[:1])
    system = build(problem)
    bad = iter([True, True])
    solver = Failing(system, lambda: next(bad, False), nonsense=nonsense)
    (step,) = march(problem, with_solvers(system, solver))
    assert step.effort.plain + step.effort.halvings >= 1
    assert np.isfinite(step.energies.total) and step.audit.violations == ()
    always = with_solvers(system, Failing(system, lambda: True, nonsense=nonsense))
    with pytest.raises(SolveError, match="the energy is not finite after the damage was minimized"):
        list(march(problem, always))
    system.destroy()


def test_a_load_that_is_not_a_number_is_not_tried_again() -> None:
    asked = []

    class Broken:
        def temperature(self, x, t):
            """NaN."""
            asked.append(t)
            return np.full(x.shape[1], np.nan)

    system = build(problem := cooled(load=Broken()))
    with pytest.raises(
        SolveError, match=r"temperature that is not finite at time 0\.002"
    ) as raised:
        list(march(problem, system))
    assert asked == [TIMES[0]] and isinstance(raised.value.__cause__, LoadError)
    system.destroy()


def test_a_displacement_that_is_not_a_number_is_not_tried_again() -> None:
    pulled = SideSupport(
        side="right", components={0: lambda x, t: np.nan if t > 0.004 else 0.01 * t}
    )
    sides = (SideSupport(side="left", components={0: no_displacement}), pulled)
    system = build(problem := cooled(sides=sides))
    steps = []
    with pytest.raises(SolveError, match="displacement that is not finite"):
        for step in march(problem, system):
            steps.append(step)
    assert [step.status for step in steps] == ["converged", "failed"]
    system.destroy()


def test_a_pressure_that_is_not_a_number_leaves_the_state_before_it() -> None:
    push = Traction(
        side="top", pressure=lambda x, t: np.full(x.shape[1], np.nan if t > 0.004 else 0.0)
    )
    system = build(problem := cooled(forces=Forces(sides=(push,))))
    steps, state = [], []
    with pytest.raises(SolveError, match="force that is not finite"):
        for step in march(problem, system):
            steps.append(step)
            state.append(system.state.T.x.array.copy())
    assert [step.status for step in steps] == ["converged", "failed"]
    assert np.array_equal(*state) and np.isfinite(steps[1].energies.total)
    assert steps[1].energies.total == pytest.approx(steps[0].energies.total, rel=1e-12)
    system.destroy()


def test_a_force_that_is_not_a_number_is_no_convergence() -> None:
    """TAO calls it converged, with nothing done: the gradient is looked at as well."""
    system = build(problem := cooled(times=TIMES[:1]))
    damage = system.alternation.damage
    sick = replace(damage, quadratic=False, gradient=lambda out: out.set(np.nan))
    for solver in system.alternation.bounded:
        solver.energy = sick
        solver.evaluation.energy = sick
    steps = []
    with pytest.raises(SolveError, match="the damage was not minimized"):
        for step in march(problem, system):
            steps.append(step)
    assert steps[-1].status == "failed" and np.all(owned(system.state.alpha) == 0)
    system.destroy()


def test_a_half_that_does_not_converge_is_no_step() -> None:
    """The whole step fails at once; its first half runs out of sweeps: the step has failed."""
    problem = cooled()
    solvers = replace(problem.solvers, stop=replace(problem.solvers.stop, sweeps=1))
    system = build(replace(problem, solvers=solvers))
    calls = iter([True, True])
    broken = with_solvers(system, Failing(system, lambda: next(calls, False)))
    steps = []
    with pytest.raises(SolveError, match="told to fail"):
        for step in march(replace(problem, solvers=solvers), broken):
            steps.append(step)
    assert [step.status for step in steps] == ["failed"]
    assert np.all(owned(system.state.alpha) == 0), "the state at the start of the step"
    system.destroy()


class Cubic(AT1):
    """A law whose damage problem is not quadratic."""

    name = "cubic"

    def a(self, alpha):
        """(1 - alpha)^3."""
        return (1 - alpha) ** 3


def test_which_laws_are_quadratic() -> None:
    assert is_quadratic(AT1()) and is_quadratic(AT2()) and not is_quadratic(Cubic())


def test_quadratic_problems_are_minimized_as_well_as_others() -> None:
    """Assembled once or at each iteration, the same law gives the same run."""
    for law in (AT1(), AT2()):
        problem = cooled(material=rock(ell=0.1, law=law))
        system = build(problem)
        slow = build(problem)
        assert system.alternation.damage.quadratic
        for solver in slow.alternation.bounded:
            energy = replace(slow.alternation.damage, quadratic=False)
            solver.energy = solver.evaluation.energy = energy
        once, often = ([s.energies.total for s in march(problem, x)] for x in (system, slow))
        assert once == pytest.approx(often, rel=1e-9)
        system.destroy(), slow.destroy()


def test_a_law_that_is_not_quadratic_runs() -> None:
    problem = cooled(material=rock(ell=0.1, law=Cubic()))
    system = build(problem)
    assert not system.alternation.damage.quadratic
    steps = list(march(problem, system))
    assert max(owned(system.state.alpha)) > 0.05
    assert all(step.audit.violations == () for step in steps)
    system.destroy()


GROWTH = """
from staffa.backend.stack import MPI
import gc
from pathlib import Path
from fem.test_advance import cooled
from staffa.evolution.march import march
from staffa.evolution.system import build

def resident():
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1])

times = [1e-3 + 1e-5 * i for i in range(501)]
problem = cooled(times=times, displacement="{displacement}")
system = build(problem)
for step in march(problem, system):
    if step.index in (50, 500):
        print(resident(), step.effort.moves, flush=True)
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "displacement", ["direct", pytest.param("iterative", marks=pytest.mark.long)]
)
def test_memory_does_not_grow(displacement: str) -> None:
    """Resident memory at step 500 within 2 % of that at step 50."""
    done = subprocess.run(
        [sys.executable, "-c", GROWTH.format(displacement=displacement)],
        cwd=TESTS,
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    early, late = (int(line.split()[0]) for line in done.stdout.splitlines())
    assert late <= 1.02 * early, f"{early} pages at step 50, {late} at step 500"


def communicators_left() -> int:
    """Number of further communicators that this process can make."""
    made: list[MPI.Comm] = []
    MPI.COMM_SELF.Set_errhandler(MPI.ERRORS_RETURN)
    try:
        while len(made) < 5000:
            made.append(MPI.COMM_SELF.Dup())
    except MPI.Exception:
        pass
    for comm in made:
        comm.Free()
    return len(made)


def test_a_system_that_is_gone_leaves_nothing_behind() -> None:
    """MPICH has 2048 communicators, and a mesh takes several: a kept mesh is counted here."""
    left = []
    for _ in range(3):
        system = build(problem := cooled())
        next(march(problem, system))
        system.destroy()
        del problem, system
        # What other tests left may be freed in several rounds: PETSc's objects own Python's.
        while gc.collect():
            pass
        left.append(communicators_left())
    assert left[-1] == left[0], f"communicators left after each system: {left}"
