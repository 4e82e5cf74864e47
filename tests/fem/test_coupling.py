"""A source of temperatures from outside: added as a class and a line, and the loop as it is."""

import ast
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from fem.test_adaptive import plate as adaptive_plate
from fem.test_backtrack import front
from staffa import evolution
from staffa.backend.parallel import sum_over_ranks
from staffa.errors import InputError, LoadError, SolveError
from staffa.evolution.coupling import Agreement, ThermalState, coupling_of
from staffa.evolution.march import march
from staffa.evolution.problem import Problem
from staffa.evolution.system import build
from staffa.io.run_directory import open_run
from staffa.loads.closed_form import HalfSpace
from staffa.model.fields import owned, vertices
from staffa.records.step import kept
from staffa.runs.resume import resume
from staffa.runs.run import Watcher
from staffa.runs.run import run as run_case
from support.bodies import body, quench, rock, run
from support.commands import forked
from support.restarting import After, assert_steps, small, stopped


@dataclass(frozen=True)
class Table:
    """Temperatures at some times, as a program outside gives them; none between, none later."""

    times: tuple[float, ...]
    given: HalfSpace


class Tabled:
    """Coupling by a table: one way, from heat to mechanics."""

    agreement = None

    def __init__(self, table: Table, domain, spaces) -> None:
        x = vertices(spaces.alpha).T
        self._rows = {time: table.given.temperature(x, time) for time in table.times}
        self._n = x.shape[1]

    def start(self) -> ThermalState:
        return ThermalState(T=np.zeros(self._n))

    def advance(self, before, cracks, start: float, end: float):
        if end not in self._rows:
            raise LoadError(f"the table has no temperature at {end:g}; give it one")
        return ThermalState(T=self._rows[end]), None

    def span(self, thermal: ThermalState) -> float:
        raise AssertionError("nothing has to agree")

    def unaccounted(self, before, after, heat) -> float:
        raise AssertionError("there is no account")

    def destroy(self) -> None:
        pass


@coupling_of.register
def _(load: Table, domain, spaces) -> Tabled:
    return Tabled(load, domain, spaces)


@dataclass(frozen=True)
class WaterBath:
    """A bath below the body, which falls by rate (K/s), and by more the more cracks there are.

    rate, felt: of the fall, and how much a damage of one everywhere multiplies it by.
    """

    rate: float
    felt: float = 0.0
    passes: int = 20

    def identity(self) -> tuple[float, ...]:
        """Numbers of what it does."""
        return self.rate, self.felt, self.passes


class WaterBathed:
    """A program that goes on from what it remembers: how far the bath fell, on rank 0 alone."""

    def __init__(self, bath: WaterBath, domain, spaces) -> None:
        self._bath, self._comm, self._x = bath, domain.comm, vertices(spaces.alpha).T
        self._own = spaces.alpha.dofmap.index_map.size_local
        rule = Agreement(tolerance=1e-6, passes=bath.passes, key="bath.agreement")
        self.agreement = rule if bath.felt else None

    def start(self) -> ThermalState:
        return self._state(0.0)

    def _state(self, fallen: float) -> ThermalState:
        depth = self._x[1] - self._x[1].min()
        memory = np.array([fallen]) if self._comm.rank == 0 else np.zeros(0)
        return ThermalState(T=-fallen * np.exp(-depth / 0.1), memory=memory)

    def fallen(self, thermal: ThermalState) -> float:
        return float(sum_over_ranks(self._comm, float(thermal.memory.sum())))

    def advance(self, before, cracks, start: float, end: float):
        alpha = cracks.alpha[: self._own]
        mine = np.array([alpha.sum(), float(len(alpha))])
        damage, count = sum_over_ranks(self._comm, mine)
        rate = self._bath.rate * (1 + self._bath.felt * damage / count)
        return self._state(self.fallen(before) + rate * (end - start)), None

    def span(self, thermal: ThermalState) -> float:
        return self.fallen(thermal)

    def unaccounted(self, before, after, heat) -> float:
        return 0.0

    def destroy(self) -> None:
        pass


@coupling_of.register
def _(load: WaterBath, domain, spaces) -> WaterBathed:
    return WaterBathed(load, domain, spaces)


TIMES = (0.0008, 0.002, 0.004)


def plate(load, times=TIMES, **more) -> Problem:
    """A plate cooled from below, in which cracks appear."""
    material = rock(ell=0.06, toughness=lambda x: 1 + 0.1 * np.sin(17 * x[0] + 1))
    return body((0.6, 0.3), 0.03, load=load, times=times, material=material, **more)


def test_a_table_from_outside_gives_what_the_closed_form_gives() -> None:
    expected, found = (run(plate(load)) for load in (quench(9.0), Table(TIMES, quench(9.0))))
    assert expected[-1].energies.surface > 0
    assert_steps(found, expected, 0.0)
    assert all(step.heat is None and not step.audit.violations for step in found)


def test_a_table_is_asked_for_no_other_time_than_it_has() -> None:
    """That is no failure of a solver, so that no half step is tried."""
    with pytest.raises(SolveError, match=r"no temperature at 0\.004; give it one"):
        run(plate(Table(TIMES[:2], quench(9.0))))


def test_a_source_that_feels_cracks_agrees_with_them_at_the_end_of_each_step() -> None:
    problem = plate(WaterBath(rate=5000.0, felt=1.0))
    system = build(problem)
    before, start, passes = system.thermal.read(), 0.0, 0
    for step in march(problem, system):
        again, _ = system.coupling.advance(before, system.cracks, start, step.time)
        before, start, passes = system.thermal.read(), step.time, passes + step.heat.passes
        fallen = system.coupling.fallen(before)
        gap = np.abs(again.T - before.T).max() / fallen
        assert gap <= 1e-6 and step.heat.gap == pytest.approx(gap, abs=1e-12)
        assert np.array_equal(owned(system.state.T), before.T[: len(owned(system.state.T))])
        assert not step.audit.violations
    assert passes > 0 and fallen > 5000.0 * start
    system.destroy()


def test_a_source_that_cannot_agree_names_its_own_key() -> None:
    with pytest.raises(SolveError, match=r"or a larger bath\.agreement"):
        run(plate(WaterBath(rate=5000.0, felt=50.0, passes=1), times=(0.004,)))


@pytest.mark.slow
def test_what_a_source_remembers_is_put_back_where_a_step_is_taken_again() -> None:
    """The bath falls at an even rate, so that what it remembers tells the time that it lived."""
    problem = replace(adaptive_plate(), load=WaterBath(rate=400.0))
    system, steps = build(problem), []
    for step in islice(march(problem, system), 10):
        steps.append(step)
        time = kept(steps)[-1].time  # of a rejected step: where the last one ended
        assert system.coupling.fallen(system.thermal.read()) == pytest.approx(400.0 * time)
    assert any(step.status == "rejected" for step in steps), "the test sees nothing"
    system.destroy()


@pytest.mark.slow
@pytest.mark.parametrize("backtracking", ["false", "true"])
def test_a_run_goes_on_from_what_its_source_remembers(tmp_path: Path, backtracking: str) -> None:
    """Cut after each few looks, to the last bit as without a cut."""
    case, bath = small(f"solver.backtracking={backtracking}"), WaterBath(rate=800.0, felt=0.5)
    run_case(case, tmp_path / "whole", temperature=bath)
    expected = open_run(tmp_path / "whole")
    assert expected.steps[-1].energies.surface > 0

    def cut(call, *arguments) -> str:
        watcher = Watcher(stop=After(9))
        return stopped(lambda: call(*arguments, temperature=bath, watcher=watcher))

    cut(run_case, case, tmp_path / "cut")
    cut(resume, tmp_path / "cut")
    resume(tmp_path / "cut", temperature=bath)
    assert_steps(open_run(tmp_path / "cut").steps, expected.steps, 0.0)


def test_an_earlier_state_is_taken_back_with_what_the_source_remembered_then() -> None:
    problem = front(load=WaterBath(rate=60.0))
    system, returns = build(problem), 0
    for step in march(problem, system):
        returns += step.returned is not None and step.status == "converged"
        assert system.coupling.fallen(system.thermal.read()) == pytest.approx(60.0 * step.time)
    assert returns, "it never went back: the test sees nothing"
    system.destroy()


def test_no_file_of_the_loop_names_a_source_of_temperatures() -> None:
    """`coupling` alone introduces them; `problem` has their types."""
    folder = Path(str(evolution.__file__)).parent
    sources = {"HeatEquation", "Conduction", "ClosedForm", "Conducted"}
    for path in folder.glob("*.py"):
        if path.stem in ("coupling", "problem"):
            continue
        names = {getattr(node, "id", "") for node in ast.walk(ast.parse(path.read_text()))}
        names |= {
            alias.name
            for node in ast.walk(ast.parse(path.read_text()))
            if isinstance(node, ast.ImportFrom)
            for alias in node.names
        }
        assert not names & sources, f"{path.name} tells couplings apart"


class Unnamed(Table):
    """A registered load that does not tell what it is."""


class Saying(Table):
    """One that says what it is given to say."""

    said: object = "the bath of March"

    def identity(self):
        """As it is told."""
        if isinstance(self.said, Exception):
            raise self.said
        return self.said


def saying(said: object, share: float = 9.0) -> Table:
    load = Saying((0.0008, 0.002, 0.004), quench(share))
    object.__setattr__(load, "said", said)
    return load


@pytest.mark.parametrize("said", ["", "a\nb", "x" * 301, [], [1.0, np.nan], None, OSError("no")])
def test_a_registered_load_must_tell_what_it_is(said, tmp_path: Path) -> None:
    for load in (saying(said), Unnamed(TIMES, quench(9.0))):
        with pytest.raises(InputError, match=r"identity.* neither|does not tell|identity.. fails"):
            run_case(small(), tmp_path / "run", temperature=load)
        assert not (tmp_path / "run").exists()


def test_a_registered_load_is_known_again_by_what_it_says(tmp_path: Path) -> None:
    """By numbers here; not even the command line goes on without it."""
    bath, directory = WaterBath(rate=800.0), tmp_path / "cut"
    stopped(lambda: run_case(small(), directory, temperature=bath, watcher=Watcher(stop=After(9))))
    manifest = open_run(directory).manifest
    assert manifest.own_load.identity == "WaterBath" and manifest.own_load.values[0] == 800.0
    assert manifest.scales == {} and set(manifest.taus) == {None} and manifest.profile == ""
    with pytest.raises(InputError, match="with another load of the same name, WaterBath"):
        resume(directory, temperature=WaterBath(rate=801.0))
    with pytest.raises(InputError, match="with the load WaterBath of a script"):
        resume(directory)
    done = forked("resume", directory)
    assert done.returncode == 2 and "the load WaterBath of a script" in done.stderr
    resume(directory, temperature=bath)
    assert {step.tau for step in open_run(directory).steps} == {None}
