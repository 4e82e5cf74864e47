"""Backtracking on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from fem.test_backtrack import front
from support.bodies import run
from support.ranks import printed_on

ON_RANKS = """
from fem.test_backtrack import front
from support.bodies import run
from staffa.backend.stack import MPI
steps = run(front())
if MPI.COMM_WORLD.rank == 0:
    for step in steps:
        print(step.index, step.returned is not None, repr(step.energies.total), flush=True)
"""


@pytest.mark.slow
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.long)])
def test_any_number_of_ranks_goes_back_alike(ranks: int) -> None:
    expected = run(front())
    found = printed_on(ranks, ON_RANKS)
    assert [(int(i), back) for i, back, _ in found] == [
        (step.index, str(step.returned is not None)) for step in expected
    ]
    energies = [step.energies.total for step in expected]
    assert [float(energy) for _, _, energy in found] == pytest.approx(energies, rel=1e-6)
