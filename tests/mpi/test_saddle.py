"""Even rock on several ranks: the same escapes, the same energies."""

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from fem.test_saddle import SMALL, even
from support.bodies import RANKS, run
from support.ranks import printed_on

SCRIPT = """
from staffa.backend.stack import MPI
from fem.test_saddle import SMALL, even
from support.bodies import run
steps = run(even("triangle", *SMALL))
if MPI.COMM_WORLD.rank == 0:
    print(*(repr(s.energies.total) for s in steps), sum(s.curvature.escapes for s in steps))
"""


@pytest.mark.parametrize("ranks", RANKS)
def test_even_rock_cracks_alike_on_several_ranks(ranks: int) -> None:
    steps = run(even("triangle", *SMALL))
    ((*words, escapes),) = printed_on(ranks, SCRIPT)
    energies = [float(word) for word in words]
    assert int(escapes) == sum(step.curvature.escapes for step in steps) > 0
    assert energies == pytest.approx([s.energies.total for s in steps], rel=1e-4)
