"""A band that ends on middles of cells, on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from fem.test_places import scaled_energies
from support.ranks import printed_on

RANKS = """
from staffa.backend.stack import MPI
from fem.test_places import scaled_energies
found = scaled_energies(3.3)
if MPI.COMM_WORLD.rank == 0:
    print(*map(repr, found))
"""


def test_ranks_agree_where_a_band_ends_on_middles_of_cells() -> None:
    (found,) = printed_on(2, RANKS)
    assert list(map(float, found)) == pytest.approx(scaled_energies(), rel=1e-10)
