"""Local edges of meshes on several ranks."""

from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from fem.test_local_edges import PULLED, folder
from staffa.case.reading.read import read_case
from staffa.io.run_directory import open_run
from staffa.results.summary import summary
from staffa.runs.run import run
from support.bodies import RANKS, needs_gmsh
from support.ranks import printed_on

COARSE = """
from pathlib import Path
from staffa.backend.stack import MPI
from staffa.case.reading.read import read_case
from staffa.runs.run import run
from staffa.backend.parallel import on_root
comm = MPI.COMM_WORLD
case = on_root(comm, lambda: read_case(Path({path!r})))
step, = run(case, Path({out!r}), comm=comm)
m = step.measures
if comm.rank == 0:
    print(m.length_surface, m.coarse.share, m.coarse.edge, *m.coarse.place, m.coarse.region)
"""


@needs_gmsh
@pytest.mark.parametrize("ranks", RANKS)
def test_cracks_in_cells_that_are_too_long_are_told_after_the_run(tmp_path: Path, ranks) -> None:
    here = folder(tmp_path, "0.03 + 0.1*(y - 2)")
    (here / "my.toml").write_text(PULLED.replace("ell = 0.06", "ell = 0.12"))
    (step,) = run(read_case(here / "my.toml"), tmp_path / "run")
    found = step.measures.coarse
    assert found.region == "sand" and found.place[1] > 2.5 and found.edge > 0.04
    (fact,) = [f for f in summary(open_run(tmp_path / "run")) if f.name == "cells too long"]
    assert fact.alarm and "in region 'sand', at (" in fact.text and "mesh it finer" in fact.text
    one = [step.measures.length_surface, found.share, found.edge, *found.place]
    ((*numbers, region),) = printed_on(
        ranks, COARSE.format(path=str(here / "my.toml"), out=str(tmp_path / "many"))
    )
    assert [float(n) for n in numbers] == pytest.approx(one, rel=1e-6) and region == "sand"
