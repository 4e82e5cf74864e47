"""Runs whose mesh follows the cracks, cut short: resumed on the mesh that they had."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from restart.test_killed import MANY, kill_and_resume
from staffa.io import checkpoint
from staffa.io.run_directory import Run, open_run
from staffa.io.vtkhdf import read_vtkhdf
from staffa.runs.resume import resume
from support.refining import REFINED, refining
from support.restarting import assert_same, cut_run, finish, whole_run

EXACT = 0.0


def assert_same_meshes(found: Run, expected: Run) -> None:
    """The files of fields have the same cells and the same damage, to the last bit."""
    assert len({step.mesh.cells for step in expected.steps}) > 1, "the mesh changes in it"
    for one, other in zip(found.steps, expected.steps, strict=True):
        here, there = (read_vtkhdf(run.path / one.fields) for run in (found, expected))
        assert one.fields == other.fields
        assert np.array_equal(here[0].points, there[0].points)
        assert np.array_equal(here[0].cells, there[0].cells)
        for name in ("alpha", "T", "u"):
            assert np.array_equal(here[1][name], there[1][name]), f"step {one.index}: {name}"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("settings", "every"),
    [((), 41), (("solver.backtracking=true", "time.tau=[0.002,0.04,0.2]"), 31)],
    ids=["plain", "back"],
)
def test_a_run_that_is_stopped_again_and_again_has_the_same_bits(
    settings: tuple[str, ...], every: int, tmp_path: Path
) -> None:
    """Stopped before steps, in sweeps, and while cells are split for a step, then every few dozen
    looks, which are more than any step with all its tries takes."""
    case = refining(*settings)
    expected = whole_run(case, tmp_path / "whole")
    times = []
    for looks in (1, 7, 25):
        directory = tmp_path / f"cut-{looks}"
        cut_run(case, directory, looks)
        times.append(finish(directory, every))
        found = open_run(directory)
        assert_same(found, expected, EXACT)
        assert_same_meshes(found, expected)
    assert max(times) > 1, times


@pytest.mark.slow
def test_a_run_that_is_stopped_in_a_second_try_keeps_its_guess_unless_told_otherwise(
    tmp_path: Path,
) -> None:
    """The damage of the first try is in the checkpoint; other solvers or times do without it."""
    case = refining("domain.refine.drive=0.9", "time.tau=[0.002,0.01]")
    cut_run(case, tmp_path / "cut", 8)
    folder = tmp_path / "cut" / checkpoint.FOLDER
    page = checkpoint.read_page(folder, checkpoint.checkpoint_numbers(folder)[0])
    kept = checkpoint.read_part(folder, page["state"])
    assert page["lines"] == 0 and kept["tried"].max() > 0.1 + kept["alpha"].max()
    expected = whole_run(case, tmp_path / "whole").steps[0]
    for name, settings, guesses in (
        ("same", (), 1),
        ("output", ("output.at=[0.01]",), 1),
        ("none", ("solver.guess=none",), 0),
        ("times", ("time.tau=[0.001,0.002,0.01]",), 0),
    ):
        copy = shutil.copytree(tmp_path / "cut", tmp_path / name)
        resume(copy, settings=settings)
        first = open_run(copy).steps[0]
        assert first.effort.guesses == guesses, name
        assert (first.energies.total == expected.energies.total) == (guesses == 1), name


@pytest.fixture(scope="module")
def place(tmp_path_factory) -> Path:
    """A folder with the case."""
    folder = tmp_path_factory.mktemp("refined")
    (folder / "my.toml").write_text(REFINED)
    return folder


@pytest.fixture(scope="module")
def expected(place: Path) -> Run:
    """The run of many steps without a cut."""
    return whole_run(refining(MANY), place / "whole")


@pytest.mark.slow
def test_a_run_that_is_killed_goes_on_as_if_nothing_had_happened(place, expected) -> None:
    killed = kill_and_resume(place, place / "few", kills=3, seed=1)
    assert killed >= 2, f"it was alive at {killed} of 3 kills"
    found = open_run(place / "few")
    assert_same(found, expected, EXACT)
    assert_same_meshes(found, expected)


@pytest.mark.long
@pytest.mark.timeout(3600)
def test_twenty_kills_at_random_moments_lose_nothing(place, expected) -> None:
    """In runs of 20 steps each, started again until there were 20 kills."""
    killed = number = 0
    while killed < 20:
        directory = place / f"many-{number}"
        killed += kill_and_resume(place, directory, kills=10, seed=number)
        assert_same(open_run(directory), expected, EXACT)
        number += 1
        assert number < 10, f"{killed} kills in {number} runs"
