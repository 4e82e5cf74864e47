"""Cracks whose faces touch, on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from fem.test_contact import pressed, steps_of
from support.bodies import RANKS
from support.ranks import printed_on

RANKED = """
from fem.test_contact import pressed, steps_of
from staffa.backend.stack import MPI
steps = steps_of(pressed(0.3, "[0.5,1.0]"))
if MPI.COMM_WORLD.rank == 0:
    for step in steps:
        print(repr(step.energies.elastic), repr(step.energies.friction))
"""


@pytest.mark.slow
@pytest.mark.parametrize("ranks", RANKS)
def test_the_same_on_any_number_of_ranks(ranks: int) -> None:
    """Elastic energy and the work of friction."""
    one = steps_of(pressed(0.3, "[0.5,1.0]"))
    for step, words in zip(one, printed_on(ranks, RANKED), strict=True):
        energies = (step.energies.elastic, step.energies.friction)
        assert [float(word) for word in words] == pytest.approx(energies, rel=1e-7)
