"""A run that was cut goes on as if nothing had happened, on any number of ranks."""

import shutil
from dataclasses import replace
from itertools import count
from pathlib import Path

import numpy as np
import pytest

from fem.test_force_case import CASE as FORCED
from run.test_heat_run import settings as heat_settings
from staffa.case.reading.read import parse_case
from staffa.case.reading.ready_cases import ready_case
from staffa.errors import InputError, SolveError
from staffa.evolution import march as loop
from staffa.evolution.advanced_step import Advance
from staffa.io.run_directory import open_run
from staffa.records.status import Status
from staffa.runs.resume import resume, take
from staffa.runs.run import Watcher, run
from support.restarting import (
    After,
    assert_same,
    cut_run,
    finish,
    small,
    stopped,
    whole_run,
)

BAR = """
[domain]
size = [1.0, 0.3]
h = 0.05
[material]
E = 100.0
[damage]
ell = 0.1
[toughness]
bands = [{ lower = [0.45, 0.0], upper = [0.55, 0.3], factor = 0.95 }]
[temperature]
profile = "none"
[supports]
left = { x = 0.0 }
right = { x = { t = [0.0, 1.0], u = [0.0, 0.25] } }
"""
ADAPTIVE = "time={t={start=0.1,stop=1.0,shortest=0.01,longest=0.2,advance=2.0}}"
PAST = "time.t={start=0.2,stop=1.0,steps=9}"
FEELING = (
    *("heat.cracks={conductivity=1e-3}", "solver.backtracking=true"),
    'time.t={start="1 hour",stop="12 hours",steps=8}',
)
QUENCHED = [given.removeprefix("--set=") for given in heat_settings("granite-face", *FEELING)]
SQUEEZED = ("temperature.dT=60 K", 'time.t=["1 h","2 h","3 h","4 h"]')
VARIANTS = {
    "plain": small(),
    "coarser guesses": small("domain.h=0.04", "damage.ell=0.24", "solver.guess=coarser"),
    "iterative, followed": small("solver.displacement=iterative", "solver.stability=follow"),
    "many levels": small("solver.displacement=iterative", "domain.h=0.02"),
    "adaptive": parse_case(BAR, [ADAPTIVE]),
    "backtracking": parse_case(BAR, [PAST, "solver.backtracking=true"]),
    "moving sides": small('supports={section="free"}'),
    "heat that feels cracks": ready_case("granite-face", QUENCHED),
    "squeezed, a fluid in its cracks": parse_case(FORCED, SQUEEZED),
}


# What takes long and is as others are in what a checkpoint holds.
LONG = (
    *("coarser guesses", "iterative, followed"),
    *("heat that feels cracks", "squeezed, a fluid in its cracks"),
)


@pytest.mark.slow
@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, id=name, marks=pytest.mark.long if name in LONG else ())
        for name, case in VARIANTS.items()
    ],
)
def test_a_run_cut_again_and_again_is_the_same_to_the_last_bit(case, tmp_path: Path) -> None:
    """The looks are a number that has nothing to do with steps: cuts fall within them."""
    expected = whole_run(case, tmp_path / "whole")
    tried = (*expected.steps, *expected.superseded, *expected.rejected)
    sweeps = [1 + step.sweeps for step in tried]
    looks = max(2 * sum(sweeps) // 5, 1 + max(sweeps))  # a step that is never finished would be cut
    cut_run(case, tmp_path / "cut", looks)
    times = finish(tmp_path / "cut", looks)
    assert times >= 2, f"it was resumed {times} times"
    assert_same(open_run(tmp_path / "cut"), expected)


def test_nothing_is_repeated_but_the_step_that_was_cut(tmp_path: Path) -> None:
    """By default every step is kept as soon as it is finished."""
    said = cut_run(small("time.tau=[0.1,0.2,0.3]", "output.at=[]"), tmp_path / "run", 7)
    cut = open_run(tmp_path / "run")
    seen: list[int] = []
    watcher = Watcher(stepped=lambda step: seen.append(step.index))
    resume(tmp_path / "run", watcher=watcher)
    assert seen == list(range(len(cut.steps), 3)) and cut.steps
    assert said == (
        f"stopped, since enough was seen: step {len(cut.steps) - 1} is finished; `staffa resume "
        f"{tmp_path / 'run'}` goes on"
    )


@pytest.mark.slow
def test_before_its_first_step_a_run_may_still_change_its_ways(tmp_path: Path) -> None:
    """Steps that follow the cracks, and a way back, which a run in its middle cannot take on."""
    settings = ["output.at=[]", "solver.backtracking=true", "output.checkpoint={steps=1}"]
    times = "time.tau={start=0.1,stop=0.25,shortest=0.01,longest=0.1}"
    expected = whole_run(small(*settings, times), tmp_path / "whole")
    cut_run(small("output.at=[]"), tmp_path / "run", 0)
    resume(tmp_path / "run", settings=[*settings, times])
    assert_same(open_run(tmp_path / "run"), expected)
    page = take(tmp_path / "run").page
    assert page and len(page["past"]) == 1 + len(expected.steps)


@pytest.mark.slow
def test_a_rare_checkpoint_repeats_steps_and_gives_the_same(tmp_path: Path) -> None:
    """Killed between checkpoints: the steps since the last are computed again, each once on disk;
    a stop that is asked for saves where it is all the same."""
    case = small("output.checkpoint={steps=4}", "output.steps=all")
    expected = whole_run(case, tmp_path / "whole")

    class KilledError(Exception):
        pass

    def kill(step) -> None:
        if step.index == 4:
            raise KilledError

    with pytest.raises(KilledError):
        run(case, tmp_path / "cut", watcher=Watcher(stepped=kill))
    assert len(open_run(tmp_path / "cut").steps) == 5
    seen: list[int] = []
    resume(tmp_path / "cut", watcher=Watcher(stepped=lambda step: seen.append(step.index)))
    assert seen == [4, 5]
    assert_same(open_run(tmp_path / "cut"), expected)
    stop = After(expected.steps[0].sweeps + 3)
    assert "step 0 is finished" in stopped(
        lambda: run(case, tmp_path / "asked", watcher=Watcher(stop=stop))
    )
    assert [p.name for p in (tmp_path / "asked" / "checkpoint").glob("*.json")] == ["000001.json"]


def test_a_step_that_fails_costs_none_before_it(tmp_path: Path) -> None:
    """Though no checkpoint was due since the run began."""
    rare = "output.checkpoint={steps=100,minutes=1000}"
    times = "time.tau=[0.1,0.2,0.3,0.4]"  # at the ends of which a load is tried beforehand
    with pytest.raises(SolveError, match="step 2"):
        run(small(rare, times, "output.at=[]"), tmp_path / "run", temperature=Broken())
    found = open_run(tmp_path / "run")
    before, left = found.steps, found.unreached
    assert [step.index for step in before] == [0, 1]
    assert left and (left.index, left.status) == (2, "failed")
    taken = take(tmp_path / "run")
    assert [step.energies for step in taken.steps] == [step.energies for step in before[:2]]


@pytest.mark.parametrize("fault", ["return", "look back"])
def test_backtracking_that_fails_costs_no_step_and_is_the_same_when_resumed(
    tmp_path: Path, monkeypatch, fault: str
) -> None:
    """A return that runs out of sweeps is left; a look back that fails is made up for."""
    rare = "output.checkpoint={steps=100,minutes=1000}"
    case = parse_case(BAR, [PAST, "solver.backtracking=true", rare])
    real = {"return": loop.go_back, "look back": loop.better_earlier}[fault]
    if fault == "return":

        def runs_out(*arguments) -> Advance:
            found = real(*arguments)
            outcome = replace(found.outcome, status=Status.NOT_CONVERGED, reason="is out")
            return replace(found, outcome=outcome)

        monkeypatch.setattr(loop, "go_back", runs_out)
        run(case, tmp_path / "run")
        found = open_run(tmp_path / "run")
        assert found.finished and len(found.steps) == 9 and not found.superseded
        tried = [step.index for step in found.rejected]
        assert tried and len(tried) == len(set(tried)), "a return that failed is not tried again"
        assert all("failed (is out)" in s.reason and s.returned for s in found.rejected)
        return
    expected = whole_run(case, tmp_path / "whole")
    calls = count()

    def fails(*arguments):
        if next(calls) == 5:
            raise SolveError("out of luck")
        return real(*arguments)

    monkeypatch.setattr(loop, "better_earlier", fails)
    with pytest.raises(SolveError, match="step 5 is saved, but looking back failed: out of luck"):
        run(case, tmp_path / "run")
    seen: list[int] = []
    resume(tmp_path / "run", watcher=Watcher(stepped=lambda step: seen.append(step.index)))
    assert_same(open_run(tmp_path / "run"), expected)
    assert 5 not in seen[:1]


@pytest.mark.parametrize("cut", ["killed", "stopped", "look back"])
def test_backtracking_at_the_last_time_is_not_over_with_its_line(
    tmp_path: Path, monkeypatch, cut: str
) -> None:
    """The last step is better at an earlier time: a run that is cut before it was there goes on."""
    case = parse_case(BAR, ["time.t={start=0.2,stop=0.8,steps=7}", "solver.backtracking=true"])
    expected = whole_run(case, tmp_path / "whole")
    assert expected.superseded and expected.superseded[-1].index == 6

    class KilledError(Exception):
        pass

    def kill(step) -> None:
        if step.index == 6:
            raise KilledError

    def fails(*arguments):
        raise SolveError("out of luck")

    real = loop.better_earlier
    if cut == "look back":
        after = count()
        monkeypatch.setattr(
            loop, "better_earlier", lambda *a: fails() if next(after) == 6 else real(*a)
        )
        with pytest.raises(SolveError, match="looking back failed"):
            run(case, tmp_path / "run")
    elif cut == "killed":
        with pytest.raises(KilledError):
            run(case, tmp_path / "run", watcher=Watcher(stepped=kill))
    else:
        last = []
        stop = Watcher(
            stepped=lambda step: last.append(step.index),
            stop=lambda: "enough" if 6 in last else None,
        )
        assert "step 6 is finished" in stopped(lambda: run(case, tmp_path / "run", watcher=stop))
    assert open_run(tmp_path / "run").finished and not open_run(tmp_path / "run").superseded
    resume(tmp_path / "run")
    assert_same(open_run(tmp_path / "run"), expected)
    assert resume(tmp_path / "run") == open_run(tmp_path / "run").steps


def test_what_failed_is_tried_again_with_other_solvers(tmp_path: Path, monkeypatch) -> None:
    case = parse_case(BAR, [PAST, "solver.backtracking=true"])

    def fails(*arguments):
        raise SolveError("out of luck")

    with monkeypatch.context() as patched:
        patched.setattr(loop, "go_back", fails)
        run(case, tmp_path / "run")
    cut = open_run(tmp_path / "run")
    assert cut.rejected and not cut.superseded
    resume(
        tmp_path / "run",
        settings=["solver.sweeps=9000", PAST.replace("1.0", "1.1").replace("9", "10")],
    )
    assert open_run(tmp_path / "run").superseded


class Broken:
    """A cooled face, whose temperature is no number for some time."""

    def temperature(self, x, t):
        """NaN between two times."""
        return np.full(x.shape[1], np.nan if 0.003 < t < 0.005 else -3.0 * t)


@pytest.mark.parametrize("damaged", ["pages", "parts", "latest page"])
def test_a_finished_run_stays_as_it_is_whatever_became_of_its_checkpoints(
    tmp_path: Path, damaged: str
) -> None:
    run(small("time.tau=[0.1,0.2]", "output.at=[]"), tmp_path / "run")
    pattern = {"pages": "*.json", "parts": "*.h5", "latest page": "000002.json"}[damaged]
    for file in (tmp_path / "run" / "checkpoint").glob(pattern):
        file.write_text("half")
    before = {p: p.read_bytes() for p in (tmp_path / "run").rglob("*") if p.is_file()}
    for half in (
        ".manifest.json.staffa-part",
        "checkpoint/.a.h5.staffa-part",
        "fields/.step-0001.vtkhdf.staffa-part",
    ):
        (tmp_path / "run" / half).write_text("half")
    assert len(resume(tmp_path / "run")) == 2
    assert before == {p: p.read_bytes() for p in (tmp_path / "run").rglob("*") if p.is_file()}


def test_a_run_that_adapts_cannot_end_before_it_is(tmp_path: Path) -> None:
    case = parse_case(BAR, [ADAPTIVE])
    run(case, tmp_path / "run")
    shorter = ADAPTIVE.replace("stop=1.0", "stop=0.3")
    with pytest.raises(InputError, match="the run has gone to t = 1"):
        resume(tmp_path / "run", settings=[shorter])
    assert open_run(tmp_path / "run").finished


@pytest.mark.slow
def test_a_finished_run_may_go_on_longer_with_other_outputs_and_solvers(tmp_path: Path) -> None:
    """To the end that it would have had, on the times that it would have had."""
    expected = whole_run(small(), tmp_path / "whole")
    short = small("time.tau={start=0.1,stop=0.4,steps=4}", "output.checkpoint={steps=3}")
    run(short, tmp_path / "run")
    settings = ["time.tau={start=0.1,stop=0.6,steps=6}"]
    resume(tmp_path / "run", settings=settings)
    found = open_run(tmp_path / "run")
    assert [s.energies for s in found.steps] == [s.energies for s in expected.steps]
    assert found.finished and found.manifest.times == pytest.approx(expected.manifest.times)
    assert "stop = 0.6" in found.case
    settings = [
        "time.tau={start=0.1,stop=0.7,steps=7}",
        "output.at=[0.3,0.65]",
        "solver.damage=snes",
    ]
    resume(tmp_path / "run", settings=settings)
    longer = open_run(tmp_path / "run")
    assert [s.tau for s in longer.steps[-2:]] == pytest.approx([0.65, 0.7])
    assert longer.finished and longer.steps[-2].fields and longer.wants(longer.steps[2])


CHANGES = [
    ("material.nu=0.3", ("--set material.nu=0.3: a run goes on", "--out ANOTHER")),
    ("nonsense", ("--set nonsense: write it like",)),
    (
        "time.tau=[0.15,0.5]",
        ("time.tau and output.at: the run has gone to tau = 0.2", "later ones"),
    ),
    ("time.tau=[0.1,0.3]", ("cannot change",)),
    (
        "time.tau={start=0.1,stop=0.6,shortest=0.01,longest=0.1}",
        ("time.tau: steps that adapt", "begin a new run"),
    ),
    ("output.at=[0.15]", ("output.at: the run has gone to tau = 0.2",)),
    ('output.probes=[{name="a",point=[0.5,0.2]}]', ("output.probes: ", "begin a new run")),
    ("solver.backtracking=true", ("solver.backtracking = true: ", "begin a new run")),
    ("output.checkpoint={steps=0}", ("output.checkpoint.steps = 0: ", "at least 1")),
]


@pytest.fixture(scope="module")
def partial(tmp_path_factory) -> Path:
    """A run whose first two steps are finished."""
    directory = tmp_path_factory.mktemp("partial") / "run"
    case = small()
    looks, steps = 3, 0
    while steps != 2:
        shutil.rmtree(directory, ignore_errors=True)
        cut_run(case, directory, looks)
        steps, looks = len(open_run(directory).steps), looks + 4
    return directory


@pytest.mark.slow
@pytest.mark.parametrize(("setting", "parts"), CHANGES, ids=lambda v: str(v)[:30])
def test_what_has_been_computed_cannot_change(partial: Path, setting: str, parts) -> None:
    before = {p: p.read_bytes() for p in partial.rglob("*") if p.is_file() and p.name != "lock"}
    with pytest.raises(InputError) as caught:
        resume(partial, settings=[setting])
    for part in parts:
        assert part in str(caught.value), str(caught.value)
    after = {p: p.read_bytes() for p in partial.rglob("*") if p.is_file() and p.name != "lock"}
    assert after == before and (partial / "lock").read_bytes() == b""
