"""Heat with properties of temperature, on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from fem.test_heat_of_temperature import march_boiled
from support.ranks import printed_on


@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.long)])
def test_ranks_give_the_serial_heat(ranks: int) -> None:
    code = """
from fem.test_heat_of_temperature import march_boiled
found = march_boiled()
from staffa.backend.stack import MPI
if MPI.COMM_WORLD.rank == 0:
    for row in found:
        print(*row)
"""
    for expected, line in zip(march_boiled(), printed_on(ranks, code), strict=True):
        found = [float(word) for word in line]
        assert found[:2] == pytest.approx(expected[:2], rel=1e-8)
        assert found[2] < 1e-8
