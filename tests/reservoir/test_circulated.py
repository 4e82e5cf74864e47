"""A reservoir simulator drives the rock: open-DARTS through whole runs."""

import os
import signal
from dataclasses import replace
from math import erfc, sqrt
from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest
import ufl
from dolfinx import fem

from staffa.case.reading.read import parse_case
from staffa.evolution.march import march
from staffa.evolution.system import System, build
from staffa.io.run_directory import Run, open_run
from staffa.io.vtkhdf import read_vtkhdf
from staffa.loads.forces import Forces
from staffa.model.fields import vertices
from staffa.records.status import Status
from staffa.records.step import Step
from staffa.reservoir.child import Child
from staffa.reservoir.darts import Darts
from staffa.runs.resume import resume
from staffa.runs.run import Watcher, run
from staffa.setup.build import problem
from support.circulation_cases import STRONG, WALL, wall
from support.restarting import stopped

DAY = 86400.0
pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("darts_python")]


def fields_of(found: Run) -> list[dict[str, np.ndarray]]:
    """Return the fields of each step that was kept, those of the reservoir too."""
    files = sorted((found.path / "fields").glob("*.vtkhdf"))
    assert files
    return [read_vtkhdf(path)[1] for path in files]


def assert_the_same(one: Run, other: Run) -> None:
    """Require equal bits of all fields and of the account of water."""
    for mine, his in zip(fields_of(one), fields_of(other), strict=True):
        assert mine.keys() == his.keys() and {"T", "p"} <= mine.keys()
        for name, values in mine.items():
            assert np.array_equal(values, his[name]), name
    accounts = [[step.heat.circulation for step in found.steps] for found in (one, other)]
    assert accounts[0] == accounts[1] and accounts[0][-1].wells["out"].mass < 0
    assert [s.energies for s in one.steps] == [s.energies for s in other.steps]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """A run that nothing disturbs, with cracks."""
    directory = tmp_path_factory.mktemp("whole") / "run"
    run(wall(), directory)
    found = open_run(directory)
    assert found.steps[-1].energies.surface > 0
    return found


def test_its_account_and_its_record(whole: Run) -> None:
    """Heat of the wells is heat stored, to 1e-7; what is injected is produced, but for what
    the colder water takes up."""
    for step in whole.steps:
        assert step.status is Status.CONVERGED and step.audit.violations == ()
        assert step.heat.imbalance < 1e-7
        water = step.heat.circulation
        injected, produced = water.wells["in"].mass, water.wells["out"].mass
        assert injected == pytest.approx(0.004 * water.duration, rel=1e-7)
        assert injected + produced == pytest.approx(water.mass_stored, abs=1e-6 * injected)
        assert step.heat.stored == pytest.approx(water.heat_stored, rel=1e-14), "a layer of 1 m"
    assert whole.manifest.reservoir.simulator.startswith("open-darts 2.")
    assert pytest.approx(333.15) == whole.manifest.reservoir.wells["in"].T


@pytest.mark.parametrize("step", [pytest.param(1, marks=pytest.mark.long), 3])
def test_stopped_and_resumed_it_has_the_same_bits(whole: Run, step: int, tmp_path: Path) -> None:
    class Before:
        """Asks to stop within a step."""

        sweeps = 0

        def swept(self, moment, sweep) -> None:
            self.sweeps += moment.index == step

        def stop(self) -> str | None:
            return "enough was seen" if self.sweeps else None

    asks = Before()
    words = stopped(
        lambda: run(wall(), tmp_path / "run", watcher=Watcher(swept=asks.swept, stop=asks.stop))
    )
    assert f"step {step - 1} is finished" in words
    resume(tmp_path / "run")
    assert_the_same(open_run(tmp_path / "run"), whole)


def children() -> list[int]:
    """Return the processes of this process's simulators."""
    found = []
    for path in Path("/proc").glob("[0-9]*/stat"):
        try:
            words = path.read_text().rsplit(")", 1)[1].split()
            command = (path.parent / "cmdline").read_text()
        except OSError:
            continue
        if int(words[1]) == os.getpid() and "serve_darts" in command:
            found.append(int(path.parent.name))
    return found


def test_a_simulator_that_is_killed_is_replaced(whole: Run, tmp_path: Path) -> None:
    """In any step: the run ends as if nothing had happened."""
    killed = []

    def kill(step: Step) -> None:
        for process in children():
            os.kill(process, signal.SIGKILL)
            killed.append(process)

    run(wall(), tmp_path / "run", watcher=Watcher(stepped=kill))
    assert len(set(killed)) == len(whole.steps)
    assert_the_same(open_run(tmp_path / "run"), whole)
    assert not children(), "none is left behind"


def test_a_simulator_that_always_dies_stops_the_run_which_goes_on_later(
    whole: Run, tmp_path: Path, monkeypatch
) -> None:
    """A new one, the same question; then the run is stopped, and loses no step."""
    real, asked = Child.ask, []

    def dies(self, head, arrays=()):
        asked.append(head["do"])
        if asked.count("step") > 2 and head["do"] == "step":
            self.process.kill()
        return real(self, head, arrays)

    monkeypatch.setattr(Child, "ask", dies)
    words = stopped(lambda: run(wall(), tmp_path / "run"))
    assert "step 1 is finished" in words and "staffa doctor" in words
    assert asked.count("step") == 4, "once again, and no more"
    monkeypatch.undo()
    resume(tmp_path / "run")
    assert_the_same(open_run(tmp_path / "run"), whole)


def marched(text: str, *settings: str) -> tuple[System, list[Step], list[np.ndarray]]:
    """Return a marched problem, its steps that stand, and the temperatures after them."""
    setup = problem(parse_case(text, settings))
    system = build(setup)
    steps, temperatures = [], []
    for step in march(setup, system):
        steps.append(step)
        if step.status is Status.CONVERGED:
            temperatures.append(system.state.T.x.array.copy())
    return system, steps, temperatures


def test_the_rock_sees_the_simulator_alone() -> None:
    """With steps that are taken again, to the bit at the times that stand."""
    adaptive = (
        'time={t={start="1 d",stop="10 d",shortest="1 h",longest="8 d",advance=0.7,growth=4.0}}'
    )
    system, steps, temperatures = marched(WALL, adaptive)
    assert any(step.status is Status.REJECTED for step in steps), "there must be one"
    coupling, setup_model = system.coupling, system.coupling.model
    alone = Darts(setup_model, coupling.engine.command[0])
    flow, time = alone.start(), 0.0
    stand = [step for step in steps if step.status is Status.CONVERGED]
    assert not any(step.effort.halvings for step in stand), "else it was asked at other times too"
    x = vertices(system.spaces.alpha)
    weights = setup_model.grid.weights(x)
    for step, T in zip(stand, temperatures, strict=True):
        flow, account, _ = alone.advance(flow, None, step.time - time)
        time = step.time
        assert np.array_equal(weights @ flow.T - weights @ setup_model.T, T)
        assert account == step.heat.circulation
    alone.close()
    system.destroy()


@pytest.mark.parametrize("plane", ["stress", "strain"])
def test_the_volume_that_opens_is_that_of_the_heat(plane: str) -> None:
    """Between rollers the wall retreats by (1 + nu) expansion int T, in plane strain over 1 - nu.

    The integral of T over the rock is the heat over rho c: exact, whatever the field is.
    """
    nu, expansion = 0.25, 8e-6
    extra = ('damage.split="none"', *(("reservoir.biot=0.0",) if plane == "strain" else ()))
    setup = problem(parse_case(WALL, (*STRONG, f'material.plane="{plane}"', *extra)))
    setup = replace(setup, forces=Forces())  # nothing but temperature moves the rock
    system = build(setup)
    list(march(setup, system))
    mesh = system.state.u.function_space.mesh
    u, T, n = system.state.u, system.state.T, ufl.FacetNormal(mesh)
    y = ufl.SpatialCoordinate(mesh)[1]
    bottom = ufl.conditional(ufl.lt(y, 0.1), 1.0, 0.0)
    volume = fem.assemble_scalar(fem.form(-bottom * ufl.dot(u, n) * ufl.ds))
    warmth = fem.assemble_scalar(fem.form(T * ufl.dx))
    factor = (1 + nu) if plane == "stress" else (1 + nu) / (1 - nu)
    assert volume == pytest.approx(-factor * expansion * warmth, rel=1e-10)
    assert volume > 1e-4
    system.destroy()


@pytest.mark.parametrize("name", ["darts", "single"])
def test_lauwerier_through_a_run(name: str) -> None:
    """The producer beside a wall of 60 m: 1.5 K of the closed form, and less on finer cells."""
    length, q = 60.0, 2e-5
    text = WALL.replace('["12 m", "6 m"]', '["60 m", "30 m"]').replace('"12 m"', '"60 m"')
    settings = (
        *STRONG,
        'domain.h="3 m"',
        'damage.ell="9 m"',
        f'reservoir.simulator="{name}"',
        'reservoir.h="0.5 m"',
        'reservoir.beyond={top="40 m"}',
        'reservoir.fractures=[{side="bottom",opening="0.2 mm",height="0.1 m"}]',
        f'reservoir.wells=[{{name="in",at=["0 m","0 m"],rate="{1000 * q / 2} kg/s",T="60 °C"}},'
        f'{{name="out",at=["60 m","0 m"],pressure="20 MPa"}}]',
        'time={t=["20 d","60 d","150 d","365 d"]}',
    )
    _, steps, _ = marched(text, *settings)
    rho_c, k = 2700 * 850.0, 2.5
    for step in steps:
        eta = k * length / (1000 * 4200 * q / 2) / (2 * sqrt(k / rho_c * step.time))
        exact = 473.15 - 140 * erfc(eta)
        found = step.heat.circulation.wells["out"].T
        allowed = 1.5 if step.time >= 60 * DAY else 2.0
        assert found == pytest.approx(exact, abs=allowed if name == "darts" else 0.3)
