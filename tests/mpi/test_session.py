"""A session whose mesh changes, on several ranks."""

from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from fem.test_session import FEW, run_with_change
from support.bodies import RANKS
from support.ranks import printed_on

ON_RANKS = """
from pathlib import Path
from staffa.backend.stack import MPI
from fem.test_session import FEW, run_with_change
run = run_with_change(Path({folder!r}), *FEW, after=0)
if MPI.COMM_WORLD.rank == 0:
    for step in run.steps:
        print(step.energies.total, step.measures.length_surface, *step.probed[0])
"""


@pytest.mark.slow
@pytest.mark.parametrize("ranks", RANKS)
def test_the_mesh_changes_on_any_ranks(ranks: int, tmp_path: Path) -> None:
    alone = [
        [step.energies.total, step.measures.length_surface, *step.probed[0]]
        for step in run_with_change(tmp_path / "alone", *FEW, after=0).steps
    ]
    found = printed_on(ranks, ON_RANKS.format(folder=str(tmp_path / "found")))
    assert np.array(found, dtype=float) == pytest.approx(np.array(alone), rel=1e-4, abs=1e-5), (
        "to the stop of the minimization"
    )
