"""Eigenvalues of the second-order test on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from fem.test_stability import plate
from support.bodies import RANKS, run
from support.ranks import printed_on

ON_RANKS = """
from fem.test_stability import plate
from support.bodies import run
from staffa.backend.stack import MPI
for step in run(plate()):
    if MPI.COMM_WORLD.rank == 0:
        s = step.stability
        print(s.negative, repr(s.bifurcation), flush=True)
"""


@pytest.mark.slow
@pytest.mark.parametrize("ranks", RANKS)
def test_any_number_of_ranks_finds_the_same(ranks: int) -> None:
    expected = [step.stability for step in run(plate())]
    lines = printed_on(ranks, ON_RANKS)
    assert len(lines) == len(expected) == 2
    for (negative, bifurcation), s in zip(lines, expected, strict=True):
        assert int(negative) == s.negative
        assert float(bifurcation) == pytest.approx(s.bifurcation, rel=1e-3, abs=1e-4)
