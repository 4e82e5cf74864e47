"""A body that comes apart, on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from support.ranks import printed_on

RANKS = """
from staffa.backend.stack import MPI
from fem.test_parted import *
said = ends(cut_bar(forces=pull(1.0)))
if MPI.COMM_WORLD.rank == 0:
    print(said)
"""


@pytest.mark.parametrize("ranks", [pytest.param(2, marks=pytest.mark.long), 3])
def test_ranks_tell_of_the_same_part(ranks: int) -> None:
    (found,) = printed_on(ranks, RANKS)
    assert "around (0.775, 0.1), 48% of the body" in " ".join(found)
