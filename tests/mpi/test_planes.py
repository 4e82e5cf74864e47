"""Cells on planes of a mesh, on several ranks."""

from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from fem.test_planes import CELLS, words
from run.test_run import CASES as READY
from staffa.io.run_directory import Run, open_run
from support.bodies import RANKS, needs_gmsh
from support.ranks import printed_on, staffa_on

ON_RANKS = """
from staffa.backend.stack import MPI
from fem.test_planes import CELLS, words
for cells in CELLS:
    rows = words(cells)
    if MPI.COMM_WORLD.rank == 0:
        print(*rows, sep="\\n")
"""


@pytest.mark.slow
@pytest.mark.parametrize("ranks", RANKS)
def test_cells_are_the_same_on_any_ranks(ranks: int) -> None:
    alone = [row.split() for cells in CELLS for row in words(cells)]
    found = printed_on(ranks, ON_RANKS)
    assert found[::2] == alone[::2], "numbers, sides, ends and junctions"
    for here, there in zip(alone[1::2], found[1::2], strict=True):
        assert list(map(float, there)) == pytest.approx(list(map(float, here)), rel=1e-3)


FEW_COLUMNS = [
    *("--set", "domain.size=[1.2, 1.2, 0.6]", "--set", "domain.h=0.1"),
    *("--set", "time.tau=[0.3, 0.6]", "--set", "output.at=[]"),
    *("--set", "measures.depths=[0.1, 0.2, 0.25]", "--set", "temperature.severity=4.77"),
]


@pytest.fixture(scope="module")
def alone(tmp_path_factory) -> Run:
    return few_columns(1, tmp_path_factory.mktemp("columns") / "run")


def few_columns(ranks: int, directory: Path) -> Run:
    """The ready case, smaller: its unstructured cells, its seed, its solvers and tolerances."""
    settings = [*FEW_COLUMNS, "--out", directory, "--quiet"]
    staffa_on(ranks, "run", READY / "brick.toml", *settings)
    return open_run(directory)


@needs_gmsh
@pytest.mark.slow
@pytest.mark.parametrize("ranks", [pytest.param(2, marks=pytest.mark.long), 3])
def test_columns_of_a_seed_are_the_same_on_any_ranks(alone: Run, ranks: int, tmp_path) -> None:
    numbers = {section.number for section in alone.steps[-1].measures.cells}
    assert numbers == {0, 1, 2}, "above all is broken, below a crack divides, deeper nothing does"
    found = few_columns(ranks, tmp_path / "run")
    for one, other in zip(alone.steps, found.steps, strict=True):
        assert other.energies.total == pytest.approx(one.energies.total, rel=1e-6)
        pairs = zip(one.measures.cells, other.measures.cells, strict=True)
        for cells, same in pairs:
            assert (same.number, same.sides) == (cells.number, cells.sides)
            assert same.areas == pytest.approx(cells.areas, rel=1e-3)
