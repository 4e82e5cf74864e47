"""The heat equation within the time loop, on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from fem.test_heat_march import FEELING, MANY, feeling_front, plate, quenched
from support.bodies import run
from support.ranks import printed_on


@pytest.mark.parametrize("ranks", MANY)
def test_ranks_give_the_serial_cracks_and_heat(ranks: int) -> None:
    code = """
from fem.test_heat_march import *
steps = run(plate(quenched(9.0, side="bottom", cracks=FEELING["bath"])))
from staffa.backend.stack import MPI
if MPI.COMM_WORLD.rank == 0:
    for step in steps:
        heat = step.heat
        print(step.energies.total, heat.stored, heat.entered["cracks"], heat.imbalance)
"""
    expected = run(plate(quenched(9.0, side="bottom", cracks=FEELING["bath"])))
    for step, line in zip(expected, printed_on(ranks, code), strict=True):
        total, stored, cracks, imbalance = (float(word) for word in line)
        assert total == pytest.approx(step.energies.total, rel=1e-5)
        assert stored == pytest.approx(step.heat.stored, rel=1e-5)
        assert cracks == pytest.approx(step.heat.entered["cracks"], rel=1e-4)
        assert imbalance < 1e-8


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize("ranks", [2, 3])
def test_any_number_of_ranks_goes_back_alike_where_heat_feels_the_cracks(ranks: int) -> None:
    code = """
from fem.test_heat_march import *
from staffa.backend.stack import MPI
steps = run(feeling_front())
if MPI.COMM_WORLD.rank == 0:
    for step in steps:
        print(step.index, step.returned is not None, step.energies.total, step.heat.stored)
"""
    expected, found = run(feeling_front()), printed_on(ranks, code)
    assert any(step.returned for step in expected)
    assert [(int(i), back) for i, back, *_ in found] == [
        (step.index, str(step.returned is not None)) for step in expected
    ]
    for step, (_, _, total, stored) in zip(expected, found, strict=True):
        assert float(total) == pytest.approx(step.energies.total, rel=1e-6)
        assert float(stored) == pytest.approx(step.heat.stored, rel=1e-6)
