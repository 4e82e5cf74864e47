"""Rock whose properties depend on temperature, on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from fem.test_temperature_properties import surfaces_of_cracking
from support.ranks import printed_on


@pytest.mark.long
@pytest.mark.parametrize("ranks", [2, 3])
def test_ranks_give_the_serial_cracks(ranks: int, tmp_path) -> None:
    code = f"""
from fem.test_temperature_properties import surfaces_of_cracking
found = surfaces_of_cracking("{tmp_path / "ranks"}")
from staffa.backend.stack import MPI
if MPI.COMM_WORLD.rank == 0:
    for row in found:
        print("found", *row)
"""
    serial = surfaces_of_cracking(tmp_path / "serial")
    lines = [line[1:] for line in printed_on(ranks, code) if line[:1] == ["found"]]
    for expected, line in zip(serial, lines, strict=True):
        assert [float(word) for word in line] == pytest.approx(expected, rel=1e-5)
