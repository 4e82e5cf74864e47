"""Pages of runs that go on: their cost is bounded, and their errors end no run."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import pytest

from report.test_report import BOX, drawn_run, rewritten
from staffa.records.refined_mesh import RefinedMesh
from staffa.report import growing_page, time_slides
from staffa.report.growing_page import SHARE, SOONEST, GrowingPage, growing_ensemble, growing_run
from staffa.report.time_slides import SlideMaker


@pytest.fixture(autouse=True)
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures of few pixels."""
    monkeypatch.setattr("staffa.plot.style.DPI", 40)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """A clock that is set by hand."""
    now = [100.0]
    monkeypatch.setattr(growing_page, "perf_counter", lambda: now[0])
    return now


@pytest.mark.parametrize("cost", [0.001, 0.5])
def test_a_page_takes_a_small_part_of_the_time(
    cost: float, tmp_path: Path, clock: list[float]
) -> None:
    written = []

    def text(grows: int | None) -> str:
        clock[0] += cost
        written.append(clock[0])
        return "page"

    page = GrowingPage(folder=tmp_path, text=text)
    for _ in range(2000):
        page.grow()
        clock[0] += 0.1
    apart = [later - earlier for earlier, later in pairwise(written)]
    assert apart and min(apart) >= max(SOONEST, cost / SHARE)


def test_an_error_of_a_page_is_told_once_and_ends_no_run(tmp_path: Path) -> None:
    told: list[str] = []

    def text(grows: int | None) -> str:
        raise ZeroDivisionError("no such color")

    page = GrowingPage(folder=tmp_path, text=text, ended=told.append)
    for _ in range(3):
        page.grow()
    page.stop()
    assert len(told) == 1 and "no such color" in told[0]
    assert list(tmp_path.iterdir()) == []


def test_a_page_that_breaks_is_read_again_no_more_when_the_run_stops(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told: list[str] = []
    page = growing_run(drawn_run(tmp_path / "run").path, told.append)
    page.grow()
    before = (page.folder / "report.html").read_text()
    assert 'http-equiv="refresh"' in before and 'id="grows"' in before
    monkeypatch.setattr(SlideMaker, "slides", lambda *given: 1 / 0)
    page.due = 0.0
    page.grow()
    page.stop()
    after = (page.folder / "report.html").read_text()
    assert len(told) == 1 and "The run is over" in after and 'id="slides"' in after
    assert 'http-equiv="refresh"' not in after and 'id="grows"' not in after


def test_the_first_page_of_a_resumed_run_reads_few_steps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run, read = drawn_run(tmp_path / "run"), []
    known = time_slides.read_frames
    monkeypatch.setattr(
        time_slides, "read_frames", lambda run, steps: [known(run, steps), read.extend(steps)][0]
    )
    SlideMaker(most_new=2).slides(run)
    assert {step.index for step in read} == {20, 24}


def test_a_page_that_was_not_begun_is_not_written_when_a_run_stops(tmp_path: Path) -> None:
    """Write nothing into the folder of a run that was refused."""
    growing_run(tmp_path, lambda said: None).stop()
    assert list(tmp_path.iterdir()) == []


def test_few_slides_are_drawn_for_one_page_the_latest_first(tmp_path: Path) -> None:
    run, maker = drawn_run(tmp_path / "run"), SlideMaker(most_new=2)
    labels = []
    for _ in range(4):
        found = maker.slides(run)
        assert found is not None
        labels.append([slide["label"].split("step ")[1] for slide in found.slides])
    assert [len(seen) for seen in labels] == [2, 4, 6, 7]
    assert labels[0] == ["20", "24"] and labels[-1] == ["0", "4", "8", "12", "16", "20", "24"]


def test_slides_that_are_drawn_are_not_drawn_again(tmp_path: Path) -> None:
    whole = drawn_run(tmp_path / "run")
    run = rewritten(whole, list(whole.steps[:9]))
    maker = SlideMaker()
    before = maker.slides(run)
    assert before is not None and len(before.slides) == 3
    drawn = set(maker.drawn)
    after = maker.slides(rewritten(whole, list(whole.steps)))
    assert after is not None and len(after.slides) == 7
    assert after.slides[:3] == before.slides, "the color scale has stayed"
    assert len(set(maker.drawn) - drawn) == 4


@pytest.mark.parametrize("size", [(2.5, 1.0), BOX])
def test_fields_of_a_large_run_are_not_read_while_it_goes_on(
    size: tuple[float, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = drawn_run(tmp_path / "run", size)
    page = growing_run(run.path, pytest.fail)
    page.grow()
    text = (run.path / "report.html").read_text()
    assert 'id="slides"' in text and "pictures: they are drawn at the end" in text
    refined = RefinedMesh(cells=2 * run.manifest.cells, vertices=1)
    rewritten(run, [replace(step, mesh=refined) for step in run.steps])
    monkeypatch.setattr(growing_page, "LARGEST", 1.5 * run.manifest.unknowns)

    def read(*given: object) -> None:
        raise AssertionError("it reads fields")

    monkeypatch.setattr("staffa.plot.frames.read_vtkhdf", read)
    page.due = 0.0
    page.grow()
    text = (run.path / "report.html").read_text()
    assert 'id="slides"' not in text and "a run this large" in text


def test_an_ensemble_has_a_page_from_its_first_member_on(tmp_path: Path) -> None:
    for seed in (0, 1):
        drawn_run(tmp_path / f"seed-{seed}")
        page = growing_ensemble(tmp_path, pytest.fail)
        page.grow()
        text = (tmp_path / "report.html").read_text()
        assert f"{seed + 1} of {seed + 1} finished" in text and 'id="grows"' in text
    assert "data-chart" in text
