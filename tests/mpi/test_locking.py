"""Quadratic elements on several ranks, and restarts on others."""

from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from fem.test_locking import plate
from staffa.io.run_directory import open_run
from support.ranks import printed_on
from support.restarting import assert_same, whole_run

RANKS = """
from pathlib import Path
from staffa.backend.stack import MPI
from support.restarting import cut_run
from fem.test_locking import plate
from staffa.runs.run import run
from staffa.runs.resume import resume
base, ranks = Path({base!r}), MPI.COMM_WORLD.size
run(plate("triangle"), base / f"on-{{ranks}}")
if ranks == 2:
    cut_run(plate("triangle"), base / "cut", 8)
else:
    resume(base / "cut")
"""


@pytest.mark.slow
def test_quadratic_elements_are_the_same_on_any_ranks(tmp_path: Path) -> None:
    """2 and 3 ranks as one; what 2 began 3 finish, though edges have no number in the mesh."""
    expected = whole_run(plate("triangle"), tmp_path / "on-1")
    for ranks in (2, 3):
        printed_on(ranks, RANKS.format(base=str(tmp_path)))
    for name in ("on-2", "on-3", "cut"):
        found = open_run(tmp_path / name)
        assert_same(found, expected, rel=1e-7)
        for one, other in zip(found.steps, expected.steps, strict=True):
            assert np.allclose(one.probed, other.probed, rtol=0, atol=1e-6)
