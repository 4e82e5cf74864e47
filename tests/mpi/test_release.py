"""Energy release rates on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from support.bodies import RANKS
from support.ranks import printed_on


@pytest.mark.parametrize("ranks", RANKS)
def test_many_ranks_find_what_one_finds(ranks: int) -> None:
    code = (
        "from fem.test_release import LOADS, notched\n"
        "from staffa.backend.stack import MPI\n"
        "(tip,) = notched(0.4, h=0.04, ell=0.08, **LOADS['cooled']).tips\n"
        "if MPI.COMM_WORLD.rank == 0: print(repr(tip.G), *map(repr, tip.position))"
    )
    (alone,), (together,) = printed_on(1, code), printed_on(ranks, code)
    assert list(map(float, together)) == pytest.approx(list(map(float, alone)), rel=1e-6)
