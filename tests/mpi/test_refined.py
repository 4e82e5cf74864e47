"""A mesh that follows the cracks, on several ranks: the same mesh, cracks and energies."""

import shutil
from functools import cache
from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from staffa.io.run_directory import Run, open_run
from support.bodies import RANKS
from support.ranks import waiting
from support.refining import cells_of, mean_edge_of_crossed, refining
from support.restarting import assert_same, whole_run

FINEST = mean_edge_of_crossed(1 / 32)
SHORT = "time.tau=[0.002,0.2]"
CASES = {
    "plain": (),
    "heat": (
        "temperature={profile='heat'}",
        "heat={initial=0.0,bottom={T=-20.0}}",
        "time={t=[0.001,0.01]}",
    ),
    "contact": (SHORT, "damage.split=contact"),
    "quadratic": (SHORT, "domain.elements=quadratic"),
    "returns": (SHORT, "solver.backtracking=true"),
}
FURTHER = [pytest.param(name, marks=pytest.mark.long) for name in CASES if name != "plain"]

RUN = """
from pathlib import Path
from staffa.backend.stack import MPI
from staffa.runs.run import run
from support.refining import refining
run(refining(*{settings!r}), Path({folder!r}))
"""
CUT = """
from pathlib import Path
from staffa.backend.stack import MPI
from support.refining import refining
from support.restarting import cut_run
cut_run(refining(), Path({folder!r}), {looks})
"""
RESUME = """
from pathlib import Path
from staffa.backend.stack import MPI
from staffa.runs.resume import resume
resume(Path({folder!r}))
"""


@pytest.fixture(scope="module")
def alone(tmp_path_factory):
    """Returns the run of a case on one rank."""
    folder = tmp_path_factory.mktemp("alone")

    @cache
    def found(name: str) -> Run:
        return whole_run(refining(*CASES[name]), folder / name)

    return found


def assert_agree(many: Run, one: Run) -> None:
    """Energies to 1e-6, counts of cracks, and the cells: the same mesh in whatever order."""
    assert many.finished and len(many.steps) == len(one.steps)
    assert len({step.mesh.cells for step in one.steps}) > 1, "the mesh changes in it"
    for a, b in zip(one.steps, many.steps, strict=True):
        assert b.energies.total == pytest.approx(a.energies.total, rel=1e-6)
        assert b.energies.surface == pytest.approx(a.energies.surface, rel=1e-6)
        assert [s.cracks for s in a.measures.sections] == [s.cracks for s in b.measures.sections]
        assert len(a.measures.tips) == len(b.measures.tips)
        assert (a.mesh.cells, a.mesh.vertices) == (b.mesh.cells, b.mesh.vertices)
        here, there = (cells_of(run, step.fields, FINEST) for run, step in ((one, a), (many, b)))
        assert np.abs(here.middles - there.middles).max() < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("ranks", RANKS)
@pytest.mark.parametrize("name", ["plain", *FURTHER])
def test_the_mesh_is_the_same_on_any_ranks(ranks: int, name: str, alone, tmp_path: Path) -> None:
    folder = tmp_path / "run"
    waiting(ranks).run(RUN.format(settings=CASES[name], folder=str(folder)))
    assert_agree(open_run(folder), alone(name))


@pytest.mark.slow
def test_what_two_ranks_began_one_and_three_finish(alone, tmp_path: Path) -> None:
    """Stopped after the mesh has changed; the checkpoint holds it."""
    began = tmp_path / "two"
    waiting(2).run(CUT.format(folder=str(began), looks=25))
    steps = open_run(began).steps
    assert 0 < len(steps) < len(alone("plain").steps)
    for ranks in (1, 3):
        folder = tmp_path / f"on-{ranks}"
        shutil.copytree(began, folder)
        waiting(ranks).run(RESUME.format(folder=str(folder)))
        found = open_run(folder)
        assert found.manifest.ranks == ranks
        assert_same(found, alone("plain"), rel=1e-6)
        assert_agree(found, alone("plain"))
