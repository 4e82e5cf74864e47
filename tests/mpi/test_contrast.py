"""Stiff rock beside soft, on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from fem.test_contrast import SOFT
from support.ranks import printed_on

RANKS = """
from staffa.backend.stack import MPI
from fem.test_contrast import *
sides = (SideSupport(side="bottom", components={1: no_displacement}),
         SideSupport(side="top", components={1: lambda x, t: 0.1 * t}))
material = rock(E=layered, nu=0.0, Gc=1e6, ell=0.3)
system = build(problem := body((0.5, 1.0), 0.1, sides=sides, material=material,
                               displacement="iterative"))
(step,) = march(problem, system)
if MPI.COMM_WORLD.rank == 0:
    print(step.reactions["top"][1], len(step.audit.violations))
"""


@pytest.mark.parametrize("ranks", [pytest.param(2, marks=pytest.mark.long), 3])
def test_ranks_find_it_too(ranks: int) -> None:
    ((force, violations),) = printed_on(ranks, RANKS)
    assert float(force) == pytest.approx(SOFT * 0.1 / 0.2 * 0.5, rel=1e-3) and violations == "0"
