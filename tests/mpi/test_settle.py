"""First guesses from a coarser mesh, on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from fem.test_settle import plate
from support.bodies import RANKS, run
from support.ranks import printed_on

ON_RANKS = """
from fem.test_settle import plate
from support.bodies import run
from staffa.backend.stack import MPI
(step,) = run(plate(dT=9.0))
if MPI.COMM_WORLD.rank == 0:
    print(step.effort.guesses, step.sweeps, repr(step.energies.total), flush=True)
"""


@pytest.mark.slow
@pytest.mark.parametrize("ranks", RANKS)
def test_any_number_of_ranks_makes_the_same_guess(ranks: int) -> None:
    (expected,) = run(plate(dT=9.0))
    ((guesses, sweeps, energy),) = printed_on(ranks, ON_RANKS)
    assert (int(guesses), expected.effort.guesses) == (1, 1)
    assert abs(int(sweeps) - expected.sweeps) <= 1
    assert float(energy) == pytest.approx(expected.energies.total, rel=1e-6)
