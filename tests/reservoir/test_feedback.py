"""Water that flows in the cracks it makes: two-way coupling through whole runs of open-DARTS."""

import os
import signal
from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from reservoir.test_circulated import assert_the_same, children
from staffa.io.run_directory import Run, open_run
from staffa.records.circulation import Circulation
from staffa.records.status import Status
from staffa.records.step import Moment, Step
from staffa.runs.resume import resume
from staffa.runs.run import Watcher, run
from support.circulation_cases import STRONG, wall
from support.restarting import stopped

TWO_WAYS = "reservoir.feedback=true"
DAYS = 'time.t=["1 d","3 d","6 d","10 d"]'
pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("darts_python")]


def ran(directory: Path, *settings: str) -> Run:
    run(wall(TWO_WAYS, *settings), directory)
    return open_run(directory)


def water(step: Step) -> Circulation:
    assert step.heat is not None and step.heat.circulation is not None
    return step.heat.circulation


def produced(found: Run) -> list[float]:
    """Temperatures of the produced water (K)."""
    return [water(step).wells["out"].T for step in found.steps]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """A run with cracks that nothing disturbs."""
    return ran(tmp_path_factory.mktemp("two ways") / "run")


def test_the_fracture_opens_and_its_pressure_drop_falls(whole: Run) -> None:
    drops = []
    for step in whole.steps:
        assert step.status is Status.CONVERGED and step.heat is not None
        assert 1 <= step.heat.passes < 20 and step.heat.gap <= 1e-3
        assert step.heat.imbalance < 1e-7
        account, shadow = water(step), step.heat.shadow
        assert shadow is not None and shadow.cracks is None and account.cracks is not None
        drops.append([c.wells["in"].pressure - c.wells["out"].pressure for c in (account, shadow)])
    with_cracks, without = np.array(drops).T
    assert np.all(np.diff(with_cracks) < 0) and with_cracks[-1] < 0.1 * with_cracks[0]
    assert without == pytest.approx(without[0], rel=0.05) and np.all(with_cracks < without)
    last = water(whole.steps[-1]).cracks
    assert last is not None and last.area > 1.0
    assert last.sides["bottom"].widest > 5 * 0.2e-3
    assert whole.manifest.reservoir is not None and whole.manifest.reservoir.cracks is not None
    assert whole.manifest.reservoir.cracks.spread == 3.0


def test_the_shadow_is_the_run_without_feedback(whole: Run, tmp_path: Path) -> None:
    run(wall(*STRONG), tmp_path / "one way")
    alone = open_run(tmp_path / "one way")
    # The temperature that cracks do not change is the simulator's alone.
    for mine, his in zip(whole.steps, alone.steps, strict=True):
        assert mine.heat is not None and mine.heat.shadow == water(his)


@pytest.mark.parametrize("step", [1, 3])
def test_killed_stopped_and_resumed_it_has_the_same_bits(
    whole: Run, step: int, tmp_path: Path
) -> None:
    """The simulator dies after each step, and the run stops in one and goes on later."""
    sweeps = []

    def swept(moment: Moment, sweep: object) -> None:
        sweeps.append(moment.index == step)

    def killed(done: Step) -> None:
        for process in children():
            os.kill(process, signal.SIGKILL)

    watcher = Watcher(
        swept=swept, stepped=killed, stop=lambda: "enough was seen" if any(sweeps) else None
    )
    stopped(lambda: run(wall(TWO_WAYS), tmp_path / "run", watcher=watcher))
    resume(tmp_path / "run", watcher=Watcher(stepped=killed))
    again = open_run(tmp_path / "run")
    assert_the_same(again, whole)
    shadows = [[step.heat and step.heat.shadow for step in found.steps] for found in (again, whole)]
    assert shadows[0] == shadows[1]


def test_going_back_to_earlier_steps_it_is_resumed_to_the_same_bits(tmp_path: Path) -> None:
    """Openings count from the body at rest, and not from the cracks of the first question."""
    settings = (TWO_WAYS, 'reservoir.coupling="explicit"', "solver.backtracking=true")
    whole = ran(tmp_path / "whole", *settings[1:])
    looks: list[bool] = []

    def swept(moment: Moment, sweep: object) -> None:
        looks.append(moment.index == 2)

    watcher = Watcher(swept=swept, stop=lambda: "enough was seen" if any(looks) else None)
    stopped(lambda: run(wall(*settings), tmp_path / "run", watcher=watcher))
    resume(tmp_path / "run")
    assert_the_same(open_run(tmp_path / "run"), whole)


def test_until_cracks_start_the_way_of_coupling_and_the_step_hardly_count(tmp_path: Path) -> None:
    iterated = produced(ran(tmp_path / "iterated", *STRONG, DAYS))
    explicit = produced(ran(tmp_path / "explicit", *STRONG, DAYS, 'reservoir.coupling="explicit"'))
    halves = 'time.t=["12 h","1 d","2 d","3 d","4.5 d","6 d","8 d","10 d"]'
    halved = produced(ran(tmp_path / "halved", *STRONG, halves))[1::2]
    assert np.abs(np.subtract(iterated, explicit)).max() < 0.05
    assert np.abs(np.subtract(iterated, halved)).max() < 0.05
