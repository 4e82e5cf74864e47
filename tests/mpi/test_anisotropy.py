"""Layered rock on several ranks, one of which may have no cells."""

from staffa.backend.stack import MPI

import numpy as np
import pytest

from fem.test_anisotropy import cooled, single
from support.bodies import RANKS, run
from support.ranks import printed_on

ON_RANKS = """
from support.bodies import run
from staffa.backend.stack import MPI
from fem.test_anisotropy import cooled

steps = run(cooled(MPI.COMM_WORLD))
if MPI.COMM_WORLD.rank == 0:
    for step in steps:
        print(step.energies.elastic, step.energies.surface)
"""


@pytest.mark.slow
@pytest.mark.parametrize("ranks", RANKS)
def test_layers_crack_on_many_ranks_as_on_one(ranks: int) -> None:
    alone = [[s.energies.elastic, s.energies.surface] for s in run(cooled(MPI.COMM_SELF))]
    assert alone[-1][1] > 0.1, "they crack"
    found = [[float(word) for word in line] for line in printed_on(ranks, ON_RANKS)]
    # What sums in another order leave after some sweeps.
    assert np.array(found) == pytest.approx(np.array(alone), rel=1e-8)


EMPTY = """
from support.bodies import run
from staffa.backend.stack import MPI
from fem.test_anisotropy import single

steps = run(single(MPI.COMM_WORLD))
if MPI.COMM_WORLD.rank == 0:
    print(steps[0].energies.elastic)
"""


@pytest.mark.slow
def test_a_rank_without_cells_has_no_rock() -> None:
    ((found,),) = printed_on(2, EMPTY)
    (alone,) = run(single(MPI.COMM_SELF))
    assert float(found) == pytest.approx(alone.energies.elastic, rel=1e-12)
