"""Circulating water on several ranks: rank 0 owns the simulator, and tells the others."""

from pathlib import Path

import numpy as np
import pytest

from staffa.io.run_directory import open_run
from staffa.runs.run import run
from support.bodies import RANKS
from support.circulation_cases import STRONG, wall
from support.ranks import printed_on
from support.restarting import assert_same

RUN = """
from pathlib import Path
from staffa.runs.resume import resume
from staffa.runs.run import Watcher, run
from support.circulation_cases import STRONG, wall
from support.restarting import After, stopped

directory, settings = Path({directory!r}), {settings!r}
if {cut}:
    stopped(lambda: run(wall(*settings), directory, watcher=Watcher(stop=After(12))))
    resume(directory)
else:
    run(wall(*settings), directory)
"""
SINGLE = ('reservoir.simulator="single"',)


def on_ranks(ranks: int, directory: Path, settings: tuple[str, ...], *, cut: bool = False) -> None:
    """Run the case on some ranks; stop it within and go on where it is `cut`."""
    printed_on(ranks, RUN.format(directory=str(directory), settings=settings, cut=cut))


@pytest.mark.parametrize("ranks", RANKS)
def test_before_cracks_the_water_is_the_same(ranks: int, tmp_path: Path, darts_python) -> None:
    """Temperatures of the wells to 1e-9 K, and the same rock."""
    run(wall(*STRONG), tmp_path / "one")
    on_ranks(ranks, tmp_path / "more", STRONG)
    one, more = open_run(tmp_path / "one"), open_run(tmp_path / "more")
    for step, other in zip(one.steps, more.steps, strict=True):
        wells, others = step.heat.circulation.wells, other.heat.circulation.wells
        for name, well in wells.items():
            here = others[name]
            assert abs(here.T - well.T) <= 1e-9
            assert here.pressure == pytest.approx(well.pressure, rel=1e-12)
        assert other.energies.total == pytest.approx(step.energies.total, rel=1e-9)
    assert np.ptp([step.heat.circulation.wells["out"].T for step in one.steps]) > 1.0


@pytest.mark.parametrize("ranks", RANKS)
def test_stopped_and_resumed_with_cracks(ranks: int, tmp_path: Path) -> None:
    """In closed form, so that it runs where there is no simulator."""
    run(wall(*SINGLE), tmp_path / "whole")
    on_ranks(ranks, tmp_path / "cut", SINGLE, cut=True)
    assert_same(open_run(tmp_path / "cut"), open_run(tmp_path / "whole"), rel=1e-6)
