"""Resume of runs on another number of ranks."""

import shutil
import sys
from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from staffa.io.run_directory import open_run
from support.paths import TESTS
from support.restarting import assert_same, launch, small, whole_run

RANKS = """
import sys
from pathlib import Path
sys.path.insert(0, {tests!r})
from staffa.backend.stack import MPI
import numpy as np
from support.restarting import cut_run, small
from staffa.setup.build import body_of
from staffa.runs.resume import resume
from staffa.model.fields import linear_spaces, vertices
from staffa.model.numbering import Numbering
comm, base = MPI.COMM_WORLD, Path({base!r})
if {cuts}:
    cut_run(small(), base / f"from-{{comm.size}}", 12)
else:
    for ranks in (1, 2, 3):
        resume(base / f"from-{{ranks}}-to-{{comm.size}}")
for cells in ("quadrilateral", "triangle"):
    space = linear_spaces(body_of(small(f"domain.cells={{cells}}"), comm)).alpha
    numbering, points = Numbering(comm, space), vertices(space)
    own = space.dofmap.index_map.size_local
    assert np.array_equal(numbering.share(numbering.points), points[:own])
    if comm.rank == 0:
        np.save(base / f"{{cells}}-{{comm.size}}.npy", numbering.points)
"""


@pytest.mark.long
def test_what_some_ranks_began_any_others_finish(tmp_path: Path) -> None:
    """1, 2, 3 ranks to 1, 2, 3 ranks; and the order that this rests on is that of the mesh."""

    tests = str(TESTS)
    expected = whole_run(small(), tmp_path / "whole")
    for cuts in (True, False):
        for ranks in (1, 2, 3):
            code = RANKS.format(tests=tests, base=str(tmp_path), cuts=cuts)
            done = launch(Path(sys.executable).name, "-c", code, ranks=ranks)
            assert done.returncode == 0, done.stderr
        if cuts:
            for one in (1, 2, 3):
                found = open_run(tmp_path / f"from-{one}")
                assert 0 < len(found.steps) < len(expected.steps)
                for other in (1, 2, 3):
                    shutil.copytree(found.path, tmp_path / f"from-{one}-to-{other}")
    for one in (1, 2, 3):
        for other in (1, 2, 3):
            found = open_run(tmp_path / f"from-{one}-to-{other}")
            assert_same(found, expected, rel=1e-6)
            assert {"manifest": found.manifest.ranks} == {"manifest": other}
    for cells in ("quadrilateral", "triangle"):
        alone, *others = (np.load(tmp_path / f"{cells}-{n}.npy") for n in (1, 2, 3))
        for points in others:
            assert np.abs(points - alone).max() < 1e-12
