"""Circulating water on several ranks: rank 0 owns the simulator, and tells the others."""

from pathlib import Path

import numpy as np
import pytest

from staffa.io.run_directory import Run, open_run
from staffa.runs.run import run
from support.circulation_cases import STRONG, wall
from support.ranks import printed_on

RUN = """
from pathlib import Path
from staffa.runs.resume import resume
from staffa.runs.run import Watcher, run
from support.circulation_cases import STRONG, wall
from support.restarting import After, stopped

directory, settings = Path({directory!r}), {settings!r}
if {cut}:
    stopped(lambda: run(wall(*settings), directory, watcher=Watcher(stop=After(4))))
    resume(directory)
else:
    run(wall(*settings), directory)
"""
# Rock that nothing breaks, with a linear problem: the water is what is compared.
PLAIN = (*STRONG, 'damage.split="none"')
TWO_WAYS = (*PLAIN, "reservoir.feedback=true")
SINGLE = (*PLAIN, 'reservoir.simulator="single"')


def on_ranks(ranks: int, directory: Path, settings: tuple[str, ...], *, cut: bool) -> None:
    """Run the case on some ranks; stop it within and go on where it is `cut`."""
    printed_on(ranks, RUN.format(directory=str(directory), settings=settings, cut=cut))


def assert_alike(one: Run, more: Run) -> None:
    """Require temperatures of the wells that differ by 1e-9 K at most, and the same rock."""
    for step, other in zip(one.steps, more.steps, strict=True):
        wells, others = step.heat.circulation.wells, other.heat.circulation.wells
        for name, well in wells.items():
            here = others[name]
            assert abs(here.T - well.T) <= 1e-9
            assert here.pressure == pytest.approx(well.pressure, rel=1e-12)
        assert other.energies.total == pytest.approx(step.energies.total, rel=1e-9)
    assert np.ptp([step.heat.circulation.wells["out"].T for step in one.steps]) > 1.0


@pytest.mark.parametrize("ranks", [2, 3])
def test_before_cracks_the_water_is_the_same(ranks: int, tmp_path: Path, darts_python) -> None:
    run(wall(*PLAIN), tmp_path / "one")
    on_ranks(ranks, tmp_path / "more", PLAIN, cut=False)
    assert_alike(open_run(tmp_path / "one"), open_run(tmp_path / "more"))


@pytest.mark.parametrize("ranks", [2, 3])
def test_a_fracture_that_opens_carries_the_same_water(
    ranks: int, tmp_path: Path, darts_python
) -> None:
    run(wall(*TWO_WAYS), tmp_path / "one")
    on_ranks(ranks, tmp_path / "more", TWO_WAYS, cut=False)
    one, more = open_run(tmp_path / "one"), open_run(tmp_path / "more")
    assert_alike(one, more)
    for step, other in zip(one.steps, more.steps, strict=True):
        assert other.heat.passes == step.heat.passes > 0
        mine, others = (s.heat.circulation.cracks.sides["bottom"] for s in (step, other))
        assert others.widest == pytest.approx(mine.widest, rel=1e-9)
        assert other.heat.shadow.wells["out"].T == step.heat.shadow.wells["out"].T


@pytest.mark.parametrize("ranks", [2, 3])
def test_stopped_and_resumed(ranks: int, tmp_path: Path) -> None:
    """In closed form, so that it runs where there is no simulator."""
    run(wall(*SINGLE), tmp_path / "whole")
    on_ranks(ranks, tmp_path / "cut", SINGLE, cut=True)
    assert_alike(open_run(tmp_path / "whole"), open_run(tmp_path / "cut"))


def test_a_rank_without_elements_sorts_no_cracks() -> None:
    """Three ranks share two elements."""
    printed = printed_on(3, EMPTY)
    assert printed == [["2.0"]] * len(printed) and printed


EMPTY = """
from staffa.backend.stack import MPI
import numpy as np
from staffa.evolution.coupling import Cracks
from staffa.evolution.cracks_in_cells import CracksInCells
from staffa.model.domain import block
from staffa.model.fields import spaces_on, vertices
from staffa.reservoir.grid import grid_around

domain = block(MPI.COMM_WORLD, size=(2.0, 1.0), h=1.0, cells="quadrilateral")
spaces, grid = spaces_on(domain), grid_around((0.0, 0.0), (2.0, 1.0), 1.0)
n = domain.mesh.topology.index_map(2).size_local
x = vertices(spaces.alpha)
cracks = Cracks(alpha=x[:, 0] / 2, u=np.zeros(2 * len(x)), volumes=lambda: np.ones(n))
print(CracksInCells(domain, spaces, grid, ())(cracks).volume.sum(), flush=True)
"""
