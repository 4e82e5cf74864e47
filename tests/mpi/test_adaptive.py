"""Steps that follow the cracks, on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from fem.test_adaptive import plate
from support.bodies import RANKS, run
from support.ranks import printed_on


@pytest.mark.slow
@pytest.mark.parametrize("ranks", RANKS)
def test_ranks_take_the_same_steps(ranks: int) -> None:
    code = (
        "from fem.test_adaptive import *\n"
        "from staffa.backend.stack import MPI\n"
        "for s in run(plate()):\n"
        "    if MPI.COMM_WORLD.rank == 0: print(s.status, s.time, s.energies.total)"
    )
    alone = [(s.status, s.time, s.energies.total) for s in run(plate())]
    found = [(w[0], float(w[1]), float(w[2])) for w in printed_on(ranks, code)]
    assert [f[0] for f in found] == [a[0] for a in alone]
    for k in (1, 2):
        assert [f[k] for f in found] == pytest.approx([a[k] for a in alone], rel=1e-6)
