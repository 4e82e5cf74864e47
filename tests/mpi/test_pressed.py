"""The note on pressed rock, on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

from support.ranks import printed_on

ON_RANKS = """
from staffa.backend.stack import MPI
from fem.test_pressed import PUSHED_BAR, ran
weak = "toughness.bands=[{lower=[0.48,0.0],upper=[0.52,0.3],factor=0.9}]"
for step in ran(PUSHED_BAR, "damage.split=none", "domain.h=0.04", "damage.ell=0.12", weak):
    if MPI.COMM_WORLD.rank == 0:
        print(step.index, *step.audit.notes)
"""


def test_the_note_is_the_same_on_any_ranks() -> None:
    """Its share and its place."""
    alone, *others = (printed_on(ranks, ON_RANKS) for ranks in (1, 2, 3))
    assert any("rock:" in line for line in alone)
    assert all(found == alone for found in others)
