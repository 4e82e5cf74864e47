"""A run with every key of [forces], on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from support.ranks import printed_on

ON_RANKS = """
import sys, tempfile
from pathlib import Path
from staffa.backend.stack import MPI
from staffa.runs.run import run
from staffa.case.reading.read import parse_case
from fem.test_force_case import CASE
folder = MPI.COMM_WORLD.bcast(tempfile.mkdtemp() if MPI.COMM_WORLD.rank == 0 else None)
for step in run(parse_case(CASE), Path(folder) / "run"):
    e = step.energies
    if MPI.COMM_WORLD.rank == 0:
        assert not step.audit.violations
        print(repr(e.elastic), repr(e.surface), repr(e.loads))
"""


@pytest.mark.long
def test_a_run_with_all_of_it_on_ranks() -> None:
    """On 1, 2 and 3 ranks the same energies."""
    alone, *others = (np.array(printed_on(n, ON_RANKS), dtype=float) for n in (1, 2, 3))
    assert np.all(np.isfinite(alone)) and np.all(alone[:, 2] != 0)
    for found in others:
        assert found == pytest.approx(alone, rel=1e-6)
