"""The heat equation on several ranks, one of which may own nothing."""

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from fem.test_heat import DT, RHO_C, mixed
from support.bodies import RANKS
from support.ranks import printed_on


@pytest.mark.parametrize("ranks", RANKS)
def test_ranks_give_the_serial_temperature_and_balance(ranks: int) -> None:
    code = """
from staffa.backend.stack import MPI
from fem.test_heat import mixed
body = mixed(comm=MPI.COMM_WORLD)
for time in (1e-4, 1e-3, 4e-3):
    heat = body.to(time)
    span = body.equation.span(body.T)
    if MPI.COMM_WORLD.rank == 0:
        print(heat.imbalance, heat.substeps, heat.stored, span, *heat.entered.values())
"""
    body = mixed()
    for time, line in zip((1e-4, 1e-3, 4e-3), printed_on(ranks, code), strict=True):
        heat = body.to(time)
        imbalance, substeps, *numbers = (float(word) for word in line)
        assert imbalance < 1e-8 and substeps == heat.substeps
        expected = [heat.stored, body.equation.span(body.T), *heat.entered.values()]
        assert numbers == pytest.approx(expected, rel=1e-7)


def test_a_rank_may_own_no_vertex() -> None:
    code = """
import warnings
warnings.simplefilter("error")
from fem.test_heat import *
conduction = Conduction(
    k=tensor(K, K), rho_c=RHO_C, initial=hot, sides=(Dirichlet(side="bottom", T=cold),)
)
body = Heated((1.0, 1.0), 1.0, conduction, comm=MPI.COMM_WORLD)
heat = body.to(1.0)
if MPI.COMM_WORLD.rank == 0:
    print(heat.imbalance, heat.stored)
"""
    ((imbalance, stored),) = printed_on(3, code)
    assert float(imbalance) < 1e-8 and float(stored) == pytest.approx(-DT * RHO_C, rel=0.2)
