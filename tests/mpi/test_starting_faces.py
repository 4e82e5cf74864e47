"""Faces from which cracks start, on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from fem.test_starting_faces import FROM_BOTTOM, FROM_LEFT, FROM_TOP, measured
from support.ranks import printed_on

ON_RANKS = """
from staffa.backend.stack import MPI
from fem.test_starting_faces import FROM_BOTTOM, FROM_LEFT, FROM_TOP, measured
found = measured([*FROM_BOTTOM, *FROM_LEFT, *FROM_TOP], ("left", "top"), (0.1, 0.35))
if MPI.COMM_WORLD.rank == 0:
    print(found.tips, found.others, found.sections, sep="\\n")
"""


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [2, 3])
def test_cracks_have_the_same_faces_on_any_ranks(ranks: int) -> None:
    alone = measured([*FROM_BOTTOM, *FROM_LEFT, *FROM_TOP], ("left", "top"), (0.1, 0.35))
    assert [other.face for other in alone.others] == ["left", "top"]
    assert printed_on(ranks, ON_RANKS) == [
        str(part).split() for part in (alone.tips, alone.others, alone.sections)
    ]
