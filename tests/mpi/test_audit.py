"""The audit of a run on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

from support.ranks import printed_on

RANKS = """
from staffa.backend.stack import MPI
from fem.test_audit import SPLIT, cooled, ran, said, warmer
words = "a state is not the one on record"
steps = ran(cooled(split=SPLIT), lambda system, index: warmer(system) if index == 0 else None)
named = said(steps, words)
sound = all(step.audit.violations == () for step in ran(cooled(split=SPLIT)))
if MPI.COMM_WORLD.rank == 0:
    print(*named, sound)
"""


def test_ranks_name_the_same() -> None:
    assert printed_on(2, RANKS) == [["1", "True"]]
