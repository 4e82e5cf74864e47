"""An ensemble on two ranks."""

import shutil
from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from case.test_bad_input import staffa
from run.test_ensemble import (
    comparable,
    real,  # noqa: F401
    results,
)
from staffa.io.run_directory import STEPS, open_run


def cut(folder: Path) -> None:
    """The second member was killed after its first step, and its checkpoints are lost."""
    shutil.rmtree(folder / "seed-4" / "checkpoint")
    steps = folder / "seed-4" / STEPS
    steps.write_text(steps.read_text().splitlines(keepends=True)[0])


@pytest.mark.slow
def test_two_ranks_give_the_numbers_of_one(real: Path, tmp_path: Path) -> None:
    asked = ("ensemble", "small.toml", "--seeds", "2", "--out", str(tmp_path / "e"))
    done = staffa(real, *asked, ranks=2)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("seed 3 (member 1 of 2)") == 1
    assert open_run(tmp_path / "e" / "seed-3").manifest.ranks == 2
    _, rows = results(tmp_path / "e")
    serial = results(real / "e")[1]
    for seed in "34":
        # The solver stops within its tolerances; where a crack is seen is a matter of cells.
        assert comparable(rows[seed]) == pytest.approx(comparable(serial[seed]), rel=1e-3)
    whole = open_run(tmp_path / "e" / "seed-4").steps
    cut(tmp_path / "e")
    done = staffa(real, *asked, ranks=2)
    assert done.returncode == 0, done.stderr
    assert "seed 3 (member 1 of 2) is finished already" in done.stdout
    again = open_run(tmp_path / "e" / "seed-4")
    # A factorization on several ranks sums in another order each time.
    assert [s.energies.total for s in again.steps] == pytest.approx(
        [s.energies.total for s in whole], rel=1e-8
    )
    assert again.finished
