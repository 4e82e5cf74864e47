"""A temperature that a formula gives, on several ranks."""

from pathlib import Path

import pytest

from run.test_formula_temperature import FRONT, front
from staffa import run
from staffa.io.run_directory import open_run
from support.bodies import RANKS
from support.ranks import staffa_on
from support.restarting import assert_same

COARSE = ("domain.h=0.05", "damage.ell=0.15", "time.t=[0.3]", "output.at=[]")


@pytest.mark.parametrize("ranks", RANKS)
def test_on_ranks_it_is_the_same(ranks: int, tmp_path: Path) -> None:
    run(front(*COARSE), tmp_path / "one")
    (tmp_path / "front.toml").write_text(FRONT)
    given = [f"--set={setting}" for setting in COARSE]
    staffa_on(ranks, "run", tmp_path / "front.toml", "--out", tmp_path / "many", "--quiet", *given)
    assert_same(open_run(tmp_path / "many"), open_run(tmp_path / "one"), rel=1e-6)
