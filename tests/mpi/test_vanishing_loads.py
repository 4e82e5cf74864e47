"""A load that decays, on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from support.ranks import printed_on

RANKS = """
from staffa.backend.stack import MPI
from fem.test_vanishing_loads import *
steps = ran(body(SIZE, H, sides=pulled(lambda t: 10 ** (-6 * t)), times=(1.0, 2.0, 3.0),
                 material=strong("volumetric-deviatoric")))
sound(steps)
if MPI.COMM_WORLD.rank == 0:
    print(*(step.energies.elastic for step in steps))
"""


@pytest.mark.parametrize("ranks", [pytest.param(2, marks=pytest.mark.long), 3])
def test_ranks_meet_a_load_that_decays(ranks: int) -> None:
    (found,) = printed_on(ranks, RANKS)
    expected = [0.25 * 10 ** (-12 * number) for number in (1, 2, 3)]
    assert [float(value) for value in found] == pytest.approx(expected, rel=1e-5)
